// What the rack shows at present. Frames are gathered and painted once per picture of the screen.

import { setAttribute } from "./dom.js";

const PARTS = ["words", "values", "machine", "power", "tags", "lines"]; // parts that come by what has changed
const MOST = 20000; // events while nothing is painted

export const run = { hello: null, state: "lost", forced: {}, breakpoints: [], faults: [], range: null };
const painters = [], takers = [], builders = [], programBuilders = [];
let pending = null, due = false;

// Calls build(hello) for each rack that introduces itself.
export const onHello = build => { builders.push(build); };

// Calls build(hello) also when a scan is shown that another program has run.
export const onProgram = build => { builders.push(build); programBuilders.push(build); };

// Calls paint(changes) with what has changed since the last picture.
export const onPaint = paint => { painters.push(paint); };

// Calls take(frame) with each frame, painted or not.
export const onFrame = take => { takers.push(take); };

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
  handles();
  for (const build of builders) build(hello);
}

// Shows the program that has run the scans shown from here on: routines and tags.
export function exchange(program) {
  pending = { ...pending, power: {}, tags: {} };
  Object.assign(run, { hello: { ...run.hello, ...program }, power: {}, tags: {} });
  for (const build of programBuilders) build(run.hello);
}

export function take(frame) {
  pending ??= {};
  if (run.hello) for (const each of takers) each(frame);
  for (const [name, value] of Object.entries(frame)) {
    if (PARTS.includes(name)) merge(name, value);
    else if (name === "events") pending.events = [...(pending.events ?? []), ...value].slice(-MOST);
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
    if (["strip", "lanes", "events"].includes(name)) continue; // pieces that were taken
    if (name === "machine" || name === "values") {
      for (const [slot, items] of Object.entries(value)) run[name][slot] = { ...run[name][slot], ...items };
    } else if (PARTS.includes(name)) Object.assign(run[name], value);
    else run[name] = value;
  }
  handles();
  for (const painter of painters) painter(changes);
}

// Power and values of the scan are not known yet: none is shown, least of all another scan's.
function forget(changes) {
  changes.power = Object.fromEntries(Object.keys(run.power).map(ident => [ident, ""]));
  changes.tags = Object.fromEntries(Object.keys(run.tags).map(name => [name, null]));
}

export const isPainted = () => !due;

// What scripts wait for, see docs/watch.md.
export function handles() {
  const root = document.documentElement;
  setAttribute(root, "data-scan", run.scan ?? null);
  setAttribute(root, "data-mode", run.mode ?? null);
  setAttribute(root, "data-time-ns", run.t ?? null);
  setAttribute(root, "data-late", run.late ?? null);
  setAttribute(root, "data-speed", run.speed?.reached ?? null);
  setAttribute(root, "data-state", run.state);
  setAttribute(root, "data-known", run.known === false ? "0" : "1");
}
