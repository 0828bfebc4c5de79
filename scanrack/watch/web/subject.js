// What the pointer is at, or what has the focus: a tag, the operands of its block, its rung or line.

import { addressOf } from "./values.js";
import { selected } from "./selection.js";

const PLACES = ".instruction, .element, .chip, .bit, tr.tag, .stop";

// { tag, names, rung, element, node } of a node, or null; `node` takes the focus.
export function subjectOf(place) {
  const node = place?.closest?.(PLACES), row = place?.closest?.("[data-at]");
  if (!node && !row) return null;
  const names = namesAt(node), own = operandAt(place) ?? node?.dataset.tag ?? names[0];
  // 1.MOVING_CW is not the name of a tag
  const tag = !own || node.dataset.instruction === "JSR" ? null : /^\d+\./.test(own) ? addressOf(own) : own;
  return {
    tag,
    names,
    rung: row?.dataset.at ?? null,
    element: node?.dataset.element ?? null,
    node: node ?? row.querySelector(".stop") ?? row,
  };
}

// What has the focus, or else what is selected.
export const subjectNow = () => subjectOf(document.activeElement) ?? { ...selected, node: null };

export const namesOf = group => (group.dataset.names ? group.dataset.names.split("\n") : []);

function namesAt(node) {
  if (!node || node.matches(".stop")) return [];
  if (node.dataset.tag) return [...new Set([node.dataset.tag, ...namesOf(node)])];
  const name = node.dataset.lit ?? node.dataset.name ?? node.querySelector("[data-name]")?.dataset.name;
  return name ? [name] : [];
}

// The tag of the operand of a block under the pointer; the node of its value comes after it.
function operandAt(place) {
  for (let node = place.closest("text"); node; node = node.nextElementSibling) {
    if (node.dataset.name) return node.dataset.name;
    if (node !== place && node.matches(".caption")) return null;
  }
  return null;
}
