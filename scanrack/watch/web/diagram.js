// Function block diagrams and sequential function charts: the server draws them, and values of tags light them.

import { drawing, el } from "./dom.js";
import { shown } from "./format.js";
import { pressable } from "./pointer.js";
import { select } from "./selection.js";
import { bindValue } from "./values.js";

// A value at a pin, short enough even for the largest REAL.
const short = value => (Math.abs(value) >= 1e10 ? value.toExponential(4) : shown(value));

// A click selects the tag of a reference, or a block with the values at its pins.
export const buildDiagram = ({ diagram }) => built(diagram, "Function block diagram", short, group => {
  const names = [...group.querySelectorAll("[data-value-of]")].map(node => node.dataset.valueOf);
  return { tag: group.matches(".block") ? null : names[0] ?? group.dataset.lit ?? null, names };
});

// Lights active steps, actions that are on, and true transitions.
export const buildChart = ({ chart, notes = [] }) =>
  built(chart, "Sequential function chart", value => `${shown(value)} ms`, ({ dataset: { lit } }) =>
    ({ tag: lit || null, names: lit ? [lit] : [] }), notes);

function built(text, title, say, chosenAt, notes = []) {
  const picture = drawing(text);
  for (const group of picture.querySelectorAll(".element"))
    pressable(group, () => select({ ...chosenAt(group), rung: group.dataset.at }));
  for (const node of picture.querySelectorAll("[data-lit]:not([data-lit=''])"))
    bindValue(node, node.dataset.lit, () => null); // the style sheet lights it by data-value
  for (const value of picture.querySelectorAll("[data-value-of]")) bindValue(value, value.dataset.valueOf, say);
  return el("div", { class: "steps", tabindex: "0", role: "region", "aria-label": title },
    ...notes.map(note => el("p", { class: "comment" }, note)), picture);
}
