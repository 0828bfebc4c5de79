"use strict";
// The data of the page and the part in view. Time is in ns since power-up, x and y in CSS pixels.

const data = JSON.parse(document.getElementById("data").textContent);
const canvas = document.getElementById("chart");
const readout = document.getElementById("readout");
const pen = canvas.getContext("2d");
const LEFT = 150, RIGHT = 14, TOP = 6, AXIS = 40;
const MARKS = 50, HEAD = 30, LEAST_POSITION = 150, SPEED = 96, NUMBER = 56, LANE = 18, GAP = 14, MARK_ROWS = 3;
let POSITION = LEAST_POSITION; // grows with the window
const INSTANTS = 120; // most lines through the curves for marks
const MARK_FONT = "11px system-ui", SMALL = "11px system-ui", NAME_FONT = "11px ui-monospace, monospace";
const LEAST_LABEL = 40; // smallest visible part of a band's label, pixels
const GROUP = 64; // number of rows with a stored least and greatest value
const MISSING = -2147483648;
const LEAST_SPAN = 1e5; // ns across the chart when zoomed in as far as it goes
const ALL = { start: data.start, end: Math.max(data.end, data.start + 1) };
let view = { ...ALL };
let cursor = null; // time under the pointer
let band = null; // [time, time] while an area to zoom into is drawn
let time, scan; // of every scan: Float64Array, Int32Array

// A packed column, deflated, base64: values, or differences from scan to scan. Int32 sums wrap, as they did when
// packed.
async function unpack(text, Kind, differences = true) {
  const bytes = Uint8Array.from(atob(text), letter => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const values = new Kind(await new Response(stream).arrayBuffer());
  for (let i = 1; differences && i < values.length; i++) values[i] += values[i - 1];
  return values;
}

const KINDS = {
  Int32: Int32Array, Float32: Float32Array, Float64: Float64Array, BigInt64: BigInt64Array, BigUint64: BigUint64Array,
};

// 64-bit integers are drawn as doubles; the readout shows them exactly.
async function unpackCurve(packed) {
  const values = await unpack(packed.curve, KINDS[packed.kind], packed.differences);
  return packed.kind.startsWith("Big") ? { ...curve(Float64Array.from(values, Number)), whole: values } : curve(values);
}

function curve(values) {
  const groups = Math.ceil(values.length / GROUP), whole = values instanceof Int32Array;
  const low = new values.constructor(groups).fill(whole ? 2147483647 : Infinity);
  const high = new values.constructor(groups).fill(whole ? MISSING : -Infinity);
  const isMissing = whole ? value => value === MISSING : value => !Number.isFinite(value);
  for (let i = 0; i < values.length; i++) {
    const value = values[i];
    if (isMissing(value)) continue;
    const group = i / GROUP | 0;
    if (value < low[group]) low[group] = value;
    if (value > high[group]) high[group] = value;
  }
  return { values, low, high, isMissing };
}

// Least and greatest of the rows first to end - 1, or null where there is no value.
function extremes(curve, first, end) {
  let least = Infinity, most = -Infinity;
  const take = (low, high) => { if (low < least) least = low; if (high > most) most = high; };
  for (let i = first; i < end;) {
    if (i % GROUP === 0 && i + GROUP <= end) {
      if (curve.high[i / GROUP] >= curve.low[i / GROUP]) take(curve.low[i / GROUP], curve.high[i / GROUP]);
      i += GROUP;
    } else {
      if (!curve.isMissing(curve.values[i])) take(curve.values[i], curve.values[i]);
      i++;
    }
  }
  return least > most ? null : [least, most];
}

// Index of the first entry of a sorted list that is greater than a value.
function above(list, value) {
  let low = 0, high = list.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (list[middle] > value) high = middle; else low = middle + 1;
  }
  return low;
}

const rowAt = moment => Math.max(0, above(time, moment) - 1);
const stepAt = (lane, row) => Math.max(0, above(lane.rows, row) - 1);
const stepValue = (lane, step) => lane.values ? lane.values[step] : (step + lane.first) % 2;
const valueAt = (lane, row) => stepValue(lane, stepAt(lane, row));
