// What a block does now: the text of the first of its states whose condition holds, with the values of its tags.

import { setText } from "./dom.js";
import { count, shown } from "./format.js";
import { run } from "./state.js";
import { valueOf } from "./values.js";

const REFERENCE = /\{([^}]+?)(?::s(\d*))?\}/g; // {Out.ACC}; in seconds {Out.ACC:s} of ms, {T4:0.ACC:s10} of 10 ms

const POWER = "*"; // the condition that power reaches the block

let places = []; // { node, states, names, group }

// Shows what the blocks of a picture do from now on; those of the picture before are left.
export function beginNow(root) {
  places = [...root.querySelectorAll("[data-now]")].map(node => {
    const states = JSON.parse(node.dataset.now);
    return {
      node,
      states,
      group: node.closest("[data-element]"),
      names: new Set(states.flatMap(([when, text]) => [when, ...[...text.matchAll(REFERENCE)].map(each => each[1])])),
    };
  });
  for (const each of places) say(each);
}

// Called when the power of these rungs, and these tags, have changed and are painted.
export function paintNow(tags, power) {
  const changed = Object.keys(tags ?? {}), lit = new Set(Object.keys(power ?? {}));
  if (changed.length || lit.size)
    for (const each of places)
      if (changed.some(name => each.names.has(name)) || (each.names.has(POWER) && lit.has(rungOf(each.group))))
        say(each);
}

const rungOf = group => group.dataset.element.slice(0, group.dataset.element.lastIndexOf("."));

// The first state that holds; none while it is not known whether an earlier one does.
function stateOf({ states, group }) {
  for (const state of states) {
    const [when] = state, holds = when === "" || (when === POWER ? group.dataset.power === "1" : valueOf(when));
    if (holds === undefined || holds === null || (when === POWER && run.known === false)) return null;
    if (holds) return state;
  }
  return null;
}

function say({ node, states, group }) {
  const state = stateOf({ states, group });
  setText(node, state ? state[1].replace(REFERENCE, (_, name, ms) => said(valueOf(name), ms)) : "");
}

function said(value, ms) {
  if (ms !== undefined && typeof value === "number") return seconds(value * (ms || 1));
  return Number.isInteger(value) ? count(value) : shown(value);
}

const seconds = ms => (ms / 1000).toFixed(ms % 100 && ms < 100 ? 3 : 1);
