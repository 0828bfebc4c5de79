// The present state of the rack. Frames are collected, and painted once per refresh of the screen.

import { setAttribute } from "./dom.js";

// parts of a frame that have only what has changed
const PARTS = ["words", "values", "machine", "power", "tags", "lines"];
const MOST_EVENTS = 20000; // kept while nothing is painted

export const run = { hello: null, state: "lost", forced: {}, breakpoints: [], faults: [], range: null };
const painters = [], frameTakers = [], builders = [], programBuilders = [];
let pending = null, due = false;

// Calls build(hello) for each rack or recording that the page connects to.
export const onHello = build => { builders.push(build); };

// Calls build(hello) as onHello does, and also when a scan is shown that ran with another program.
export const onProgram = build => { builders.push(build); programBuilders.push(build); };

// Calls paint(changes) with what has changed since the last picture.
export const onPaint = paint => { painters.push(paint); };

// Calls take(frame) with each frame, painted or not.
export const onFrame = take => { frameTakers.push(take); };

export function greet(hello) {
  pending = null;
  Object.assign(run, {
    hello,
    state: "paused",
    paused: true,
    known: true,
    scan: undefined,
    t: undefined,
    forced: {},
    breakpoints: [],
    faults: [],
    range: null,
  });
  for (const part of PARTS) run[part] = {};
  setHandles();
  for (const build of builders) build(hello);
}

// Shows another program, that of the scans shown from now on: its routines and tags.
export function exchange(program) {
  pending = { ...pending, power: {}, tags: {} };
  Object.assign(run, { hello: { ...run.hello, ...program }, power: {}, tags: {} });
  for (const build of programBuilders) build(run.hello);
}

export function take(frame) {
  pending ??= {};
  if (run.hello) for (const each of frameTakers) each(frame);
  for (const [name, value] of Object.entries(frame)) {
    if (PARTS.includes(name)) merge(name, value);
    else if (name === "events") pending.events = [...(pending.events ?? []), ...value].slice(-MOST_EVENTS);
    else if (name === "forced")
      pending.forced = Array.isArray(value) ? Object.fromEntries(value.map(tag => [tag, null])) : value;
    else pending[name] = value;
  }
  if (!due) { due = true; requestAnimationFrame(paint); }
}

function merge(part, value) {
  const into = pending[part] ??= {};
  for (const [key, item] of Object.entries(value)) {
    const nested = part === "machine" || part === "values";
    into[key] = nested ? { ...into[key], ...item } : item;
  }
}

function paint() {
  due = false;
  const changes = pending;
  pending = null;
  if (!changes || !run.hello) return;
  if (changes.known === false) forget(changes);
  for (const [name, value] of Object.entries(changes)) {
    if (["strip", "lanes", "events"].includes(name)) continue; // their takers have them already
    if (name === "machine" || name === "values") {
      for (const [slot, items] of Object.entries(value)) run[name][slot] = { ...run[name][slot], ...items };
    } else if (PARTS.includes(name)) Object.assign(run[name], value);
    else run[name] = value;
  }
  setHandles();
  for (const painter of painters) painter(changes);
}

// Clears power and values, which are not known yet for this scan: those of another scan must not be shown.
function forget(changes) {
  changes.power = Object.fromEntries(Object.keys(run.power).map(ident => [ident, ""]));
  changes.tags = Object.fromEntries(Object.keys(run.tags).map(name => [name, null]));
}

export const isPainted = () => !due;

// Sets the attributes that scripts wait for, see docs/watch.md.
export function setHandles() {
  const root = document.documentElement;
  setAttribute(root, "data-scan", run.scan ?? null);
  setAttribute(root, "data-mode", run.mode ?? null);
  setAttribute(root, "data-time-ns", run.t ?? null);
  setAttribute(root, "data-late", run.late ?? null);
  setAttribute(root, "data-speed", run.speed?.reached ?? null);
  setAttribute(root, "data-state", run.state);
  setAttribute(root, "data-known", run.known === false ? "0" : "1");
}
