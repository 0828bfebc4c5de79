// Tags in the timing strip: which ones, and their points. A point is [t, value] or, of a number, [t, least, most,
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
let reported = () => {};
let have = { from: 0, to: 0 }, asking = null; // the time that was requested, and where the present question begins

export const tagNames = () => names;
export const pointsOf = name => points.get(name) ?? [];

// Begins with a rack; changed() is called when there is more to draw.
export function beginTags(changed) {
  names = kept("lanes", []).filter(name => typeof name === "string").slice(0, MOST);
  points = new Map();
  forgetAsked();
  reported = changed;
  if (names.length) send();
}

export const hasLane = name => names.some(each => isSame(each, name));

export function toggleTag(name) {
  const has = hasLane(name);
  if (!has && names.length >= MOST) return tell(`The strip has room for ${MOST} tags.`);
  names = has ? names.filter(each => !isSame(each, name)) : [...names, nameOf(name)];
  keep("lanes", names);
  send();
  reported(true);
}

// Asks for everything in view once more.
export function forgetAsked() {
  have = { from: 0, to: 0 };
  asking = null;
}

async function send() {
  forgetAsked();
  const answer = await order("lanes", { tags: names });
  if (!answer) return;
  names = names.filter(name => !answer.unknown.includes(name));
  if (answer.unknown.length) tell(`No tag is called ${answer.unknown.join(", ")}.`);
  reported(true);
}

// Takes a piece of the tags.
export function takeTags(piece) {
  if (!piece?.tags) return;
  for (const name of names) {
    const list = points.get(name) ?? [];
    put(list, piece.from, piece.to, piece.tags[name] ?? [[piece.from, null]]);
    forgetFar(list, piece.to);
    points.set(name, list);
  }
}

// Asks for the points of a time in view, piece by piece, as far as it has not been requested.
export async function fill(from, to) {
  const begin = missing(have, from, to), period = run.hello?.period_ns;
  if (!names.length || !period || begin === null || begin === asking) return;
  const mine = asking = begin, end = Math.ceil(to / period) - 1;
  try {
    for (let next = Math.floor(begin / period); next !== null && next <= end && mine === asking;) {
      const answer = await ask("steps", { from: next, to: end, tags: names });
      takeTags(answer.lanes);
      if (answer.lanes.tags) join(have, { from: next * period, to: answer.lanes.to });
      next = answer.next;
      reported(false);
    }
  } catch { /* what is there is shown */ }
  if (mine === asking) asking = null;
}

export const stretchesOf = (name, from, to) => stretches(pointsOf(name), from, to);
export const rangeOf = name => range(pointsOf(name));
