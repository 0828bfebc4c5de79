// The report of late scans: its cause and remedy, if more than 5 % of scans begin late.

import { onHello, onPaint, run } from "./state.js";

const FROM = 0.05, UNTIL = 0.03; // shares of late scans at which the report begins and ends
const WINDOW_NS = 5e9, LEAST = 200; // machine time and minimum number of scans for a share
const SLOW = 0.97; // a rack below this share of the requested speed lags

const WHAT = "More than 5 % of scans begin late";
const BUSY = {
  what: WHAT,
  cause:
    "This computer wakes the rack too late. Start with --spin, use a slower scan (scan_ms), or end other programs.",
};
const LONG = {
  what: WHAT,
  cause: "Scans take more time than this speed allows. Use a lower speed, or a slower scan (scan_ms).",
};

let samples = []; // [scan, late scans up to it]
export let late = null; // { what, cause } while scans are late

// Whether the rack does not reach the requested speed.
export const lags = () => run.speed?.reached < SLOW * run.speed?.requested;

onHello(() => { samples = []; late = null; });

onPaint(({ scan }) => {
  if (run.state !== "live") samples = [];
  if (run.state !== "live" || scan === undefined) return;
  samples.push([scan, run.late ?? 0]);
  const begin = scan - WINDOW_NS / run.hello.period_ns;
  while (samples[1]?.[0] < begin) samples.shift();
  const [first, firstLate] = samples[0], share = (run.late - firstLate) / Math.max(scan - first, LEAST);
  if (share < UNTIL) late = null;
  else if (share > FROM) late = lags() ? LONG : BUSY;
});
