// Marks of a trace on the axis of all scans: errors, faults, rules, mode changes, restarts.

import { erred } from "./causeband.js";
import { button, el, setFlag } from "./dom.js";
import { clock, count } from "./format.js";
import { tell } from "./notice.js";
import * as orders from "./orders.js";
import { colors, pen } from "./pen.js";
import { lookAt } from "./scrub.js";
import { ask } from "./source.js";
import { onHello, onPaint, run } from "./state.js";

const AGAIN_MS = 150; // delay between two questions during the search
const THUMB = 16, HIGH = 10, REACH = 6; // width of the slider's thumb, height of the axis, reach of a click; CSS pixels
const COLORS = { fault: "fault", error: "fault", rule: "mark", mode: "curve", restart: "curve" };
const FAILURES = ["fault", "error"];

const canvas = el("canvas", { class: "mark-axis", "aria-hidden": "true", click: clicked });
const earlier = button("Previous mark", () => toMark(-1), {
  text: "◂!",
  title: "The previous mark (E)",
  class: "sign",
});
const later = button("Next mark", () => toMark(1), { text: "!▸", title: "The next mark (e)", class: "sign" });

// The axis above the slider, and the buttons after it.
export const marksAxis = canvas, marksButtons = [earlier, later];

let marks = [], whole = false, asking = false, generation = 0;

export const marksIn = (from, to) => marks.filter(([scan]) => scan >= from && scan <= to);
export const colorOf = kind => colors[COLORS[kind]];

const bySeverity = ([, a], [, b]) => Number(FAILURES.includes(a)) - Number(FAILURES.includes(b)); // failures come last

onHello(() => {
  marks = [];
  whole = false;
  const recorded = orders.recorded(), mine = ++generation;
  for (const markButton of [earlier, later]) setFlag(markButton, "hidden", !recorded);
  if (recorded) askMarks(mine);
});

// Requests the marks until all scans are searched.
async function askMarks(mine) {
  if (mine !== generation) return;
  try {
    const answer = await ask("marks");
    if (mine !== generation) return;
    whole = answer.whole;
    marks = answer.marks.sort(bySeverity);
    draw();
    if (!whole) return setTimeout(askMarks, AGAIN_MS, mine);
    document.documentElement.dataset.marks = String(answer.total);
    if (answer.failure) failed(answer.failure);
  } catch { /* the next hello asks again */ }
}

// Reports a failure in the state bar; the page stays at its scan.
function failed({ scan, t, slot, name, tag, text }) {
  if (tag) erred({ scan, t, slot, bit: name, tag, text, rule: "", stopped: false });
}

// Shows the next mark, or the previous one if `direction` is -1.
export async function toMark(direction) {
  if (!orders.recorded()) return tell("Only a recording has marks; this rack is running.");
  if (asking) return;
  asking = true;
  const answer = await orders.order("mark", { from: run.scan, way: direction });
  const where = `${direction > 0 ? "after" : "before"} scan ${count(run.scan)}`;
  if (answer?.mark) await show(answer.mark);
  else if (answer?.whole) tell(`There is no mark ${where}: ${direction > 0 ? "E goes back" : "e goes forward"}.`);
  else if (answer) tell("The recording is still being searched for marks.");
  asking = false;
}

async function show(mark) {
  if (FAILURES.includes(mark.kind)) failed(mark);
  tell(`${clock(mark.t)}  ${mark.text}`, "news");
  await lookAt(mark.scan);
}

// Returns the position of a scan on the axis, CSS pixels.
function placeOf(scan) {
  const [first, last] = run.range ?? [0, 0];
  return THUMB / 2 + ((scan - first) / Math.max(last - first, 1)) * (canvas.clientWidth - THUMB);
}

function scanAt(place) {
  const [first, last] = run.range ?? [0, 0];
  return first + ((place - THUMB / 2) / Math.max(canvas.clientWidth - THUMB, 1)) * (last - first);
}

// A click near marks shows the most severe one.
async function clicked({ offsetX }) {
  const near = marks.filter(([scan]) => Math.abs(placeOf(scan) - offsetX) <= REACH).at(-1);
  if (!near) return lookAt(scanAt(offsetX));
  const { mark } = await ask("mark", { from: near[0] - 1, way: 1 });
  if (mark) await show(mark);
}

function draw() {
  const wide = canvas.clientWidth;
  if (!wide) return;
  const to = pen(canvas, wide, HIGH);
  for (const [scan, kind] of marks) {
    const failure = FAILURES.includes(kind), place = Math.round(placeOf(scan));
    to.rect(place - 1, failure ? 0 : 3, 2, failure ? HIGH : HIGH - 3, colorOf(kind));
  }
}

onPaint(({ range }) => {
  if (!range) return;
  draw();
  if (whole && orders.recorded()) askMarks(generation); // the trace has grown
});
new ResizeObserver(() => { if (run.hello) draw(); }).observe(canvas);
colors.onChange(() => { if (run.hello) draw(); });
