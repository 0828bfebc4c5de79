// The tags in the timing strip and their points. A point is [t, value]; the point of a number is [t, least, most,
// last].

import { forgetFar, join, missing, put, range, stretches } from "./lanes.js";
import { keep, kept } from "./kept.js";
import { tell } from "./notice.js";
import { order } from "./orders.js";
import { ask } from "./source.js";
import { run } from "./state.js";
import { isSame } from "./values.js";
import { nameOf } from "./words.js";

export const MOST = 16;

let names = [], points = new Map();
/** @type {(others: boolean) => void} */
let onChange = () => {};
let have = { from: 0, to: 0 }, askingFrom = null; // the known time, and where the present request begins

export const tagNames = () => names;
export const pointsOf = name => points.get(name) ?? [];

// Begins with a rack or a recording; changed() is called when there is more to draw.
export function beginTags(changed) {
  names = kept("lanes", []).filter(name => typeof name === "string").slice(0, MOST);
  points = new Map();
  forgetAsked();
  onChange = changed;
  if (names.length) requestLanes();
}

export const hasLane = name => names.some(each => isSame(each, name));

export function toggleTag(name) {
  const has = hasLane(name);
  if (!has && names.length >= MOST) return tell(`The strip has room for ${MOST} tags.`);
  names = has ? names.filter(each => !isSame(each, name)) : [...names, nameOf(name)];
  keep("lanes", names);
  requestLanes();
  onChange(true);
}

// Forgets what was requested: everything in view is requested again.
export function forgetAsked() {
  have = { from: 0, to: 0 };
  askingFrom = null;
}

async function requestLanes() {
  forgetAsked();
  const answer = await order("lanes", { tags: names });
  if (!answer) return;
  names = names.filter(name => !answer.unknown.includes(name));
  if (answer.unknown.length) tell(`There is no tag ${answer.unknown.join(", ")}.`);
  onChange(true);
}

// Adds a piece of the tags' points.
export function takeTags(piece) {
  if (!piece?.tags) return;
  for (const name of names) {
    const list = points.get(name) ?? [];
    put(list, piece.from, piece.to, piece.tags[name] ?? [[piece.from, null]]);
    forgetFar(list, piece.to);
    points.set(name, list);
  }
}

// Requests the missing points of the time in view, piece by piece.
export async function fill(from, to) {
  const begin = missing(have, from, to), period = run.hello?.period_ns;
  if (!names.length || !period || begin === null || begin === askingFrom) return;
  const start = askingFrom = begin, end = Math.ceil(to / period) - 1;
  try {
    for (let next = Math.floor(begin / period); next !== null && next <= end && start === askingFrom;) {
      const answer = await ask("steps", { from: next, to: end, tags: names });
      takeTags(answer.lanes);
      if (answer.lanes.tags) join(have, { from: next * period, to: answer.lanes.to });
      next = answer.next;
      onChange(false);
    }
  } catch { /* the known part is shown */ }
  if (start === askingFrom) askingFrom = null;
}

export const stretchesOf = (name, from, to) => stretches(pointsOf(name), from, to);
export const rangeOf = name => range(pointsOf(name));
