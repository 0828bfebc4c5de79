// A function block diagram: drawn once by the server; wires and references of bits are lit, pins show their values.

import { drawing, el } from "./dom.js";
import { shown } from "./format.js";
import { pressable } from "./pointer.js";
import { select } from "./selection.js";
import { place } from "./values.js";

// A value at a pin; a limit that is the largest REAL has no room for its digits.
const short = value => (Math.abs(value) >= 1e10 ? value.toExponential(4) : shown(value));

export function buildDiagram({ diagram }) {
  const picture = drawing(diagram);
  for (const group of picture.querySelectorAll(".element")) prepare(group);
  // lit by data-value
  for (const lit of picture.querySelectorAll("[data-lit]")) place(lit, lit.dataset.lit, () => null);
  for (const value of picture.querySelectorAll("[data-value-of]")) place(value, value.dataset.valueOf, short);
  return el("div", { class: "steps", tabindex: "0", role: "region", "aria-label": "Function block diagram" }, picture);
}

// A click chooses the tag of a reference, or that of a block with the values at its pins.
function prepare(group) {
  const names = [...group.querySelectorAll("[data-value-of]")].map(each => each.dataset.valueOf);
  const single = group.matches(".block") ? null : names[0] ?? group.dataset.lit ?? null;
  pressable(group, () => select({ tag: single, rung: group.dataset.at, names }));
}
