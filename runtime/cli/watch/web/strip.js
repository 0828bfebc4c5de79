// The timing strip: positions as an envelope, bits by their edges. A pulse of one scan is seen at any zoom.

import { at, button, el, heading, setText } from "./dom.js";
import { clock, count } from "./format.js";
import { keep, kept } from "./kept.js";
import { Lanes } from "./lanes.js";
import { pen, colours } from "./pen.js";
import { lookAt } from "./scrub.js";
import { ask } from "./socket.js";
import { onHello, onPaint, run } from "./state.js";
import { bitName } from "./words.js";

const SPANS = [0.2, 0.5, 1, 2, 5, 10, 20, 60]; // s
const TOP = 8, CURVE = 64, LANE = 17, AXIS = 20, LEAST_LANES = 6; // CSS pixels
const THIN = 2; // a pulse narrower than that many pixels is drawn as a needle
const MOST_LANES = 16;
const ROWS = 240; // edges that are listed

const canvas = el("canvas", { class: "chart", tabindex: "0", role: "img", "aria-label": "Timing: positions and bits over time", click: clicked, wheel: wheeled, keydown: keyed });
const spanText = el("output", { class: "figure" });
const signal = el("select", { "aria-label": "Signal", change: list });
const edges = el("ol", { class: "edges", "aria-label": "Edges, the latest first", tabindex: "0" });
const details = el("details", { class: "raw", toggle: list }, el("summary", {}, "Edges"), signal, edges);
const reduced = matchMedia("(prefers-reduced-motion: reduce)");

const signals = el("div", { class: "signals", role: "group", "aria-label": "Signals" });
const choice = el("details", { class: "raw", toggle: () => { if (choice.open) choices(); } }, el("summary", {}, "Signals"), signals);

let live = new Lanes([]), past = null, span = 5, listed = 0, chosen = {}, key = "";

onHello(hello => {
  live = new Lanes(hello.slots.flatMap(slot => slot.bits.map(bit => bitName(slot, bit))));
  past = null;
  asked = "";
  key = `scanrack signals ${hello.path}`;
  chosen = kept(key, {});
  signal.replaceChildren();
  at("strip").replaceChildren(
    heading("Timing", el("span", { class: "tools" }, button("Zoom out", () => zoom(1), { text: "−", class: "sign" }), spanText, button("Zoom in", () => zoom(-1), { text: "+", class: "sign" }))),
    canvas, el("div", { class: "line" }, choice, details));
  zoom(0);
});

onPaint(changes => {
  if (run.state !== "past") { live.take(changes); past = null; } else if (changes.scan !== undefined) look();
  if (changes.strip || changes.env || changes.scan !== undefined) draw();
  if (changes.strip && details.open && performance.now() - listed > 250) list();
});

function zoom(by) {
  const place = SPANS.indexOf(span) + by;
  span = SPANS[Math.min(Math.max(place, 0), SPANS.length - 1)];
  setText(spanText, span < 1 ? `${span * 1000} ms` : `${span} s`);
  if (run.state === "past") look();
  draw();
}

// What of time is in view: the present at the right, a scan of the past in the middle.
function view() {
  const wide = span * 1e9, t = run.t ?? 0;
  if (run.state === "past") return [t - wide / 2, t + wide / 2];
  const end = reduced.matches ? Math.ceil(t / (wide / 4)) * (wide / 4) : t; // in leaps, if motion is not wanted
  return [end - wide, end];
}

let asked = "";

// Asks for the strip around a scan of the past.
async function look() {
  const [from, to] = view().map(time => Math.max(Math.round(time / run.hello.period_ns), 0)), wish = `${from} ${to}`;
  if (wish === asked) return;
  asked = wish; // the scans in view
  try {
    const answer = await ask("window", { from, to, ...(live.names.length ? { signals: live.names } : {}) });
    if (wish !== asked) return;
    past = new Lanes(live.order);
    past.take(answer);
    live.learn(past);
    draw();
  } catch { /* what the ring still has is shown instead */ }
}

const lanes = () => past ?? live;

// The lanes that are drawn: those that were chosen, and those that have changed as long as nothing else is said.
const drawn = () => live.names.filter(name => chosen[name] ?? live.changed.has(name)).slice(0, MOST_LANES);

// The choice of signals, kept per rack in this browser.
function choices() {
  const boxes = live.names.map(name => el("label", {}, el("input", {
    type: "checkbox", checked: drawn().includes(name),
    change: event => { chosen[name] = event.target.checked; keep(key, chosen); draw(); },
  }), name));
  signals.replaceChildren(...boxes);
}

function draw() {
  const shown = lanes(), names = drawn(), curves = [...(shown.curves.size ? shown : live).curves.keys()];
  const wide = canvas.clientWidth, high = TOP + curves.length * CURVE + Math.max(names.length, LEAST_LANES) * LANE + AXIS;
  if (!wide) return;
  const newest = run.range ? run.range[1] * run.hello.period_ns : Infinity;
  const to = pen(canvas, wide, high), left = wide < 600 ? 96 : 168, [from, end] = view();
  const x = time => left + (time - from) / (end - from) * (wide - left - 8);
  grid(to, x, from, end, high);
  curves.forEach((name, place) => curve(to, shown.points(name, from, end), name, x, TOP + place * CURVE, left));
  names.forEach((name, place) => lane(to, shown.stretches(name, from, Math.min(end, newest)), name, x, TOP + curves.length * CURVE + place * LANE, left));
  const now = x(run.t ?? 0);
  to.line(now, 0, now, high - AXIS, run.state === "past" ? colours.mark : colours.edge, run.state === "past" ? 1.5 : 1);
}

function grid(to, x, from, end, high) {
  const wide = end - from, most = Math.max((x(end) - x(from)) / 90, 2);
  const power = 10 ** Math.floor(Math.log10(wide / most)), step = [1, 2, 5, 10].map(each => each * power).find(each => wide / each <= most);
  for (let time = Math.max(Math.ceil(from / step) * step, 0); time <= end; time += step) {
    to.line(x(time), 0, x(time), high - AXIS, colours.grid);
    to.text(clock(time), x(time), high - 6, colours.soft, "center");
  }
}

function curve(to, points, name, x, top, left) {
  to.label(name, left - 8, top + CURVE / 2 + 4, colours.ink);
  if (!points.length) return;
  const low = Math.min(...points.map(each => each[1])), high = Math.max(...points.map(each => each[2]), low + 1);
  const y = value => top + 5 + (high - value) / (high - low) * (CURVE - 14);
  to.small(count(high), left - 8, top + 9);
  to.small(count(low), left - 8, top + CURVE - 4);
  const present = Math.min(run.t ?? 0, view()[1]);
  to.inside(left, top, () => {
    to.begin(colours.curve, 1.5);
    to.from(x(points[0][0]), y(points[0][3]));
    points.forEach(([time, least, most, last], place) => {
      const before = points[place - 1]?.[3] ?? last, end = Math.max(points[place + 1]?.[0] ?? present, time);
      if (least < Math.min(before, last) || most > Math.max(before, last)) { // there and back between two pictures
        to.to(x(time), y(before));
        to.to(x((time + end) / 2), y(least));
        to.to(x((time + end) / 2), y(most));
      }
      to.to(x(end), y(last));
    });
    to.end();
  });
}

function lane(to, stretches, name, x, top, left) {
  to.label(name, left - 8, top + LANE - 5, colours.ink);
  const high = top + 3, low = top + LANE - 3;
  to.inside(left, top, () => {
    to.line(left, low, x(view()[1]), low, colours.grid);
    for (const [from, end, on] of stretches) {
      if (!on) continue;
      const wide = x(end) - x(from);
      to.rect(x(from), high, Math.max(wide, 1.5), low - high, wide < THIN ? colours.mark : colours.bit);
      if (wide < THIN) to.dot(x(from) + 0.75, high, colours.mark);
    }
  });
}

// The edges of one signal in words, for a reader of the screen and for scripts.
function list() {
  listed = performance.now();
  const names = lanes().names;
  if (signal.options.length !== names.length) {
    const before = signal.value;
    signal.replaceChildren(...names.map(name => el("option", { value: name, selected: name === before }, name)));
  }
  if (!details.open) return;
  const found = (lanes().bits.get(signal.value) ?? []).slice(-ROWS).reverse(), period = run.hello.period_ns;
  edges.replaceChildren(...found.map(([time, value]) => {
    const scan = Math.round(time / period);
    return el("li", { "data-scan": scan, "data-value": value ? "1" : "0" }, `${clock(time)}  scan ${count(scan)}  ${value ? "on" : "off"}`);
  }));
}

function clicked(event) {
  const left = canvas.clientWidth < 600 ? 96 : 168, share = (event.offsetX - left) / (canvas.clientWidth - left - 8), [from, end] = view();
  if (share >= 0 && share <= 1) lookAt((from + share * (end - from)) / run.hello.period_ns);
}

function wheeled(event) {
  if (!event.ctrlKey) return;
  event.preventDefault();
  zoom(Math.sign(event.deltaY));
}

function keyed(event) {
  const by = { "+": -1, "-": 1 }[event.key];
  if (by) zoom(by);
}

new ResizeObserver(() => { if (run.hello) draw(); }).observe(canvas);
colours.onChange(() => { if (run.hello) draw(); });
