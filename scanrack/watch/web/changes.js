// The previous and the next change of a tag or a bit, from the questions that every source answers.

import { count } from "./format.js";
import { valueOf } from "./lanes.js";
import { tell } from "./notice.js";
import { lookAt } from "./scrub.js";
import { lastChange } from "./since.js";
import { ask } from "./source.js";
import { run } from "./state.js";
import { bitAt, bitName } from "./words.js";

const PIECE = 4096, MOST = 50; // scans of a question; questions for one change

const WORD = /^(Local:\d+:[IO]\.Data\[\d+\]|[IO]:\d+\.\d+)$/i; // of an image

let generation = 0; // of the latest wish

export const toPrevious = tag => go(tag, previous, "before");
export const toNext = tag => go(tag, next, "after");

async function go(tag, search, where) {
  if (!tag) return tell("Select a tag first: click a contact.");
  const mine = ++generation, from = run.scan;
  try {
    const found = await search(tag, from, () => mine === generation);
    if (mine !== generation) return;
    if (found === null) tell(`No change of ${tag} is known ${where} scan ${count(from)}.`);
    if (found !== null || run.scan !== from) await lookAt(found ?? from);
  } catch (refused) {
    tell(refused.message);
  }
}

// A tag that has changed in the scan shown is looked at one scan earlier.
async function previous(tag, from, goesOn) {
  const since = await lastChange(tag, goesOn);
  if (!since || since.scan < from) return since?.scan ?? null;
  if (from <= run.range[0]) return null;
  await ask("look", { scan: from - 1 });
  return (await lastChange(tag, goesOn))?.scan ?? null;
}

async function next(tag, from, goesOn) {
  const last = run.range[1];
  for (let queried = 0; from < last && queried < MOST && goesOn(); queried += 1) {
    const to = Math.min(from + PIECE - 1, last), found = await changeIn(tag, from, to);
    if (found !== null) return found;
    from = to; // its value is what the next piece begins with
  }
  return null;
}

// The first scan from one to another whose value is not that of the scan before.
async function changeIn(tag, from, to) {
  const points = await pointsOf(tag, from, to), scanOf = ([t]) => Math.round(t / run.hello.period_ns);
  let before = null;
  for (const [place, point] of points.entries()) {
    const value = valueOf(point), many = varies(point), scan = scanOf(point);
    if (before !== null && value !== null && value !== before && !many) return scan;
    if (many && to - from > 1) { // several changes in one point: its scans one by one
      const end = place + 1 < points.length ? scanOf(points[place + 1]) : to, within = Math.max(scan - 1, from);
      return within === from && end >= to
        ? changeIn(tag, from, from + Math.floor((to - from) / 2))
        : changeIn(tag, within, end);
    }
    before = value;
  }
  return null;
}

const varies = point => (point.length === 3 && point[2] > 0) || (point.length === 4 && point[1] !== point[2]);

async function pointsOf(tag, from, to) {
  const signal = signalOf(tag);
  if (!signal && WORD.test(tag)) throw new Error(`${tag} is a word: select one of its bits.`);
  if (signal) return (await ask("window", { from, to, signals: [signal] })).strip.bits?.[signal] ?? [];
  return (await ask("steps", { from, to, tags: [tag] })).lanes.tags?.[tag] ?? [];
}

// The lane of a bit of an image.
function signalOf(tag) {
  const bit = bitAt(tag), slot = run.hello.slots.find(each => each.bits.includes(bit));
  return slot && bitName(slot, bit);
}
