// Keys for the whole page; they rest while something is typed or a control has a use for the key.

import { button, el } from "./dom.js";
import { toNext, toPrevious } from "./changes.js";
import { toDifference } from "./compare.js";
import { setCursor } from "./cursors.js";
import { field } from "./find.js";
import { isClicked } from "./pointer.js";
import { toggleBreakpoint, moveRung } from "./program.js";
import { moveBy } from "./scrub.js";
import { step, toggle } from "./transport.js";
import { select, selected } from "./selection.js";
import { forceSelected } from "./tag.js";
import { run } from "./state.js";

const second = () => Math.round(1e9 / (run.hello?.period_ns ?? 2e6));

// key: what it does, and how the help says so
const KEYS = {
  " ": [toggle, "space", "pause, go on"],
  ".": [step, ".", "one scan on"],
  ",": [() => moveBy(-1), ",", "one scan back"],
  "[": [() => moveBy(-second()), "[", "one second back"],
  "]": [() => moveBy(second()), "]", "one second on"],
  ArrowLeft: [() => moveBy(-10), "←", "ten scans back"],
  ArrowRight: [() => moveBy(10), "→", "ten scans on"],
  ArrowUp: [() => moveRung(-1), "↑", "the rung above"],
  ArrowDown: [() => moveRung(1), "↓", "the rung below"],
  p: [() => toPrevious(selected.tag), "p", "the previous change of the selected tag"],
  n: [() => toNext(selected.tag), "n", "its next change"],
  c: [setCursor, "c", "cursor A at the scan shown, then B, then none"],
  d: [() => toDifference(1), "d", "the next difference from the recording compared with"],
  D: [() => toDifference(-1), "D", "the previous difference"],
  f: [forceSelected, "f", "force the selected tag, or remove its force"],
  b: [toggleBreakpoint, "b", "breakpoint on the selected rung"],
  "/": [() => field.focus(), "/", "find"],
  Escape: [() => select({}), "Esc", "select nothing"],
  "?": [() => help.showModal(), "?", "this help"],
};

const help = el("dialog", { "aria-label": "Keys" },
  el("h2", {}, "Keys"),
  el("dl", { class: "keys" }, ...Object.values(KEYS).flatMap(([, key, says]) => [el("dt", {}, el("kbd", {}, key)), el("dd", {}, says)])),
  el("form", { method: "dialog" }, el("button", { "aria-label": "Close help" }, "Close")));

export function helpButton() {
  if (!help.isConnected) document.body.append(help);
  return button("Keys", () => help.showModal(), { text: "?", title: "Keys (?)", class: "sign" });
}

function isBusy(event) {
  const on = event.target;
  if (document.querySelector("dialog[open]") || event.ctrlKey || event.metaKey || event.altKey) return true;
  if (on.matches("input, select, textarea")) return !(on.type === "range" && KEYS[event.key] && !event.key.startsWith("Arrow"));
  if (on.closest(".chart")) return event.key.startsWith("Arrow");
  return event.key === " " && !isClicked(on) && on.matches("button, [role=button], summary, a");
}

document.addEventListener("keydown", event => {
  const known = KEYS[event.key];
  if (!known || isBusy(event) || !run.hello || event.defaultPrevented) return;
  event.preventDefault();
  known[0]();
});
