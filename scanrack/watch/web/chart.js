// Draws the timing strip: curves of positions, lanes of bits, lanes of tags.

import { clock, count, shown, stepOf } from "./format.js";
import { colors } from "./pen.js";

export const TOP = 8, AXIS = 20, CURVE = 52, NUMBER = 44, LANE = 17; // CSS pixels
const THIN = 2; // a pulse narrower than that many pixels is drawn as a needle
const ROUND = 8; // radius of a number of a cause, CSS pixels
const LETTER = 6.7; // CSS pixels of a letter in a lane

// How high a lane of a tag is: numbers are curves.
export const highOf = points => (points.some(each => each.length === 4) ? NUMBER : LANE);

// Lines of time behind the lanes, and their times on its own pen, which stays in view.
export function grid(to, times, x, left, from, end, high) {
  const step = stepOf(end - from, Math.max((x(end) - x(from)) / 90, 2));
  for (let time = Math.max(Math.ceil(from / step) * step, 0); time <= end; time += step) {
    const at = x(time), half = clock(time).length * LETTER / 2;
    to.line(at, 0, at, high, colors.grid);
    // none cut off
    if (at + half <= to.wide && at - half >= left - 60) times.text(clock(time), at, AXIS - 6, colors.soft, "center");
  }
}

// A position: the last one of a stretch is that of its last scan, and the way from there to the next one is even.
export function curve(to, points, range, period, name, x, top, left, tall, color = colors.curve) {
  to.label(name, left - 8, top + tall / 2 + 4, colors.ink);
  if (!points.length) return;
  const y = scale(to, range, top, left, tall);
  to.inside(left, top, () => {
    to.begin(color, 1.5);
    let before = null; // where the pen is; null: nowhere
    points.forEach(([time, least, most, last], place) => {
      if (least === null || place + 1 === points.length) { before = null; return; } // the point after those in view
      const end = points[place + 1][0] - period;
      if (before === null) to.from(x(time), y(end > time ? least : last));
      // there and back in a stretch
      if (least < Math.min(before ?? last, last) || most > Math.max(before ?? last, last)) {
        if (before !== null) to.to(x(time), y(before));
        to.to(x((time + end) / 2), y(least));
        to.to(x((time + end) / 2), y(most));
      }
      to.to(x(end), y(last));
      before = last;
    });
    to.end();
  });
}

// Causes as lines with their numbers; those of one place stand side by side.
export function numbered(to, causes, x, high) {
  const wide = 2 * ROUND + 1, places = [];
  for (const { t } of causes) places.push(Math.max(x(t), (places.at(-1) ?? -wide) + wide));
  // within the strip
  places.reduceRight((most, place, at) => (places[at] = Math.min(place, most)) - wide, to.wide - ROUND);
  for (const { t } of causes) to.line(x(t), TOP, x(t), high, colors.mark, 0.75);
  causes.forEach(({ number }, at) => {
    to.disc(places[at], ROUND, ROUND, colors.mark);
    to.text(String(number), places[at], ROUND + 4, colors.panel, "center");
  });
}

// Draws the ends of a scale; returns the place of a value.
function scale(to, [low, high], top, left, tall) {
  to.small(count(high), left - 8, top + 9);
  to.small(count(low), left - 8, top + tall - 4);
  return value => top + 5 + (high - Number(value)) / (high - low) * (tall - 14);
}

export function lane(to, stretches, name, x, top, left, right) {
  to.label(name, left - 8, top + LANE - 5, colors.ink);
  to.inside(left, top, () => bars(to, stretches, x, top, left, right));
}

// The same bit of another recording, as a thin bar below.
export function below(to, stretches, x, top, left) {
  to.inside(left, top, () => {
    for (const [from, end, on] of stretches)
      if (on) to.rect(x(from), top + LANE - 3, Math.max(x(end) - x(from), 1.5), 3, colors.mark);
  });
}

// Nothing is drawn where the level is not known; half a bar is a stretch with edges that are too many to draw.
function bars(to, stretches, x, top, left, right) {
  const high = top + 3, low = top + LANE - 3, half = (high + low) / 2;
  for (const [from, end, on, many] of stretches) {
    if (on === null) continue;
    const wide = x(end) - x(from);
    to.line(Math.max(x(from), left), low, Math.min(x(end), right), low, colors.grid);
    if (many) to.rect(x(from), half, Math.max(wide, 1.5), low - half, colors.mark);
    else if (on) to.rect(x(from), high, Math.max(wide, 1.5), low - high, wide < THIN ? colors.mark : colors.bit);
    if (!many && on && wide < THIN) to.dot(x(from) + 0.75, high, colors.mark);
  }
}

// A tag: a BOOL as bars, a number as steps, a text in a box; nothing where the value is not known.
export function tagLane(to, { points, range, stretches }, name, x, top, left, right) {
  const tall = highOf(points);
  to.label(name, left - 8, tall === LANE ? top + LANE - 5 : top + tall / 2 + 4, colors.ink);
  if (tall === NUMBER) return numbers(to, stretches, range, x, top, left);
  to.inside(left, top, () => {
    if (!points.some(each => typeof each[1] === "string")) return bars(to, stretches, x, top, left, right);
    for (const [from, end, text] of stretches) if (text !== null) box(to, String(text), x(from), x(end), top, left);
  });
}

function numbers(to, stretches, range, x, top, left) {
  const y = scale(to, range, top, left, NUMBER);
  to.inside(left, top, () => {
    to.begin(colors.bit, 1.5);
    let known = false;
    for (const [from, end, value, least, most] of stretches) {
      if (value === null) { known = false; continue; }
      if (known) to.to(x(from), y(least ?? value)); else to.from(x(from), y(least ?? value));
      if (most !== undefined && most !== least) to.to(x(from), y(most));
      to.to(x(from), y(value));
      to.to(x(end), y(value));
      known = true;
    }
    to.end();
  });
}

function box(to, text, from, end, top, left) {
  const wide = Math.max(end - from, 1), begins = Math.max(from, left);
  to.frame(from, top + 2, wide, LANE - 4, colors.bit);
  const most = Math.floor((end - begins - 8) / LETTER);
  if (most >= 2)
    to.text(text.length > most ? `${text.slice(0, most - 1)}…` : text, begins + 4, top + LANE - 5, colors.ink);
}

// A value as the list of changes has it.
export const levelText = value => (value === 1 ? "on" : value === 0 ? "off" : shown(value));
