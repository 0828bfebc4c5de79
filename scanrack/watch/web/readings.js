// The values of lanes between two scans as a table for a spreadsheet: lines with tabs.

import { clock } from "./format.js";
import { Lanes, after, put, stretches, valueOf } from "./lanes.js";
import { plain } from "./format.js";
import { ask } from "./source.js";
import { run } from "./state.js";

const HEAD = ["lane", "at A", "at B", "least", "greatest", "edges"];

// Asks for the values of bits, positions and tags from one scan to another; returns the table.
export async function readings(signals, tags, scans) {
  const [first, last] = [...scans].sort((one, other) => one - other), period = run.hello.period_ns;
  const lanes = new Lanes(signals), to = last + 1;
  lanes.take((await ask("window", { from: first, to: last })).strip, first * period);
  const points = new Map(tags.map(tag => [tag, []]));
  for (let next = first; tags.length && next !== null && next <= last;) {
    const answer = await ask("steps", { from: next, to: last, tags }), piece = answer.lanes;
    for (const [tag, list] of points) if (piece.tags) put(list, piece.from, piece.to, piece.tags[tag] ?? []);
    ({ next } = answer);
  }
  const listOf = name => points.get(name) ?? lanes.curves.get(name) ?? lanes.bits.get(name) ?? [];
  const ends = scans.map(scan => scan * period);
  const rows = [...lanes.curves.keys(), ...tags, ...signals].map(name =>
    rowOf(name, listOf(name), ends, first * period, to * period - 1)
  );
  const cursors = scans.map((scan, index) => ["AB"[index], `scan ${scan}`, clock(scan * period)]);
  return [...cursors, HEAD, ...rows].map(row => row.join("\t")).join("\n");
}

// The value at a time in the form that a spreadsheet takes; a bit is 1 or 0.
const valueAt = (list, time) => plain(valueOf(list[after(list, time) - 1] ?? [0, null]));

function rowOf(name, list, ends, from, to) {
  const parts = stretches(list, from, to).filter(([, , value]) => value !== null),
    isNumber = list.some(each => each.length === 4);
  const least = parts.map(([, , value, low]) => Number(isNumber ? low ?? value : value));
  const most = parts.map(([, , value, , high]) => Number(isNumber ? high ?? value : value));
  const figures = isNumber ? [Math.min(...least), Math.max(...most), ""] : ["", "", edgesOf(list, from)];
  return [name, ...ends.map(time => valueAt(list, time)), ...figures];
}

// The number of edges of a bit after the first scan.
function edgesOf(list, from) {
  let edges = 0, before = null;
  for (const point of list) {
    const value = valueOf(point);
    if (point.length === 3) edges += point[2];
    else if (point[0] > from && before !== null && value !== null && value !== before) edges += 1;
    before = value;
  }
  return edges;
}
