// Keys for the whole page; they rest while something is typed or a control has a use for the key.

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

// A key, what it does, how the help says so, and how it calls the key.
const ROWS = [
  [" ", toggle, "pause, continue", "space"],
  [".", step, "one scan on"],
  [",", () => moveBy(-1), "one scan back"],
  ["[", () => moveBy(-second()), "one second back"],
  ["]", () => moveBy(second()), "one second on"],
  ["ArrowLeft", () => moveBy(-10), "ten scans back; in a rung the instruction before", "←"],
  ["ArrowRight", () => moveBy(10), "ten scans on; in a rung the next instruction", "→"],
  ["ArrowUp", () => moveRung(-1), "the rung above", "↑"],
  ["ArrowDown", () => moveRung(1), "the rung below", "↓"],
  ["m", () => menuAt(document.activeElement), "menu of the contact, coil, block or rung with the focus"],
  ...ACTIONS.map(action => [action.key, () => act(action), action.says]),
  ["f", forceSelected, "force the selected tag, or remove its force"],
  ["p", () => toPrevious(selected.tag), "the previous change of the selected tag"],
  ["n", () => toNext(selected.tag), "its next change"],
  ["+", () => zoom(-1), "less time in the strip, larger"],
  ["-", () => zoom(1), "more time in the strip"],
  ["c", setCursor, "cursor A at the scan shown, then B, then none"],
  ["e", () => toMark(1), "the next mark of a recording: an error, a fault, a rule, another mode, a restart"],
  ["E", () => toMark(-1), "the mark before"],
  ["d", () => toDifference(1), "the next difference from the recording compared with"],
  ["D", () => toDifference(-1), "the previous difference"],
  ["/", () => field.select(), "find"],
  ["F6", event => toPart(event.shiftKey ? -1 : 1), "the next part of the page, with Shift the one before"],
  ["Escape", () => select({}), "select nothing", "Esc"],
  ["?", () => help(), "this help"],
];
const KEYS = Object.fromEntries(ROWS.map(([key, does]) => [key, does]));

// Does it to what has the focus, or else to what is selected.
function act(action) {
  const lack = perform(action, subjectNow());
  if (lack) tell(lack);
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

// Gives the focus to the first control of another part that is shown.
function toPart(by) {
  const parts = PARTS.map(at).filter(part => part?.checkVisibility()),
    here = parts.findIndex(part => part.contains(document.activeElement)),
    next = parts[(Math.max(here, by > 0 ? -1 : 0) + by + parts.length) % parts.length];
  const controls = [...next.querySelectorAll("button, input, select, summary, [tabindex]")];
  (controls.find(each => each.tabIndex >= 0 && !each.disabled && each.checkVisibility()) ?? next).focus();
}

function isBusy(event) {
  const on = event.target;
  if (event.key === "F6") return Boolean(document.querySelector("dialog[open]"));
  if (document.querySelector("dialog[open]") || event.ctrlKey || event.metaKey || event.altKey) return true;
  if (on.matches("input, select, textarea") && event.key === "Escape") on.blur(); // then for the page
  if (on.matches("input, select, textarea"))
    return !(on.type === "range" && KEYS[event.key] && !event.key.startsWith("Arrow"));
  if (on.closest(".chart")) return event.key.startsWith("Arrow");
  return event.key === " " && !isClicked(on) && on.matches("button, [role=button], summary, a");
}

document.addEventListener("keydown", event => {
  if (takesTyped(event)) return event.preventDefault();
  const known = KEYS[event.key];
  if (!known || isBusy(event) || !run.hello || event.defaultPrevented) return;
  event.preventDefault();
  known(event);
});
