// A large chart of one lane of the timing strip, or of two: one has its scale on the left, the other on the right.

import { AXIS, grid, levelText } from "./chart.js";
import { button, dialogOf, el, optionsOf, setText } from "./dom.js";
import { clock, shown, stepOf } from "./format.js";
import { after, range, stretches, valueOf } from "./lanes.js";
import { colors, pen } from "./pen.js";
import { run } from "./state.js";

const LEFT = 72, RIGHT = 72, TOP = 10, MOST_LINES = 5; // CSS pixels; lines of a scale

const first = el("select", { "aria-label": "Lane", change: draw }),
  second = el("select", { "aria-label": "Second lane", change: draw });
const canvas = el("canvas", {
  class: "plot",
  role: "img",
  "aria-label": "Values of the lanes over time",
  pointermove: onPointer,
});
const times = el("canvas", { class: "axis", "aria-hidden": "true" });
const reading = el("output", { class: "figure" });
const dialog = dialogOf("Plot", "Close the plot");
dialog.node.classList.add("wide");

let source = null, axis = null;

// The button that opens the plot. `from` is the strip: names(), points(name), and view(), the time in view.
export const plotButton = from =>
  button("Plot lanes", () => open(from), { text: "Plot", title: "Plot a lane larger, or two on one chart" });

function open(from) {
  source = from;
  const names = from.names(), kept = [first.value, second.value];
  first.replaceChildren(...optionsOf(names, kept[0]));
  second.replaceChildren(el("option", { value: "" }, "no second lane"), ...optionsOf(names, kept[1]));
  dialog.open(el("div", { class: "line" }, first, second, reading), el("div", { class: "plotted" }, canvas, times));
  draw();
}

// Draws an open plot again, after the strip has got other values or shows another time.
export function drawPlot() {
  if (dialog.node.open) draw();
}

function draw() {
  const wide = canvas.clientWidth, high = Math.max(Math.round(innerHeight * 0.55), 160);
  if (!source || !wide) return;
  const to = pen(canvas, wide, high),
    [from, end] = source.view(),
    left = LEFT,
    right = wide - (second.value ? RIGHT : 12);
  const x = time => left + (time - from) / (end - from) * (right - left);
  axis = { from, end, left, right };
  grid(to, pen(times, wide, AXIS), x, left, from, end, high);
  const lanes = [[first.value, colors.curve, left - 8, "right"], [second.value, colors.mark, right + 8, "left"]];
  for (const [name, color, labelX, align] of lanes) if (name) drawLane(to, name, color, labelX, align, x, high, wide);
  readAt(run.t);
}

function drawLane(to, name, color, labelX, align, x, high, wide) {
  const points = source.points(name), { from, end, left, right } = axis;
  const [low, top] = scaleOf(points), y = value => TOP + (top - Number(value)) / (top - low) * (high - 2 * TOP);
  const step = top - low === 1 ? 1 : stepOf(top - low, MOST_LINES); // 1 for a bit
  for (let value = Math.ceil(low / step) * step; value <= top; value += step) {
    to.line(left, y(value), right, y(value), colors.grid);
    to.text(value.toLocaleString("en-US", { maximumFractionDigits: 6 }), labelX, y(value) + 4, color, align);
  }
  const isSmooth = name.endsWith(".position");
  to.clipped(left, 0, () => {
    to.begin(color, 2);
    let before = null; // the value at the end of the previous stretch; null: not known
    for (const [begin, until, value, least, most] of stretches(points, from, end)) {
      if (value === null || typeof value === "string") { before = null; continue; }
      const at = x(begin), middle = isSmooth ? (at + x(until)) / 2 : at, ends = [before ?? value, value].map(Number);
      if (before === null) to.from(at, y(isSmooth ? least ?? value : value));
      for (const each of [least, most]) { // values between the ends of a stretch
        if (each < Math.min(...ends) || each > Math.max(...ends)) to.to(middle, y(each));
      }
      if (!isSmooth) to.to(at, y(value));
      to.to(x(until), y(value));
      before = value;
    }
    to.end();
  }, wide - right, high);
}

// The lowest and highest value of the scale; 0 and 1 for a bit.
function scaleOf(points) {
  return points.some(each => each.length === 4) ? range(points) : [0, 1];
}

function onPointer({ offsetX }) {
  const { from, end, left, right } = axis;
  readAt(from + (offsetX - left) / (right - left) * (end - from));
}

// Shows the values of the lanes at a time: under the pointer, or of the scan shown.
function readAt(time) {
  const { from, end } = axis;
  const texts = [first.value, second.value]
    .filter(Boolean)
    .map(name => `${name} ${valueAt(source.points(name), time)}`);
  setText(reading, time < from || time > end ? "" : `${clock(time)}  ${texts.join("  ")}`);
}

// The text of the value at a time.
function valueAt(points, time) {
  const point = points[after(points, time) - 1], value = point ? valueOf(point) : null;
  return value === null ? "–" : point.length === 4 ? shown(value) : levelText(value);
}
