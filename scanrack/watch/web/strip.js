// The timing strip: positions as envelopes, bits and tags by their edges. A pulse of one scan is visible at any zoom.

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
// lanes that have room from the start, so that nothing moves when bits change for the first time
const ROOM = 10, ROOM_PER_AXIS = 4;
const MOST_LANES = 24;
// CSS pixels: a position in a low strip; the most for a position; the heading, the times and the choices together
const LOW = 40, MOST_CURVE = 320, BESIDE = 100;
const ROWS = 240; // edges in the list
const LEAST_SCANS = 4; // of a view
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
const signal = el("select", { "aria-label": "Signal", change: listEdges });
const edges = el("ol", { class: "edges", "aria-label": "Edges, the latest first", tabindex: "0" });
const details = el("details", { class: "raw", toggle: listEdges }, el("summary", {}, "Edges"), signal, edges);
const reduced = matchMedia("(prefers-reduced-motion: reduce)");

const signals = el("div", { class: "signals", role: "group", "aria-label": "Signals" });
const choice = el(
  "details",
  {
    class: "raw",
    toggle: () => {
      if (choice.open) showChoices();
    },
  },
  el("summary", {}, "Signals"),
  signals
);

let heldView = null; // the view that was dragged over, ns
let curveHeight = CURVE; // CSS pixels of a position
let live = new Lanes([]),
  past = new Lanes([]),
  span = 5,
  listedAt = 0,
  chosen = {},
  room = ROOM,
  axes = [],
  isAsking = false,
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

// Pieces are taken as they come, since a page that is not visible is not painted.
onFrame(({ strip, lanes }) => {
  live.take(strip);
  takeTags(lanes);
});

onPaint(changes => {
  if (run.state === "past" || changes.strip) requestMissing();
  if (changes.state || (run.state === "past" && changes.range)) fillSoon();
  if (changes.strip || changes.lanes || changes.scan !== undefined || changes.range) draw();
  if ((changes.strip || changes.lanes) && details.open && performance.now() - listedAt > LIST_MS) listEdges();
});

// Draws again after the points of tags have changed; `others`: the tags in the strip, too.
function changed(others) {
  if (others) {
    fillSoon();
    if (choice.open) showChoices();
  }
  if (details.open) listEdges();
  draw();
}

// Shows a longer time, or a shorter one.
export function zoom(by) {
  const wider = SPANS.findIndex(each => each > span), narrower = SPANS.findLastIndex(each => each < span);
  if (by > 0 && wider >= 0) span = SPANS[wider];
  if (by < 0 && narrower >= 0) span = SPANS[narrower];
  heldView = null;
  respan();
}

// Views the time that was dragged over on the axis. The view is kept as long as it has the scan shown.
function zoomTo(from, to) {
  const period = run.hello.period_ns,
    [begin, end] = [from, to].map(time => Math.max(Math.round(time / period), 0) * period);
  if (end - begin < LEAST_SCANS * period) return;
  heldView = { from: begin, to: end };
  span = (end - begin) / 1e9;
  respan();
  if (run.state !== "past" || run.t < begin || run.t > end) lookAt((begin + end) / 2 / period);
}

function respan() {
  setText(spanText, timeText(Math.round(span * 1e9)));
  past = new Lanes(live.order); // a span has its own number of points
  forgetAsked();
  requestMissing();
  fillSoon();
  draw();
}

// The time in view: the present is at the right end, a scan of the past in the middle.
function view() {
  const duration = span * 1e9, t = run.t ?? 0;
  // no empty time after the end of a recording
  const least = orders.recorded() ? (run.range?.[1] ?? 0) * run.hello.period_ns : Infinity;
  if (run.state === "past" && heldView && t >= heldView.from && t <= heldView.to) return [heldView.from, heldView.to];
  if (run.state === "past") {
    const end = Math.max(Math.min(t + duration / 2, least), duration);
    return [end - duration, end];
  }
  // in steps, for users who want less motion
  const end = reduced.matches ? Math.ceil(t / (duration / 4)) * (duration / 4) : t;
  return [end - duration, end];
}

// The part of the time in view that has scans, ns.
function viewed() {
  const period = run.hello.period_ns, [from, to] = view(), [first, last] = run.range ?? [0, -1];
  return [Math.max(Math.floor(from / period), first) * period, Math.min(Math.ceil(to / period), last + 1) * period];
}

// Requests the missing part of the time in view, while the rack continues: around a scan of the past, or before the
// first piece of a page that was opened later; that is requested only once.
async function requestMissing() {
  if (run.state === "past") fillSoon();
  if (isAsking || !lanes().have.to && run.state !== "past") return; // after the answer it is called again
  const period = run.hello.period_ns, [from, end] = viewed(), into = lanes();
  const to = into === live ? Math.min(end, live.have.from) : end;
  const begin = missing(into.have, from, to);
  if (begin === null || begin >= to) return;
  isAsking = true;
  try {
    const answer = await ask("window", {
      from: begin / period,
      to: to / period - 1,
      ...(live.names.length ? { signals: live.names } : {}),
    });
    into.take(answer.strip, begin);
    live.learn(into);
    draw();
    if (details.open) listEdges();
  } catch { /* the known part is shown */ }
  if (into === live) live.have.from = Math.min(begin, live.have.from);
  isAsking = false;
  if (run.state === "past" ? viewed().join() !== [from, to].join() : viewed()[0] < live.have.from) requestMissing();
}

// Asks for the tags of the time in view, now and then.
function fillSoon() {
  if (tagNames().length) filling ||= setTimeout(() => { filling = 0; fill(...viewed()); }, FILL_MS);
}

const lanes = () => (run.state === "past" ? past : live);

// The lanes that are drawn: the chosen ones, and as many of those that have changed as there is room for.
function drawn() {
  const requested = live.names.filter(name => chosen[name]), free = Math.max(room - requested.length, 0);
  const others = live.names.filter(name => !(name in chosen) && live.changed.has(name)).slice(0, free);
  return live.names.filter(name => requested.includes(name) || others.includes(name)).slice(0, MOST_LANES);
}

// The lanes that are on at some time in view; for a running rack also in the same span before, so that lanes of
// pulses stay.
function withLevels(shown) {
  const [from, end] = view(), since = run.state === "live" ? 2 * from - end : from;
  const has = ([, , on, changes]) => on || changes;
  return drawn().filter(name => stretches(shown.bits.get(name) ?? [], since, end).some(has));
}

// Shows the number of empty lanes in their place; a click unfolds them.
function paintFold(empty, top, left) {
  setFlag(fold, "hidden", !empty);
  setText(fold, `${unfolded ? "▾" : "▸"} ${many(empty, "empty lane")}`);
  setAttribute(fold, "aria-expanded", String(unfolded));
  Object.assign(fold.style, { top: `${top}px`, width: `${left - 8}px` });
}

// The choice of signals, kept per rack in this browser: bits, and the tags that are watched or drawn.
function showChoices() {
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
    active = withLevels(shown),
    empty = drawn().filter(name => !active.includes(name)),
    names = [...active, ...(unfolded ? empty : [])];
  const tags = tagNames().map(name => ({ name, points: pointsOf(name) })), width = canvas.clientWidth;
  const bitsHigh = Math.max(names.length + Math.sign(empty.length), room) * LANE;
  const tagsHigh = tags.reduce((sum, tag) => sum + highOf(tag.points), 0),
    others = TOP + tagsHigh + Math.max(bitsHigh, 3 * LANE);
  if (!width) return;
  const least = at("strip").clientHeight < 200 ? LOW : CURVE;
  const share = Math.floor((at("strip").clientHeight - BESIDE - others) / axes.length);
  curveHeight = Math.max(least, Math.min(MOST_CURVE, share));
  const seen =
      at("strip").clientHeight - at("strip").firstChild.offsetHeight - AXIS - TOP - tagsHigh - axes.length * least,
    rest = seen % LANE;
  // no half lane above the times
  if (curveHeight === least && seen > 0 && axes.length) curveHeight += Math.floor(rest / axes.length);
  const high = others + axes.length * curveHeight;
  const to = pen(canvas, width, high), left = leftOf(width), [from, end] = view();
  const axis = axisOf(width), x = axis.x;
  grid(to, pen(times, width, AXIS), x, left, from, end, high);
  let top = TOP;
  const other = run.state === "past" ? besideLanes(...viewed()) : null;
  for (const name of axes) {
    // the scale of an axis at rest, too
    const scale = range(live.curves.get(name) ?? [], past.curves.get(name) ?? [], other?.curves.get(name) ?? []);
    if (other)
      curve(to, other.points(name, from, end), scale, run.hello.period_ns, "", x, top, left, curveHeight, colors.mark);
    curve(to, shown.points(name, from, end), scale, run.hello.period_ns, name, x, top, left, curveHeight);
    top += curveHeight;
  }
  for (const { name, points } of tags) {
    tagLane(to, { points, range: rangeOf(name), stretches: stretchesOf(name, from, end) }, name, x, top, left, x(end));
    top += highOf(points);
  }
  const foldTop = top + active.length * LANE;
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

// The scale of time in a strip of a width: from the names to its right end, CSS pixels.
function axisOf(width) {
  const left = leftOf(width), right = width - 8, [from, end] = view();
  const x = time => left + ((time - from) / (end - from)) * (right - left),
    time = place => from + ((place - left) / (right - left)) * (end - from);
  return { from, end, left, right, x, time };
}

// The lanes for the large plot: those that are drawn, positions and tags first.
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

// Where a bit is drawn: top and left in CSS pixels, and a function from a horizontal position to its time in ns.
export function placeOf(bit) {
  const { left, time } = axisOf(canvas.clientWidth),
    tags = tagNames().reduce((sum, name) => sum + highOf(pointsOf(name)), 0);
  return { top: TOP + axes.length * curveHeight + tags + withLevels(lanes()).indexOf(bit) * LANE, left, time };
}

const leftOf = width => (width < 400 ? 120 : width < 600 ? 140 : 168); // width of the names

// Lists the edges of one signal as text, for screen readers and scripts.
function listEdges() {
  listedAt = performance.now();
  const names = [...tagNames(), ...lanes().names];
  if (names.join("\n") !== [...signal.options].map(option => option.value).join("\n")) {
    const before = signal.value;
    signal.replaceChildren(...optionsOf(names, before));
  }
  if (!details.open) return;
  const points = tagNames().includes(signal.value) ? pointsOf(signal.value) : lanes().bits.get(signal.value) ?? [];
  edges.replaceChildren(...points.filter(isEdge).slice(-ROWS).reverse().map(edgeOf));
}

// Whether a point is an edge. The end of a lane, and the same level again after a gap, are not.
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
