// The previous and the next change of a tag or a bit, found with questions that every source answers.

import { count } from "./format.js";
import { valueOf } from "./lanes.js";
import { tell } from "./notice.js";
import { lookAt } from "./scrub.js";
import { lastChange } from "./since.js";
import { ask } from "./source.js";
import { run } from "./state.js";
import { bitAt, bitName } from "./words.js";

const PIECE = 4096, MOST = 50; // scans per question; questions for a change

const WORD = /^(Local:\d+:[IO]\.Data\[\d+\]|[IO]:\d+\.\d+)$/i; // of an image

let generation = 0; // number of the latest search

export const toPrevious = tag => go(tag, previous, "before");
export const toNext = tag => go(tag, next, "after");

async function go(tag, search, where) {
  if (!tag) return tell("Select a tag first: click a contact.");
  const mine = ++generation, from = run.scan, isCurrent = () => mine === generation;
  try {
    const scan = await search(tag, from, isCurrent);
    if (!isCurrent()) return;
    if (scan === null) tell(`No known change of ${tag} ${where} scan ${count(from)}.`);
    if (scan !== null || run.scan !== from) await lookAt(scan ?? from);
  } catch (refused) {
    tell(refused.message);
  }
}

// If the tag has changed in the scan shown, the search begins one scan earlier.
async function previous(tag, from, isCurrent) {
  const since = await lastChange(tag, isCurrent);
  if (!since || since.scan < from) return since?.scan ?? null;
  if (from <= run.range[0]) return null;
  await ask("look", { scan: from - 1 });
  return (await lastChange(tag, isCurrent))?.scan ?? null;
}

async function next(tag, from, isCurrent) {
  const last = run.range[1];
  for (let queried = 0; from < last && queried < MOST && isCurrent(); queried += 1) {
    const to = Math.min(from + PIECE - 1, last), scan = await changeIn(tag, from, to);
    if (scan !== null) return scan;
    from = to; // the next piece begins with the value in this scan
  }
  return null;
}

// Returns the first scan in a range with another value than the scan before it, or null.
async function changeIn(tag, from, to) {
  const points = await pointsOf(tag, from, to), scanOf = ([t]) => Math.round(t / run.hello.period_ns);
  let previousValue = null;
  for (const [index, point] of points.entries()) {
    const value = valueOf(point), hasChanges = varies(point), scan = scanOf(point);
    if (previousValue !== null && value !== null && value !== previousValue && !hasChanges) return scan;
    if (hasChanges && to - from > 1) { // several changes in a point: search its scans
      const end = index + 1 < points.length ? scanOf(points[index + 1]) : to, start = Math.max(scan - 1, from);
      return start === from && end >= to
        ? changeIn(tag, from, from + Math.floor((to - from) / 2))
        : changeIn(tag, start, end);
    }
    previousValue = value;
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

// Returns the name of the lane of an image bit.
function signalOf(tag) {
  const bit = bitAt(tag), slot = run.hello.slots.find(({ bits }) => bits.includes(bit));
  return slot && bitName(slot, bit);
}
