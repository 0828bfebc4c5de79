// Keys for the whole page. They are off while the operator types, and while a control uses the key.

import { ACTIONS, perform } from "./actions.js";
import { at, button, dialogOf, el } from "./dom.js";
import { toNext, toPrevious } from "./changes.js";
import { toDifference } from "./compare.js";
import { setCursor } from "./cursors.js";
import { field } from "./find.js";
import { isClicked } from "./pointer.js";
import { menuAt } from "./menu.js";
import { toMark } from "./marks.js";
import { tell } from "./notice.js";
import { takesTyped } from "./rungedit.js";
import { moveRung } from "./program.js";
import { moveBy } from "./scrub.js";
import { step, toggle } from "./transport.js";
import { select, selected } from "./selection.js";
import { subjectNow } from "./subject.js";
import { forceSelected } from "./tag.js";
import { run } from "./state.js";
import { zoom } from "./strip.js";

const second = () => Math.round(1e9 / (run.hello?.period_ns ?? 2e6));

const PARTS = ["bar", "edit", "program", "machine", "tag", "lists", "strip"];

// Key, function, text in the help, and name of the key in the help.
const ROWS = [
  [" ", toggle, "pause, continue", "space"],
  [".", step, "one scan forward"],
  [",", () => moveBy(-1), "one scan back"],
  ["[", () => moveBy(-second()), "one second back"],
  ["]", () => moveBy(second()), "one second forward"],
  ["ArrowLeft", () => moveBy(-10), "ten scans back; in a rung, the previous instruction", "←"],
  ["ArrowRight", () => moveBy(10), "ten scans forward; in a rung, the next instruction", "→"],
  ["ArrowUp", () => moveRung(-1), "the rung above", "↑"],
  ["ArrowDown", () => moveRung(1), "the rung below", "↓"],
  ["m", () => menuAt(document.activeElement), "menu of the contact, coil, block or rung with the focus"],
  ...ACTIONS.map(action => [action.key, () => act(action), action.says]),
  ["f", forceSelected, "force the selected tag, or remove its force"],
  ["p", () => toPrevious(selected.tag), "previous change of the selected tag"],
  ["n", () => toNext(selected.tag), "next change of the selected tag"],
  ["+", () => zoom(-1), "zoom in on the strip"],
  ["-", () => zoom(1), "zoom out of the strip"],
  ["c", setCursor, "cursor A at the scan shown, then B, then none"],
  ["e", () => toMark(1), "next mark of a recording: error, fault, rule, mode change or restart"],
  ["E", () => toMark(-1), "previous mark of a recording"],
  ["d", () => toDifference(1), "next difference in a comparison"],
  ["D", () => toDifference(-1), "previous difference in a comparison"],
  ["/", () => field.select(), "find"],
  ["F6", event => toPart(event.shiftKey ? -1 : 1), "next part of the page; with Shift, the previous part"],
  ["Escape", () => select({}), "select nothing", "Esc"],
  ["?", () => help(), "this help"],
];
const KEYS = Object.fromEntries(ROWS.map(([key, handle]) => [key, handle]));

// Carries out an action on the focused item, otherwise on the selection.
function act(action) {
  const obstacle = perform(action, subjectNow());
  if (obstacle) tell(obstacle);
}

const dialog = dialogOf("Keys", "Close help");
const help = () =>
  dialog.open(
    el(
      "dl",
      { class: "keys" },
      ...ROWS.flatMap(([key, , says, called = key]) => [el("dt", {}, el("kbd", {}, called)), el("dd", {}, says)])
    )
  );

export const helpButton = () => button("Keys", help, { text: "?", title: "Keys (?)", class: "sign" });

// Moves the focus to the first control of the next visible part.
function toPart(by) {
  const parts = PARTS.map(at).filter(part => part?.checkVisibility()),
    here = parts.findIndex(part => part.contains(document.activeElement)),
    next = parts[(Math.max(here, by > 0 ? -1 : 0) + by + parts.length) % parts.length];
  const controls = [...next.querySelectorAll("button, input, select, summary, [tabindex]")];
  (controls.find(control => control.tabIndex >= 0 && !control.disabled && control.checkVisibility()) ?? next).focus();
}

function isBusy(event) {
  const { target } = event;
  if (event.key === "F6") return Boolean(document.querySelector("dialog[open]"));
  if (document.querySelector("dialog[open]") || event.ctrlKey || event.metaKey || event.altKey) return true;
  if (target.matches("input, select, textarea") && event.key === "Escape") target.blur();
  if (target.matches("input, select, textarea"))
    return !(target.type === "range" && KEYS[event.key] && !event.key.startsWith("Arrow"));
  if (target.closest(".chart")) return event.key.startsWith("Arrow");
  return event.key === " " && !isClicked(target) && target.matches("button, [role=button], summary, a");
}

document.addEventListener("keydown", event => {
  if (takesTyped(event)) return event.preventDefault();
  const handle = KEYS[event.key];
  if (!handle || isBusy(event) || !run.hello || event.defaultPrevented) return;
  event.preventDefault();
  handle(event);
});
