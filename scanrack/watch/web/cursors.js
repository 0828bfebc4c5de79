// The cursors A and B over the timing strip, with the time and the scans between them.

import { button, el, setAttribute, setFlag, setText } from "./dom.js";
import { clock, count, many, timeText } from "./format.js";
import { tell } from "./notice.js";
import { onHello, run } from "./state.js";

const SNAP = 7; // a dragged cursor snaps to an edge within this distance, CSS pixels
const KEYS = { ArrowLeft: -1, ArrowRight: 1, PageDown: -100, PageUp: 100 };

const lines = ["A", "B"].map((name, place) =>
  el(
    "div",
    {
      class: "cursor",
      role: "slider",
      tabindex: "0",
      "aria-label": `Cursor ${name}`,
      hidden: true,
      keydown: event => keyed(event, place),
      pointerdown: taken,
      pointermove: event => dragged(event, place),
    },
    el("span", { "aria-hidden": "true" }, name)
  )
);
export const between = el("output", { class: "between figure", "aria-label": "Between the cursors", hidden: true });
export const cursorLayer = el("div", { class: "layer" }, ...lines);
export const cursorButton = button("Cursors A B", both, {
  text: "A B",
  title: "Show or hide two cursors with the time between them (c sets one at this scan)",
  "aria-pressed": "false",
});

export const copyButton = button("Copy readings", copy, {
  text: "Copy",
  title: "Copy the lanes between the cursors to the clipboard as a table",
  hidden: true,
});

/** @type {(scans: number[]) => Promise<string>} */
let table = async () => "";
let scans = [], axis = null; // scans of A and B, as far as they are set
/** @type {(time: number, within: number) => number | null} */
let edge = () => null;

onHello(() => { scans = []; paint(); });

// Follows the strip: its axis, and edge(time, within), which returns the time of the nearest edge or null.
export function moveCursors(shown, nearest) {
  axis = shown;
  edge = nearest;
  paint();
}

// Sets the function that makes the table of readings between two scans.
export function onCopy(makeTable) { table = makeTable; }

async function copy() {
  try {
    const text = await table([...scans]);
    await navigator.clipboard.writeText(text);
    tell(`Copied the readings of ${text.split("\n").length - 3} lanes to the clipboard.`, "news");
  } catch (refused) {
    tell(`Nothing was copied: ${refused.message}`);
  }
}

// Sets A at the scan shown, then B, then removes both.
export function setCursor() {
  scans = scans.length === 2 ? [] : [...scans, run.scan ?? 0];
  paint();
}

function both() {
  const { from, end } = axis, at = share => scanOf(from + share * (end - from));
  scans = scans.length ? [] : [at(0.4), at(0.7)];
  paint();
}

const scanOf = time => Math.max(Math.round(time / run.hello.period_ns), 0);
const timeOf = scan => scan * run.hello.period_ns;

function set(place, scan) {
  scans[place] = Math.max(scan, 0);
  paint();
}

function taken(event) {
  event.preventDefault();
  event.currentTarget.focus();
  event.currentTarget.setPointerCapture(event.pointerId);
}

function dragged(event, place) {
  if (!lines[place].hasPointerCapture(event.pointerId)) return;
  const time = axis.time(event.clientX - cursorLayer.getBoundingClientRect().left),
    within = axis.time(SNAP) - axis.time(0);
  set(place, scanOf(edge(time, within) ?? time));
}

function keyed(event, place) {
  const by = KEYS[event.key];
  if (!by) return;
  event.preventDefault();
  set(place, scans[place] + by);
}

function paint() {
  setAttribute(cursorButton, "aria-pressed", String(scans.length > 0));
  lines.forEach((line, place) => paintLine(line, scans[place]));
  setFlag(between, "hidden", scans.length < 2);
  setFlag(copyButton, "hidden", scans.length < 2);
  const apart = Math.abs(scans[1] - scans[0]);
  // 84 ms, 42 scans
  if (scans.length === 2) setText(between, `${timeText(apart * run.hello.period_ns)}, ${many(apart, "scan")}`);
}

function paintLine(line, scan) {
  const x = scan === undefined || !axis ? -1 : axis.x(timeOf(scan));
  setFlag(line, "hidden", x < (axis?.left ?? 0) || x > axis.right);
  if (scan === undefined) return;
  line.style.left = `${x}px`;
  setAttribute(line, "aria-valuenow", scan);
  setAttribute(line, "aria-valuetext", `scan ${count(scan)}, ${clock(timeOf(scan))}`);
}
