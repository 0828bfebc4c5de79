// A sequential function chart: drawn once by the server; active steps, actions that are on and true transitions are
// lit by the values of their tags.

import { drawing, el } from "./dom.js";
import { shown } from "./format.js";
import { pressable } from "./pointer.js";
import { select } from "./selection.js";
import { place } from "./values.js";

export function buildSteps({ chart, notes = [] }) {
  const picture = drawing(chart);
  for (const group of picture.querySelectorAll(".element")) prepare(group);
  for (const value of picture.querySelectorAll("[data-value-of]"))
    place(value, value.dataset.valueOf, each => `${shown(each)} ms`);
  return el("div", { class: "steps", tabindex: "0", role: "region", "aria-label": "Sequential function chart" },
    ...notes.map(text => el("p", { class: "comment" }, text)), picture);
}

function prepare(group) {
  const { lit, at } = group.dataset;
  pressable(group, () => select({ tag: lit || null, rung: at, names: lit ? [lit] : [] }));
  if (lit) place(group, lit, () => null); // the style sheet lights it by data-value
}
