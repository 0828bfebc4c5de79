// The slider over the recorded scans, with the buttons back to the present and to a branch.

import { button, el, setFlag, setText } from "./dom.js";
import { clock, count } from "./format.js";
import { link } from "./link.js";
import { hush, tell } from "./notice.js";
import * as orders from "./orders.js";
import { onPaint, run } from "./state.js";

const slider = el("input", {
  type: "range",
  min: 0,
  max: 1,
  value: 1,
  step: 1,
  "aria-label": "Scan shown",
  input: dragged,
  pointerdown: () => {
    isHeld = true;
  },
});
const ago = el("output", { class: "figure ago" });
const live = button("Live", () => goLive(), { text: "Live", title: "Back to the present" });
const branchButton = button("Branch from here", branch, {
  title: "Run again from this scan on, into a recording of its own",
});

let nextScan = null, isAsking = false;
let destination = null; // the scan that was requested last: keys pressed in quick succession move on from it
let isHeld = false; // by a finger, which does not give focus: frames do not move the slider then
for (const kind of ["pointerup", "pointercancel"]) addEventListener(kind, () => { isHeld = false; }, true);

// The slider, with a node above it, and nodes after it.
export const scrubber = (above, ...behind) => el("div", { class: "scrub", role: "group", "aria-label": "Past" },
  el("div", { class: "track" }, above, slider), ...behind, ago, live, branchButton);

// Shows a scan. Of the scans requested while an answer is awaited, only the latest is kept.
export async function lookAt(scan) {
  nextScan = clamp(scan);
  destination = nextScan === "live" ? null : nextScan;
  if (isAsking) return;
  isAsking = true;
  while (nextScan !== null) {
    const requestedScan = nextScan;
    nextScan = null;
    if (!await orders.look(requestedScan) && nextScan === null) destination = null; // it was refused
  }
  isAsking = false;
}

function clamp(scan) {
  if (scan === "live" || !run.range) return scan; // a link is followed before the first picture
  return Math.min(Math.max(Math.round(scan), run.range[0]), run.range[1]);
}

function dragged() {
  lookAt(Number(slider.value));
}

export function goLive() {
  link({ scan: null });
  lookAt(run.hello?.kind === "trace" ? run.range?.[1] ?? 0 : "live");
}

// Continues after a pause, in the present.
export function goOn() {
  if (run.state === "past") goLive();
  return orders.go();
}

// Moves by so many scans: from the present into the past, and beyond the last scan of a rack into the present.
export function moveBy(scans) {
  const to = (destination ?? run.scan ?? 0) + scans;
  if (to > run.range?.[1] && run.hello.kind === "rack") return run.state === "past" && goLive();
  return lookAt(to);
}

let branched = null; // the scan of a new branch that is not reported yet

async function branch() {
  const scan = branched = run.scan;
  tell(`The rack runs again up to scan ${count(scan)}, where the branch begins.`, "branch");
  link({ scan: null }); // the new session connects before the answer comes
  // the scan shown is the last common one; a recording's server ends, and the branch's server starts
  if (await orders.branch(scan + 1) || run.state === "lost") return;
  branched = null;
  hush("branch");
  link({ scan });
}

// Tells that the branch runs: the recording before it did not.
function tellBranch() {
  const { requested: speed } = run.speed, pace = typeof speed === "number" ? `at ${speed}×` : "as fast as it can";
  const goes = run.paused ? "it is paused there, and ▶ continues it" : `it runs again, ${pace}`;
  tell(`This is a branch from scan ${count(branched)}: ${goes}.`, "news");
  branched = null;
}

onPaint(changes => {
  if (branched !== null && changes.speed && run.hello.kind === "rack" && run.scan >= branched) tellBranch();
  if (!run.range) return;
  const [first, last] = run.range;
  const past = run.state === "past";
  if (run.scan === destination) destination = null;
  if (Number(slider.min) !== first) slider.min = first;
  if (Number(slider.max) !== last) slider.max = last;
  if (!isHeld && destination === null) slider.value = past ? run.scan : last;
  slider.setAttribute("aria-valuetext", past ? `scan ${count(run.scan)}` : "present");
  const period = run.hello.period_ns;
  setText(ago, past && run.scan < last ? `−${clock((last - run.scan) * period)}` : "");
  live.disabled = !past;
  setFlag(live, "hidden", run.hello.kind !== "rack");
  branchButton.disabled = !["past", "paused"].includes(run.state);
  setFlag(branchButton, "hidden", !run.hello.branches);
});
