// The lanes of the recording that is compared with, for the time in view.

import { Lanes, missing } from "./lanes.js";
import { ask } from "./source.js";
import { run } from "./state.js";

let beside = null, asking = false;
const followers = [];

// Calls a function when there are other lanes, or no longer any.
export const onBeside = follow => { followers.push(follow); };

const tell = () => { for (const each of followers) each(); };

export function beginBeside() {
  beside = new Lanes([]);
  tell();
}

export function endBeside() {
  if (beside) { beside = null; tell(); }
}

// Its lanes, or null; what is missing of a time, ns, is requested.
export function besideLanes(from, to) {
  if (beside && !asking) fill(beside, from, to);
  return beside;
}

async function fill(into, from, to) {
  const begin = missing(into.have, from, to), period = run.hello.period_ns;
  if (begin === null || begin >= to) return;
  asking = true;
  try {
    const { strip } = await ask("beside", { from: begin / period, to: to / period - 1 });
    into.take(strip.bits ? strip : { from: begin, to, bits: {}, positions: {} }, begin);
  } catch { /* what is there is shown */ }
  asking = false;
  tell();
}
