// Tags in the timing strip: which ones, and their points. A point is [t, value] or, of a number, [t, least, most, last].

import { after } from "./lanes.js";
import { keep, kept } from "./kept.js";
import { tell } from "./notice.js";
import { ask } from "./socket.js";
import { run } from "./state.js";

export const MOST = 16;
const KEPT_NS = 120e9, KEPT_POINTS = 60000;

let names = [], key = "", points = new Map(), wish = "", told = () => {};

export const tagNames = () => names;
export const pointsOf = name => points.get(name) ?? [];

// Begins with a rack; changed() is called when there is more to draw.
export function beginTags(hello, changed) {
  key = `scanrack lanes ${hello.path}`;
  names = kept(key, []).filter(name => typeof name === "string").slice(0, MOST);
  points = new Map();
  wish = "";
  told = changed;
  if (names.length) send();
}

export function toggleTag(name) {
  if (!names.includes(name) && names.length >= MOST) return tell(`The strip has room for ${MOST} tags.`);
  names = names.includes(name) ? names.filter(each => each !== name) : [...names, name];
  keep(key, names);
  send();
  told(true);
}

async function send() {
  wish = "";
  try {
    const { unknown } = await ask("lanes", { tags: names });
    names = names.filter(name => !unknown.includes(name));
    if (unknown.length) tell(`No tag is called ${unknown.join(", ")}.`);
    told(true);
  } catch (refused) {
    tell(refused.message);
  }
}

// Takes what a frame says of the tags.
export function takeTags(lanes) {
  for (const [name, items] of Object.entries(lanes ?? {})) {
    const list = points.get(name) ?? [];
    if (list.length && items[0][0] < list.at(-1)[0]) list.length = Math.max(after(list, items[0][0] - 1), 0);
    extend(list, items);
    const old = list.at(-1)[0] - KEPT_NS;
    if (list.length > KEPT_POINTS || list[0][0] < old - KEPT_NS / 4) list.splice(0, Math.max(after(list, old) - 1, list.length - KEPT_POINTS));
    points.set(name, list);
  }
}

// Appends points, without those that repeat the one before.
function extend(list, items) {
  for (const item of items) if (!same(list.at(-1), item)) list.push(item);
}

const same = (one, other) => one !== undefined && one.at(-1) === other.at(-1) && one.length === other.length && (other.length < 4 || other[1] === other[2]);

// Asks for the points of the scans in view, piece by piece, unless they are there.
export async function fill(from, to) {
  if (!names.length || !run.hello) return;
  const mine = `${from} ${to} ${names.join("\n")}`;
  if (mine === wish) return;
  wish = mine;
  try {
    for (let next = from; next !== null && mine === wish;) {
      const answer = await ask("steps", { from: next, to, tags: names });
      const end = answer.next ?? to + 1;
      for (const name of names) put(name, next, end, answer.lanes[name] ?? []);
      next = answer.next;
      told(false);
    }
  } catch { /* what is there is shown */ }
}

// Puts the points of some scans in the place of those that were there. Each piece begins with a point, changed or not.
function put(name, from, end, items) {
  if (!items.length) return;
  const period = run.hello.period_ns, list = points.get(name) ?? [];
  const all = list.slice(0, after(list, from * period - 1));
  extend(all, items);
  extend(all, list.slice(after(list, end * period - 1)));
  points.set(name, all);
}

// The stretches of a tag from one time to another: [from, to, value, least, most], the first one from before.
export function stretchesOf(name, from, to) {
  const list = pointsOf(name), found = [];
  for (let at = Math.max(after(list, from) - 1, 0); at < list.length && list[at][0] <= to; at++) {
    const [time, ...rest] = list[at], [least, most] = rest.length === 3 ? rest : [];
    found.push([Math.max(time, from), Math.min(list[at + 1]?.[0] ?? to, to), rest.at(-1), least, most]);
  }
  return found;
}

// The least and the greatest value of a number that are known.
export function rangeOf(name) {
  let low = Infinity, high = -Infinity;
  for (const point of pointsOf(name)) {
    if (point.length !== 4) continue;
    low = Math.min(low, point[1]);
    high = Math.max(high, point[2]);
  }
  return low < high ? [low, high] : [low === Infinity ? 0 : low, (low === Infinity ? 0 : low) + 1];
}
