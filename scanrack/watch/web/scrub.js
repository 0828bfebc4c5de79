// The slider through the past: the whole recording, then live again, or another way from here.

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
    held = true;
  },
});
const ago = el("output", { class: "figure ago" });
const live = button("Live", () => goLive(), { text: "Live", title: "Back to the present" });
const branchButton = button("Branch from here", branch, {
  title: "Run again from this scan on, into a recording of its own",
});

let requested = null, asking = false;
let aim = null; // the scan that is on its way: keys that follow one another quickly move on from there
let held = false; // by a finger, which gives no focus: frames leave the slider where it is
for (const kind of ["pointerup", "pointercancel"]) addEventListener(kind, () => { held = false; }, true);

// The slider, with what stands above it, and what stands behind it.
export const scrubber = (above, ...behind) => el("div", { class: "scrub", role: "group", "aria-label": "Past" },
  el("div", { class: "track" }, above, slider), ...behind, ago, live, branchButton);

// Looks at a scan; while an answer is awaited only the latest wish is kept.
export async function lookAt(scan) {
  requested = clamp(scan);
  aim = requested === "live" ? null : requested;
  if (asking) return;
  asking = true;
  while (requested !== null) {
    const next = requested;
    requested = null;
    if (!await orders.look(next) && requested === null) aim = null; // it was refused
  }
  asking = false;
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
  const to = (aim ?? run.scan ?? 0) + scans;
  if (to > run.range?.[1] && run.hello.kind === "rack") return run.state === "past" && goLive();
  return lookAt(to);
}

let branched = null; // the scan of a branch of which nothing was reported yet

async function branch() {
  const scan = branched = run.scan;
  tell(`The rack runs again up to scan ${count(scan)}, where the branch begins.`, "branch");
  link({ scan: null }); // the new session greets the page before the answer comes
  // the scan that is shown is the last one in common; the server of a recording ends, and that of the branch begins
  if (await orders.branch(scan + 1) || run.state === "lost") return;
  branched = null;
  hush("branch");
  link({ scan });
}

// A branch runs, while a recording did not: the page says so.
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
  if (run.scan === aim) aim = null;
  if (Number(slider.min) !== first) slider.min = first;
  if (Number(slider.max) !== last) slider.max = last;
  if (!held && aim === null) slider.value = past ? run.scan : last;
  slider.setAttribute("aria-valuetext", past ? `scan ${count(run.scan)}` : "present");
  const period = run.hello.period_ns;
  setText(ago, past && run.scan < last ? `−${clock((last - run.scan) * period)}` : "");
  live.disabled = !past;
  setFlag(live, "hidden", run.hello.kind !== "rack");
  branchButton.disabled = !["past", "paused"].includes(run.state);
  setFlag(branchButton, "hidden", !run.hello.branches);
});
