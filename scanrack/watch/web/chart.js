// Draws the timing strip: curves of positions, lanes of bits, lanes of tags. `to` is the pen.

import { clock, count, shown, stepOf } from "./format.js";
import { colors } from "./pen.js";

export const TOP = 8, AXIS = 20, CURVE = 52, NUMBER = 44, LANE = 17; // CSS pixels
const THIN = 2; // CSS pixels; a narrower pulse is drawn as a needle
const ROUND = 8; // radius of the number of a cause, CSS pixels
const LETTER = 6.7; // width of a letter in a lane, CSS pixels

// The height of a tag's lane, which is a curve for numbers.
export const highOf = points => (points.some(point => point.length === 4) ? NUMBER : LANE);

// Draws the lines of times behind the lanes, and the times with another pen, which stays in view.
export function grid(to, times, x, left, from, end, high) {
  const step = stepOf(end - from, Math.max((x(end) - x(from)) / 90, 2));
  for (let time = Math.max(Math.ceil(from / step) * step, 0); time <= end; time += step) {
    const at = x(time), half = clock(time).length * LETTER / 2;
    to.line(at, 0, at, high, colors.grid);
    // only complete times
    if (at + half <= to.wide && at - half >= left - 60) times.text(clock(time), at, AXIS - 6, colors.soft, "center");
  }
}

// Draws a position. The last value of a stretch is that of its last scan; a straight line leads to the next stretch.
export function curve(to, points, range, period, name, x, top, left, tall, color = colors.curve) {
  to.label(name, left - 8, top + tall / 2 + 4, colors.ink);
  if (!points.length) return;
  const y = scale(to, range, top, left, tall);
  to.clipped(left, top, () => {
    to.begin(color, 1.5);
    let previous = null; // value at the end of the line so far; null: no line yet
    points.forEach(([time, least, most, last], index) => {
      if (least === null || index + 1 === points.length) { previous = null; return; } // the last point is out of view
      const end = points[index + 1][0] - period;
      if (previous === null) to.from(x(time), y(end > time ? least : last));
      // the stretch has lower or higher values than its ends
      if (least < Math.min(previous ?? last, last) || most > Math.max(previous ?? last, last)) {
        if (previous !== null) to.to(x(time), y(previous));
        to.to(x((time + end) / 2), y(least));
        to.to(x((time + end) / 2), y(most));
      }
      to.to(x(end), y(last));
      previous = last;
    });
    to.end();
  });
}

// Draws causes as lines with their numbers; numbers that would overlap are side by side.
export function numbered(to, causes, x, high) {
  const wide = 2 * ROUND + 1, centers = [];
  for (const { t } of causes) centers.push(Math.max(x(t), (centers.at(-1) ?? -wide) + wide));
  // moves numbers beyond the right edge back into the strip
  centers.reduceRight((most, center, index) => (centers[index] = Math.min(center, most)) - wide, to.wide - ROUND);
  for (const { t } of causes) to.line(x(t), TOP, x(t), high, colors.mark, 0.75);
  causes.forEach(({ number }, index) => {
    to.disc(centers[index], ROUND, ROUND, colors.mark);
    to.text(String(number), centers[index], ROUND + 4, colors.panel, "center");
  });
}

// Draws the ends of a scale; returns a function that returns the height of a value.
function scale(to, [low, high], top, left, tall) {
  to.small(count(high), left - 8, top + 9);
  to.small(count(low), left - 8, top + tall - 4);
  return value => top + 5 + (high - Number(value)) / (high - low) * (tall - 14);
}

export function lane(to, stretches, name, x, top, left, right) {
  to.label(name, left - 8, top + LANE - 5, colors.ink);
  to.clipped(left, top, () => bars(to, stretches, x, top, left, right));
}

// Draws the same bit of another trace, as a thin bar below.
export function below(to, stretches, x, top, left) {
  to.clipped(left, top, () => {
    for (const [from, end, on] of stretches)
      if (on) to.rect(x(from), top + LANE - 3, Math.max(x(end) - x(from), 1.5), 3, colors.mark);
  });
}

// Draws nothing for an unknown level, and half a bar for a stretch with many edges.
function bars(to, stretches, x, top, left, right) {
  const high = top + 3, low = top + LANE - 3, half = (high + low) / 2;
  for (const [from, end, on, edges] of stretches) {
    if (on === null) continue;
    const wide = x(end) - x(from);
    to.line(Math.max(x(from), left), low, Math.min(x(end), right), low, colors.grid);
    if (edges) to.rect(x(from), half, Math.max(wide, 1.5), low - half, colors.mark);
    else if (on) to.rect(x(from), high, Math.max(wide, 1.5), low - high, wide < THIN ? colors.mark : colors.bit);
    if (!edges && on && wide < THIN) to.dot(x(from) + 0.75, high, colors.mark);
  }
}

// Draws a tag: a BOOL as bars, a number as steps, a text in a box, and nothing for an unknown value.
export function tagLane(to, { points, range, stretches }, name, x, top, left, right) {
  const tall = highOf(points);
  to.label(name, left - 8, tall === LANE ? top + LANE - 5 : top + tall / 2 + 4, colors.ink);
  if (tall === NUMBER) return numbers(to, stretches, range, x, top, left);
  to.clipped(left, top, () => {
    if (!points.some(([, value]) => typeof value === "string")) return bars(to, stretches, x, top, left, right);
    for (const [from, end, text] of stretches) if (text !== null) box(to, String(text), x(from), x(end), top, left);
  });
}

function numbers(to, stretches, range, x, top, left) {
  const y = scale(to, range, top, left, NUMBER);
  to.clipped(left, top, () => {
    to.begin(colors.bit, 1.5);
    let isKnown = false; // whether the line continues
    for (const [from, end, value, least, most] of stretches) {
      if (value === null) { isKnown = false; continue; }
      if (isKnown) to.to(x(from), y(least ?? value)); else to.from(x(from), y(least ?? value));
      if (most !== undefined && most !== least) to.to(x(from), y(most));
      to.to(x(from), y(value));
      to.to(x(end), y(value));
      isKnown = true;
    }
    to.end();
  });
}

function box(to, text, from, end, top, left) {
  const wide = Math.max(end - from, 1), textStart = Math.max(from, left);
  to.frame(from, top + 2, wide, LANE - 4, colors.bit);
  const most = Math.floor((end - textStart - 8) / LETTER);
  if (most >= 2)
    to.text(text.length > most ? `${text.slice(0, most - 1)}…` : text, textStart + 4, top + LANE - 5, colors.ink);
}

// A value in the list of changes.
export const levelText = value => (value === 1 ? "on" : value === 0 ? "off" : shown(value));
