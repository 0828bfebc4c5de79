// The present state of a block: the text of its first state with a true condition, with values of tags.

import { setText } from "./dom.js";
import { count, shown } from "./format.js";
import { run } from "./state.js";
import { valueOf } from "./values.js";

const REFERENCE = /\{([^}]+?)(?::s(\d*))?\}/g; // {Out.ACC}; in seconds {Out.ACC:s} of ms, {T4:0.ACC:s10} of 10 ms

const POWER = "*"; // the condition that the block has power

let blocks = []; // { node, states, names, group }

// Shows the states of the blocks of a new picture.
export function beginNow(root) {
  blocks = [...root.querySelectorAll("[data-now]")].map(node => {
    const states = JSON.parse(node.dataset.now);
    return {
      node,
      states,
      group: node.closest("[data-element]"),
      names: new Set(states.flatMap(([when, text]) => [when, ...[...text.matchAll(REFERENCE)].map(match => match[1])])),
    };
  });
  for (const block of blocks) showState(block);
}

// Updates the states after a change of tags and of the power of rungs.
export function paintNow(tags, power) {
  const changed = Object.keys(tags ?? {}), lit = new Set(Object.keys(power ?? {}));
  if (changed.length || lit.size)
    for (const block of blocks) {
      const isLit = block.names.has(POWER) && lit.has(rungOf(block.group));
      if (isLit || changed.some(name => block.names.has(name))) showState(block);
    }
}

const rungOf = group => group.dataset.element.slice(0, group.dataset.element.lastIndexOf("."));

// Returns the first state with a true condition; null while the condition of an earlier one is unknown.
function stateOf({ states, group }) {
  for (const state of states) {
    const [condition] = state,
      value = condition === "" || (condition === POWER ? group.dataset.power === "1" : valueOf(condition));
    if (value === undefined || value === null || (condition === POWER && run.known === false)) return null;
    if (value) return state;
  }
  return null;
}

function showState({ node, states, group }) {
  const state = stateOf({ states, group });
  setText(node, state ? state[1].replace(REFERENCE, (_, name, ms) => textOf(valueOf(name), ms)) : "");
}

function textOf(value, ms) {
  if (ms !== undefined && typeof value === "number") return seconds(value * (ms || 1));
  return Number.isInteger(value) ? count(value) : shown(value);
}

const seconds = ms => (ms / 1000).toFixed(ms % 100 && ms < 100 ? 3 : 1);
