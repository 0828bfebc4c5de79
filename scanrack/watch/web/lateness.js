// Late scans: when more than 5 % of them begin late, why that is and what to do.

import { onHello, onPaint, run } from "./state.js";

const FROM = 0.05, UNTIL = 0.03; // shares of late scans between which it stays as it is
const WINDOW_NS = 5e9, LEAST = 200; // of machine time, and scans
const SLOW = 0.97; // of the speed requested: lags behind

const WHAT = "More than 5 % of scans begin late";
const BUSY = {
  what: WHAT,
  cause:
    "Start with --spin, take a slower scan (scan_ms), or end other programs: this computer wakes the rack too late.",
};
const LONG = {
  what: WHAT,
  cause: "Take a lower speed, or a slower scan (scan_ms): the scans need more time than this speed gives.",
};

let samples = []; // [scan, late scans up to it]
export let late = null; // { what, cause } while scans are late

// Whether the rack does not reach the speed that is requested.
export const lags = () => run.speed?.reached < SLOW * run.speed?.requested;

onHello(() => { samples = []; late = null; });

onPaint(({ scan }) => {
  if (run.state !== "live") samples = [];
  if (run.state !== "live" || scan === undefined) return;
  samples.push([scan, run.late ?? 0]);
  const begin = scan - WINDOW_NS / run.hello.period_ns;
  while (samples[1]?.[0] < begin) samples.shift();
  const [first, before] = samples[0], share = (run.late - before) / Math.max(scan - first, LEAST);
  if (share < UNTIL) late = null;
  else if (share > FROM) late = lags() ? LONG : BUSY;
});
