// Marks of a recording on the axis of all its scans: errors, faults, rules, changes of the mode, restarts.

import { erred } from "./causeband.js";
import { button, el, setFlag } from "./dom.js";
import { clock, count } from "./format.js";
import { tell } from "./notice.js";
import * as orders from "./orders.js";
import { colors, pen } from "./pen.js";
import { lookAt } from "./scrub.js";
import { ask } from "./source.js";
import { onHello, onPaint, run } from "./state.js";

const AGAIN_MS = 150; // between two questions while the recording is looked through
const THUMB = 16, HIGH = 10, REACH = 6; // CSS pixels: of the slider's thumb, of the axis of marks; of a click to a mark
const COLORS = { fault: "fault", error: "fault", rule: "mark", mode: "curve", restart: "curve" };
const FAILURES = ["fault", "error"];

const canvas = el("canvas", { class: "mark-axis", "aria-hidden": "true", click: clicked });
const earlier = button("Previous mark", () => toMark(-1), {
  text: "◂!",
  title: "The previous mark (E)",
  class: "sign",
});
const later = button("Next mark", () => toMark(1), { text: "!▸", title: "The next mark (e)", class: "sign" });

// What stands above the slider, and the buttons behind it.
export const marksAxis = canvas, marksButtons = [earlier, later];

let marks = [], whole = false, asking = false, generation = 0;

export const marksIn = (from, to) => marks.filter(([scan]) => scan >= from && scan <= to);
export const colorOf = kind => colors[COLORS[kind]];

const grave = ([, one], [, other]) => Number(FAILURES.includes(one)) - Number(FAILURES.includes(other)); // drawn last

onHello(() => {
  marks = [];
  whole = false;
  const recorded = orders.recorded(), mine = ++generation;
  for (const each of [earlier, later]) setFlag(each, "hidden", !recorded);
  if (recorded) askMarks(mine);
});

// Asks for the marks until all scans are looked through; the page shows its scan meanwhile.
async function askMarks(mine) {
  if (mine !== generation) return;
  try {
    const answer = await ask("marks");
    if (mine !== generation) return;
    whole = answer.whole;
    marks = answer.marks.sort(grave);
    draw();
    if (!whole) return setTimeout(askMarks, AGAIN_MS, mine);
    document.documentElement.dataset.marks = String(answer.total);
    if (answer.failure) failed(answer.failure);
  } catch { /* the next hello asks again */ }
}

// The line of a failure, which leaves the page where it is.
function failed({ scan, t, slot, name, tag, text }) {
  if (tag) erred({ scan, t, slot, bit: name, tag, text, rule: "", stopped: false });
}

// Looks at the next mark, or the one before.
export async function toMark(way) {
  if (!orders.recorded()) return tell("Marks are of recordings: this rack runs.");
  if (asking) return;
  asking = true;
  const answer = await orders.order("mark", { from: run.scan, way });
  const where = `${way > 0 ? "after" : "before"} scan ${count(run.scan)}`;
  if (answer?.mark) await show(answer.mark);
  else if (answer?.whole) tell(`There is no mark ${where}: ${way > 0 ? "E goes back" : "e goes forward"}.`);
  else if (answer) tell("The recording is still being searched for marks.");
  asking = false;
}

async function show(mark) {
  if (FAILURES.includes(mark.kind)) failed(mark);
  tell(`${clock(mark.t)}  ${mark.text}`, "news");
  await lookAt(mark.scan);
}

// Where a scan is on the axis, CSS pixels.
function placeOf(scan) {
  const [first, last] = run.range ?? [0, 0];
  return THUMB / 2 + ((scan - first) / Math.max(last - first, 1)) * (canvas.clientWidth - THUMB);
}

function scanAt(place) {
  const [first, last] = run.range ?? [0, 0];
  return first + ((place - THUMB / 2) / Math.max(canvas.clientWidth - THUMB, 1)) * (last - first);
}

// A click at a mark goes to it; of several the gravest.
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
  if (whole && orders.recorded()) askMarks(generation); // it grows
});
new ResizeObserver(() => { if (run.hello) draw(); }).observe(canvas);
colors.onChange(() => { if (run.hello) draw(); });
