// The timing strip: positions as an envelope, bits and tags by their edges. A pulse of one scan is seen at any zoom.

import { causes, onCauses } from "./causes.js";
import { besideLanes, onBeside } from "./besidelanes.js";
import { AXIS, CURVE, LANE, TOP, below, curve, grid, highOf, lane, numbered, levelText, tagLane } from "./chart.js";
import { between, copyButton, cursorButton, cursorLayer, moveCursors, onCopy } from "./cursors.js";
import { dragZoom } from "./dragging.js";
import { at, button, el, heading, optionsOf, setAttribute, setFlag, setText } from "./dom.js";
import { clock, count, many, timeText } from "./format.js";
import { keep, kept } from "./kept.js";
import { Lanes, missing, range, stretches, valueOf } from "./lanes.js";
import { colorOf, marksAxis, marksButtons, marksIn } from "./marks.js";
import * as orders from "./orders.js";
import { pen, colors } from "./pen.js";
import { drawPlot, plotButton } from "./plot.js";
import { readings } from "./readings.js";
import { lookAt, scrubber } from "./scrub.js";
import { ask } from "./source.js";
import { onFrame, onHello, onPaint, run } from "./state.js";
import {
  beginTags,
  fill,
  forgetAsked,
  pointsOf,
  rangeOf,
  stretchesOf,
  tagNames,
  takeTags,
  toggleTag,
} from "./taglanes.js";
import { watchedTags } from "./watchtable.js";
import { bitName } from "./words.js";

const SPANS = [0.2, 0.5, 1, 2, 5, 10, 20, 60]; // s
// lanes for which there is room from the start: nothing moves when bits change first
const ROOM = 10, ROOM_PER_AXIS = 4;
const MOST_LANES = 24;
// CSS pixels: of a position in a low strip, and where there is room; of the heading, the times and the choices
const LOW = 40, MOST_CURVE = 320, BESIDE = 100;
const ROWS = 240; // edges that are listed
const LEAST_SCANS = 4; // that a view may have
const LIST_MS = 250, FILL_MS = 200;

const canvas = el("canvas", {
  class: "chart",
  tabindex: "0",
  role: "img",
  "aria-label": "Timing: positions, bits and tags over time",
  click: clicked,
  wheel: wheeled,
});
const times = el("canvas", { class: "axis", "aria-hidden": "true" });
const axisOver = dragZoom(times, place => axisOf(canvas.clientWidth).time(place), zoomTo);
axisOver.addEventListener("dblclick", () => zoom(1));
const fold = el("button", {
  type: "button",
  class: "plain fold",
  "aria-expanded": "false",
  click: () => {
    unfolded = !unfolded;
    draw();
  },
});
const spanText = el("output", { class: "figure" });
const signal = el("select", { "aria-label": "Signal", change: list });
const edges = el("ol", { class: "edges", "aria-label": "Edges, the latest first", tabindex: "0" });
const details = el("details", { class: "raw", toggle: list }, el("summary", {}, "Edges"), signal, edges);
const reduced = matchMedia("(prefers-reduced-motion: reduce)");

const signals = el("div", { class: "signals", role: "group", "aria-label": "Signals" });
const choice = el(
  "details",
  {
    class: "raw",
    toggle: () => {
      if (choice.open) choices();
    },
  },
  el("summary", {}, "Signals"),
  signals
);

let held = null; // the view that was dragged over, ns
let tall = CURVE; // of a position
let live = new Lanes([]),
  past = new Lanes([]),
  span = 5,
  listed = 0,
  chosen = {},
  room = ROOM,
  axes = [],
  asking = false,
  filling = 0,
  unfolded = false;

onHello(hello => {
  live = new Lanes(hello.slots.flatMap(slot => slot.bits.map(bit => bitName(slot, bit))));
  past = new Lanes(live.order);
  axes = hello.slots
    .filter(slot => slot.values.some(value => value.name === "position"))
    .map(slot => `${slot.number}.position`);
  room = Math.min(
    ROOM + ROOM_PER_AXIS * axes.length,
    MOST_LANES,
    hello.slots.reduce((sum, slot) => sum + slot.bits.length, 0)
  );
  chosen = kept("signals", {});
  signal.replaceChildren();
  at("strip").replaceChildren(
    heading(
      "Timing",
      scrubber(marksAxis, ...marksButtons),
      el(
        "span",
        { class: "tools" },
        between,
        copyButton,
        cursorButton,
        plotButton(plotted),
        button("Zoom out", () => zoom(1), { text: "−", class: "sign" }),
        spanText,
        button("Zoom in", () => zoom(-1), { text: "+", class: "sign" })
      )
    ),
    el("div", { class: "over" }, canvas, fold, cursorLayer),
    axisOver,
    el("div", { class: "line" }, choice, details)
  );
  beginTags(changed);
  zoom(0);
});

// Pieces are taken as they come: a page that is not seen is not painted.
onFrame(({ strip, lanes }) => {
  live.take(strip);
  takeTags(lanes);
});

onPaint(changes => {
  if (run.state === "past" || changes.strip) look();
  if (changes.state || (run.state === "past" && changes.range)) fillSoon();
  if (changes.strip || changes.lanes || changes.scan !== undefined || changes.range) draw();
  if ((changes.strip || changes.lanes) && details.open && performance.now() - listed > LIST_MS) list();
});

// The tags in the strip, or their points, have changed.
function changed(others) {
  if (others) {
    fillSoon();
    if (choice.open) choices();
  }
  if (details.open) list();
  draw();
}

// Shows more of time, or less.
export function zoom(by) {
  const wider = SPANS.findIndex(each => each > span), narrower = SPANS.findLastIndex(each => each < span);
  if (by > 0 && wider >= 0) span = SPANS[wider];
  if (by < 0 && narrower >= 0) span = SPANS[narrower];
  held = null;
  respan();
}

// What was dragged over on the axis is the view, as long as the scan shown is in it.
function zoomTo(from, to) {
  const period = run.hello.period_ns,
    [begin, end] = [from, to].map(time => Math.max(Math.round(time / period), 0) * period);
  if (end - begin < LEAST_SCANS * period) return;
  held = { from: begin, to: end };
  span = (end - begin) / 1e9;
  respan();
  if (run.state !== "past" || run.t < begin || run.t > end) lookAt((begin + end) / 2 / period);
}

function respan() {
  setText(spanText, timeText(Math.round(span * 1e9)));
  past = new Lanes(live.order); // in as many points as this span has room for
  forgetAsked();
  look();
  fillSoon();
  draw();
}

// What of time is in view: the present at the right, a scan of the past in the middle.
function view() {
  const wide = span * 1e9, t = run.t ?? 0;
  // no empty time behind a recording
  const least = orders.recorded() ? (run.range?.[1] ?? 0) * run.hello.period_ns : Infinity;
  if (run.state === "past" && held && t >= held.from && t <= held.to) return [held.from, held.to];
  if (run.state === "past") { const end = Math.max(Math.min(t + wide / 2, least), wide); return [end - wide, end]; }
  const end = reduced.matches ? Math.ceil(t / (wide / 4)) * (wide / 4) : t; // in leaps, if motion is not requested
  return [end - wide, end];
}

// The time in view of which there are scans, ns.
function viewed() {
  const period = run.hello.period_ns, [from, to] = view(), [first, last] = run.range ?? [0, -1];
  return [Math.max(Math.floor(from / period), first) * period, Math.min(Math.ceil(to / period), last + 1) * period];
}

// Requests what is missing of the time in view, while the rack continues: around a scan of the past, or before the
// first piece of a page that was opened later. That is requested once.
async function look() {
  if (run.state === "past") fillSoon();
  if (asking || !lanes().have.to && run.state !== "past") return; // what is missing after the answer is requested then
  const period = run.hello.period_ns, [from, end] = viewed(), into = lanes();
  const to = into === live ? Math.min(end, live.have.from) : end;
  const begin = missing(into.have, from, to);
  if (begin === null || begin >= to) return;
  asking = true;
  try {
    const answer = await ask("window", {
      from: begin / period,
      to: to / period - 1,
      ...(live.names.length ? { signals: live.names } : {}),
    });
    into.take(answer.strip, begin);
    live.learn(into);
    draw();
    if (details.open) list();
  } catch { /* what is there is shown */ }
  if (into === live) live.have.from = Math.min(begin, live.have.from);
  asking = false;
  if (run.state === "past" ? viewed().join() !== [from, to].join() : viewed()[0] < live.have.from) look();
}

// Asks for the tags of the time in view, now and then.
function fillSoon() {
  if (tagNames().length) filling ||= setTimeout(() => { filling = 0; fill(...viewed()); }, FILL_MS);
}

const lanes = () => (run.state === "past" ? past : live);

// The lanes that are drawn: those that were chosen, and those that have changed as far as there is room.
function drawn() {
  const requested = live.names.filter(name => chosen[name]), free = Math.max(room - requested.length, 0);
  const others = live.names.filter(name => !(name in chosen) && live.changed.has(name)).slice(0, free);
  return live.names.filter(name => requested.includes(name) || others.includes(name)).slice(0, MOST_LANES);
}

// The lanes with a level in view; while the scans continue also in as long a time before, so that a lane of pulses
// stays.
function busy(shown) {
  const [from, end] = view(), since = run.state === "live" ? 2 * from - end : from;
  const has = ([, , on, changes]) => on || changes;
  return drawn().filter(name => stretches(shown.bits.get(name) ?? [], since, end).some(has));
}

// Says how many lanes are empty, where they would be; a click unfolds them.
function paintFold(empty, top, left) {
  setFlag(fold, "hidden", !empty);
  setText(fold, `${unfolded ? "▾" : "▸"} ${many(empty, "empty lane")}`);
  setAttribute(fold, "aria-expanded", String(unfolded));
  Object.assign(fold.style, { top: `${top}px`, width: `${left - 8}px` });
}

// The choice of signals, kept per rack in this browser: bits, and the tags that are watched or drawn.
function choices() {
  const bits = live.names.map(name =>
    choiceOf(name, drawn().includes(name), on => {
      chosen[name] = on;
      keep("signals", chosen);
      draw();
    })
  );
  const tags = [...new Set([...tagNames(), ...watchedTags()])];
  signals.replaceChildren(
    ...bits,
    ...tags.map(name => choiceOf(name, tagNames().includes(name), () => toggleTag(name)))
  );
}

const choiceOf = (name, checked, choose) =>
  el(
    "label",
    { title: name },
    el("input", { type: "checkbox", checked, change: event => choose(event.target.checked) }),
    el("span", {}, name)
  );

function draw() {
  const shown = lanes(),
    alive = busy(shown),
    empty = drawn().filter(name => !alive.includes(name)),
    names = [...alive, ...(unfolded ? empty : [])];
  const tags = tagNames().map(name => ({ name, points: pointsOf(name) })), wide = canvas.clientWidth;
  const bitsHigh = Math.max(names.length + Math.sign(empty.length), room) * LANE;
  const tagsHigh = tags.reduce((sum, tag) => sum + highOf(tag.points), 0),
    others = TOP + tagsHigh + Math.max(bitsHigh, 3 * LANE);
  if (!wide) return;
  const least = at("strip").clientHeight < 200 ? LOW : CURVE;
  tall = Math.max(least, Math.min(MOST_CURVE, Math.floor((at("strip").clientHeight - BESIDE - others) / axes.length)));
  const seen =
      at("strip").clientHeight - at("strip").firstChild.offsetHeight - AXIS - TOP - tagsHigh - axes.length * least,
    rest = seen % LANE;
  if (tall === least && seen > 0 && axes.length) tall += Math.floor(rest / axes.length); // no half lane above the times
  const high = others + axes.length * tall;
  const to = pen(canvas, wide, high), left = leftOf(wide), [from, end] = view();
  const axis = axisOf(wide), x = axis.x;
  grid(to, pen(times, wide, AXIS), x, left, from, end, high);
  let top = TOP;
  const other = run.state === "past" ? besideLanes(...viewed()) : null;
  for (const name of axes) {
    // one that rests
    const scale = range(live.curves.get(name) ?? [], past.curves.get(name) ?? [], other?.curves.get(name) ?? []);
    if (other)
      curve(to, other.points(name, from, end), scale, run.hello.period_ns, "", x, top, left, tall, colors.mark);
    curve(to, shown.points(name, from, end), scale, run.hello.period_ns, name, x, top, left, tall);
    top += tall;
  }
  for (const { name, points } of tags) {
    tagLane(to, { points, range: rangeOf(name), stretches: stretchesOf(name, from, end) }, name, x, top, left, x(end));
    top += highOf(points);
  }
  const foldTop = top + alive.length * LANE;
  paintFold(empty.length, foldTop, left);
  for (const name of names) {
    if (top === foldTop && empty.length) top += LANE;
    lane(to, stretches(shown.bits.get(name) ?? [], from, end), name, x, top, left, x(end));
    if (other) below(to, stretches(other.bits.get(name) ?? [], from, end), x, top, left);
    top += LANE;
  }
  if (!names.length && !tags.length && !axes.length)
    to.text("Nothing has changed yet.", left, TOP + 2 * LANE, colors.soft);
  const period = run.hello.period_ns;
  for (const [scan, kind] of marksIn(from / period, end / period))
    to.rect(x(scan * period) - 1, 0, 2, TOP, colorOf(kind));
  numbered(to, causes.filter(({ t }) => t >= from && t <= end), x, high);
  const now = x(run.t ?? 0);
  to.line(now, 0, now, high, run.state === "past" ? colors.mark : colors.edge, run.state === "past" ? 1.5 : 1);
  moveCursors(axis, nearestEdge);
  drawPlot();
}

// Where times are in a strip of that width: between the names and its right end, CSS pixels.
function axisOf(wide) {
  const left = leftOf(wide), right = wide - 8, [from, end] = view();
  const x = time => left + ((time - from) / (end - from)) * (right - left),
    time = place => from + ((place - left) / (right - left)) * (end - from);
  return { from, end, left, right, x, time };
}

// What is plotted larger: the lanes that are drawn, positions and tags first.
const plotted = {
  names: () => [...axes, ...tagNames(), ...drawn()],
  points: name =>
    tagNames().includes(name) ? pointsOf(name) : (lanes().curves.get(name) ?? lanes().bits.get(name) ?? []),
  view,
};

onCopy(scans => readings(drawn(), tagNames(), scans));

// The time of the edge of a lane that is nearest to a time, or null if none is within reach.
function nearestEdge(time, within) {
  const lists = [...drawn().map(name => lanes().bits.get(name) ?? []), ...tagNames().map(pointsOf)];
  const times = lists
    .flatMap(points => points.filter(isEdge).map(([t]) => t))
    .filter(t => Math.abs(t - time) <= within);
  return times.length ? times.reduce((best, t) => (Math.abs(t - time) < Math.abs(best - time) ? t : best)) : null;
}

// Where a bit is drawn: its top and left, CSS pixels, and the time of a place, ns.
export function placeOf(bit) {
  const { left, time } = axisOf(canvas.clientWidth),
    tags = tagNames().reduce((sum, name) => sum + highOf(pointsOf(name)), 0);
  return { top: TOP + axes.length * tall + tags + busy(lanes()).indexOf(bit) * LANE, left, time };
}

const leftOf = wide => (wide < 400 ? 120 : wide < 600 ? 140 : 168); // where time begins, beside the names

// The edges of one signal in words, for a reader of the screen and for scripts.
function list() {
  listed = performance.now();
  const names = [...tagNames(), ...lanes().names];
  if (names.join("\n") !== [...signal.options].map(option => option.value).join("\n")) {
    const before = signal.value;
    signal.replaceChildren(...optionsOf(names, before));
  }
  if (!details.open) return;
  const points = tagNames().includes(signal.value) ? pointsOf(signal.value) : lanes().bits.get(signal.value) ?? [];
  edges.replaceChildren(...points.filter(isEdge).slice(-ROWS).reverse().map(edgeOf));
}

// Where a lane ends, or continues with the same level after a gap, is not an edge.
function isEdge(point, place, points) {
  let before = place - 1;
  while (before >= 0 && valueOf(points[before]) === null) before--;
  const varies = point.length === 3 || point[1] !== valueOf(point);
  return valueOf(point) !== null && (varies || before < 0 || valueOf(points[before]) !== valueOf(point));
}

function edgeOf(point) {
  const [time, , changes] = point, value = valueOf(point), scan = Math.round(time / run.hello.period_ns);
  const after = point.length === 3 ? ` after ${changes} edges` : "";
  const says = point.length === 4 ? value : levelText(value) + after;
  return el("li", { "data-scan": scan, "data-value": value }, `${clock(time)}  scan ${count(scan)}  ${says}`);
}

function clicked(event) {
  const { left, right, time } = axisOf(canvas.clientWidth);
  if (event.offsetX >= left && event.offsetX <= right) lookAt(time(event.offsetX) / run.hello.period_ns);
}

function wheeled(event) {
  if (!event.ctrlKey) return;
  event.preventDefault();
  zoom(Math.sign(event.deltaY));
}

new ResizeObserver(() => { if (run.hello) draw(); }).observe(canvas);
onCauses(() => { if (run.hello) draw(); });
onBeside(() => { if (run.hello) draw(); });
colors.onChange(() => { if (run.hello) draw(); });
