// The rail of an axis: switches below it, stations above it, the shaft, the position that the module knows, and the
// target.
// Positions are steps of the shaft since power-up; `zero` is the step at which the module's position is 0.

import { el, reading, setAttribute, setText, svg } from "./dom.js";
import { count, plain, stepOf } from "./format.js";
import { run } from "./state.js";

const HEIGHT = 139, RAIL = 82, STATIONS = 26, SWITCHES = 32, SIDE = 34; // CSS pixels
const ROOM = 0.25; // part of the rail's length that is added when the axis leaves the rail
const LETTER = 6.7; // CSS pixels
const TURN = 2000; // steps or counts of one turn of the encoder's dial

export function railOf(slot) {
  return slot.machine ? new Rail(slot) : null;
}

class Rail {
  constructor(slot) {
    this.slot = slot;
    this.machine = slot.machine;
    this.above = slot.machine.stations?.length ? 0 : STATIONS;
    this.tall = HEIGHT - this.above - (slot.machine.switches?.length ? 0 : SWITCHES);
    this.low = slot.machine.min;
    this.high = slot.machine.max;
    this.picture = svg("svg", {
      class: "rail",
      height: this.tall,
      role: "img",
      "aria-label": `Axis of slot ${slot.number}`,
    });
    this.readings = readings(slot.machine.encoder, `${slot.number}.shaft`);
    this.node = el("div", { class: "machine" }, this.picture, this.readings.node);
    // Machines are read at intervals, and once more in a pause; the frame of the pause has the same time.
    this.paint = changes => {
      if (changes.t !== undefined || changes.machine) this.move(run.machine[slot.number] ?? {});
    };
    new ResizeObserver(() => this.draw()).observe(this.node);
  }

  // Widens the rail where the axis leaves it: a machine without bounds may go anywhere.
  widenTo(position) {
    if (typeof position !== "number" || (this.low <= position && position <= this.high)) return;
    const low = Math.min(this.low, position), high = Math.max(this.high, position), room = (high - low) * ROOM;
    if (low < this.low) this.low = low - room;
    if (high > this.high) this.high = high + room;
    this.width = 0;
    this.draw();
  }

  x(position) {
    return SIDE + (position - this.low) / (this.high - this.low) * (this.width - 2 * SIDE);
  }

  // Draws the parts that do not move; `move` places the others.
  draw() {
    const width = this.node.clientWidth;
    if (!width || width === this.width) return;
    this.width = width;
    setAttribute(this.picture, "width", width);
    setAttribute(this.picture, "viewBox", `0 ${this.above} ${width} ${this.tall}`);
    this.switches = (this.machine.switches ?? []).map(each => ({ spec: each, node: this.switchOf(each) }));
    this.omitOverlappingNames();
    this.parts = movingParts();
    this.picture.replaceChildren(
      svg("line", { class: "rail-line", x1: SIDE - 14, x2: width - SIDE + 14, y1: RAIL, y2: RAIL }),
      ...this.ticks(), ...this.switches.map(each => each.node),
      ...(this.machine.stations ?? []).map(each => this.stationOf(each)),
      ...(this.machine.jams ?? []).map(each => this.jamOf(each)), ...Object.values(this.parts));
    this.move(run.machine[this.slot.number] ?? {});
  }

  // Leaves out names of switches that would overlap; their tooltips show them.
  omitOverlappingNames() {
    let end = -Infinity;
    for (const { node } of [...this.switches].sort((one, other) => one.node.reach[0] - other.node.reach[0])) {
      if (node.reach[0] < end) node.lastChild.remove();
      else end = node.reach[1] + 2;
    }
  }

  ticks() {
    const most = Math.max((this.width - 2 * SIDE) / 84, 2), found = [];
    const step = Math.max(stepOf(this.high - this.low, most), 1);
    for (let value = Math.ceil(this.low / step) * step; value <= this.high; value += step) {
      const x = this.x(value);
      found.push(svg("line", { class: "tick", x1: x, x2: x, y1: RAIL + 4, y2: RAIL + 9 }),
        svg("text", { class: "tick", x, y: RAIL + 22, "text-anchor": "middle" }, count(value || 0))); // no -0
    }
    return found;
  }

  // A switch is a bar below the rail, as wide as the range in which it is operated.
  switchOf({ input, first, last, normally_closed: closed }) {
    const from = Math.max(first === null || first === undefined ? 6 : this.x(first), 6);
    const to = Math.min(last === null || last === undefined ? this.width - 6 : this.x(last), this.width - 6);
    const width = Math.max(to - from, 4), middle = (from + to) / 2;
    const anchor = middle < 46 ? "start" : middle > this.width - 46 ? "end" : "middle";
    const x = { start: 6, end: this.width - 6, middle }[anchor];
    const begin = { start: x, middle: x - input.length * LETTER / 2, end: x - input.length * LETTER }[anchor];
    const node = svg("g", { class: "switch" },
      svg("title", {}, `${input}${closed ? ", normally closed" : ""}: ${first ?? "…"} to ${last ?? "…"}`),
      svg("rect", { x: from, y: RAIL + 31, width, height: 8, rx: 2 }),
      svg("text", { x, y: RAIL + 53, "text-anchor": anchor }, input));
    return Object.assign(node, { reach: [begin, begin + input.length * LETTER] });
  }

  stationOf({ position, input }) {
    const x = this.x(position);
    return svg("g", { class: "station" }, svg("title", {}, `Station at ${position}, signals ${input}`),
      svg("path", { d: `M${x - 6} 4h12v7l-6 6l-6 -6z` }));
  }

  jamOf({ at, direction }) {
    const x = this.x(at);
    return svg("g", { class: "jam" }, svg("title", {}, `Jam at ${at}, moves ${direction} end there`),
      svg("path", { d: `M${x - 4} ${RAIL - 4}l8 8m-8 0l8 -8` }));
  }

  move({ shaft, position, target, encoder, speed, zero }) {
    if (!this.parts) return;
    const known = onShaft(position, zero);
    this.widenTo(shaft ?? known);
    this.placePart(this.parts.cart, shaft); // hidden when the shaft is not known, in the past
    this.placePart(this.parts.known, known);
    this.placePart(this.parts.target, onShaft(target, zero));
    for (const { spec, node } of this.switches) setAttribute(node, "data-value", operated(spec, shaft));
    this.readings.show({ shaft, position, target, speed, encoder });
  }

  placePart(node, position) {
    const isKnown = position !== null && position !== undefined;
    setAttribute(node, "visibility", isKnown ? "visible" : "hidden");
    const x = isKnown ? Math.min(Math.max(this.x(position), 8), this.width - 8) : 0;
    if (isKnown) setAttribute(node, "transform", `translate(${Math.round(x * 10) / 10})`);
  }
}

// A position of the module in steps of the shaft.
const onShaft = (position, zero) => typeof position === "number" ? position + (zero ?? 0) : position;

// Whether the shaft operates a switch: "1" or "0", null if it is not known.
const operated = ({ first, last }, shaft) =>
  shaft === undefined || shaft === null
    ? null
    : (first ?? -Infinity) <= shaft && shaft <= (last ?? Infinity)
      ? "1"
      : "0";

const movingParts = () => ({
  target: svg(
    "g",
    { class: "target" },
    svg("title", {}, "Target"),
    svg("path", { d: `M0 ${RAIL - 52}V${RAIL}` }),
    svg("path", { class: "flag", d: `M0 ${RAIL - 52}h13l-4 5l4 5h-13z` })
  ),
  cart: svg(
    "g",
    { class: "cart" },
    svg("title", {}, "Shaft"),
    svg("rect", { x: -17, y: RAIL - 24, width: 34, height: 19, rx: 5 }),
    svg("path", { d: `M0 ${RAIL - 19}v9` }),
    svg("circle", { cx: -9, cy: RAIL - 4, r: 3.5 }),
    svg("circle", { cx: 9, cy: RAIL - 4, r: 3.5 })
  ),
  known: svg(
    "g",
    { class: "known" },
    svg("title", {}, "Position that the module knows"),
    svg("path", { d: `M0 ${RAIL - 27}l-6 -9h12z` })
  ),
});

// The readings below the rail, each of a fixed width.
function readings(hasEncoder, shaftName) {
  const titles = {
    shaft: "Shaft",
    position: "Position",
    target: "Target",
    speed: "Steps/s",
    ...(hasEncoder ? { encoder: "Encoder" } : {}),
  };
  const figures = Object.fromEntries(
    Object.entries(titles).map(([name, title]) => [name, reading(title, "middle")])
  );
  figures.shaft.value.dataset.name = shaftName;
  const needle = svg("path", { d: "M0 0V-8", class: "needle" });
  const dial = svg(
    "svg",
    { class: "dial", viewBox: "-11 -11 22 22", width: 22, height: 22, "aria-hidden": "true" },
    svg("circle", { r: 9.5 }),
    needle
  );
  const nodes = Object.values(figures).map(each => each.node);
  const node = el("div", { class: "figures" }, ...nodes, hasEncoder ? dial : null);
  const show = values => {
    figures.shaft.value.dataset.value = plain(values.shaft);
    for (const [name, { value: output }] of Object.entries(figures)) {
      const value = values[name];
      setText(output, value === null || value === undefined ? "–" : count(value));
    }
    if (hasEncoder && values.encoder !== undefined)
      setAttribute(needle, "transform", `rotate(${((values.encoder % TURN) / TURN) * 360})`);
  };
  return { node, show };
}
