// The lanes of the other trace in a comparison, for the time in view.

import { Lanes, missing } from "./lanes.js";
import { ask } from "./source.js";
import { run } from "./state.js";

let beside = null, asking = false;
const followers = [];

// Calls a function when these lanes change, begin or end.
export const onBeside = follow => { followers.push(follow); };

const notify = () => { for (const follow of followers) follow(); };

export function beginBeside() {
  beside = new Lanes([]);
  notify();
}

export function endBeside() {
  if (beside) { beside = null; notify(); }
}

// Returns the lanes, or null; requests missing pieces of a time, ns.
export function besideLanes(from, to) {
  if (beside && !asking) fill(beside, from, to);
  return beside;
}

async function fill(lanes, from, to) {
  const begin = missing(lanes.have, from, to), period = run.hello.period_ns;
  if (begin === null || begin >= to) return;
  asking = true;
  try {
    const { strip } = await ask("beside", { from: begin / period, to: to / period - 1 });
    lanes.take(strip.bits ? strip : { from: begin, to, bits: {}, positions: {} }, begin);
  } catch { /* the known lanes stay */ }
  asking = false;
  notify();
}
