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
const THUMB = 16, HIGH = 10; // CSS pixels: of the slider's thumb, of the axis of marks
const COLORS = { fault: "fault", error: "fault", rule: "mark", mode: "curve", restart: "curve" };
const FAILURES = ["fault", "error"];

const canvas = el("canvas", { class: "mark-axis", "aria-hidden": "true" });
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
    ({ marks, whole } = answer);
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
  try {
    const { mark, whole: all } = await ask("mark", { from: run.scan, way });
    const where = `${way > 0 ? "after" : "before"} scan ${count(run.scan)}`;
    if (mark) {
      if (FAILURES.includes(mark.kind)) failed(mark);
      tell(`${clock(mark.t)}  ${mark.text}`, "told");
      await lookAt(mark.scan);
    } else tell(all ? `There is no mark ${where}.` : "The recording is still being looked through for marks.");
  } catch (refused) {
    tell(refused.message);
  }
  asking = false;
}

function draw() {
  const wide = canvas.clientWidth, [first, last] = run.range ?? [0, 0];
  if (!wide) return;
  const to = pen(canvas, wide, HIGH),
    x = scan => THUMB / 2 + ((scan - first) / Math.max(last - first, 1)) * (wide - THUMB);
  const grave = ([, one], [, other]) => Number(FAILURES.includes(one)) - Number(FAILURES.includes(other)); // on top
  for (const [scan, kind] of [...marks].sort(grave)) {
    const failure = FAILURES.includes(kind), place = Math.round(x(scan));
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
