// The known points of lanes:
//   [t, value]               the value from a time on; null: unknown
//   [t, level, edges]        the number of edges of a bit in a stretch, and the level after them
//   [t, least, most, last]   the values of a number in a stretch

const MOST = 60000; // points of a lane
const KEPT_NS = 120e9; // duration that is kept of a growing lane
const SETTLED_NS = 50e6; // earlier edges belong to the power-up, and do not show a lane

// Replaces the points of a lane in a time, [from, to), with a piece. If the first point of the piece is later than
// `from`, the value before it continues. The values after the piece stay; without any they are unknown.
export function put(list, from, to, items) {
  const next = after(list, to - 1), old = list[after(list, to) - 1];
  const later = list.slice(next);
  if (later[0]?.[0] !== to) later.unshift(old && old[0] < to ? [to, ...old.slice(1)] : [to, null]);
  list.length = after(list, from - 1);
  for (const item of items) extend(list, item);
  for (const item of later) extend(list, item);
}

function extend(list, item) {
  const last = list.at(-1);
  if (item.length !== 2 || last?.length !== 2 || last[1] !== item[1]) list.push(item); // otherwise it is no edge
}

// Drops points far from a piece that ends at a time: older than two minutes, or beyond the maximum number.
export function forgetFar(list, to) {
  const grows = list.at(-1)[0] === to,
    old = grows && list[0][0] < to - 1.25 * KEPT_NS ? after(list, to - KEPT_NS) - 1 : 0;
  list.splice(0, Math.max(old, after(list, to) - MOST, 0));
  if (list.length > MOST) list.splice(MOST, Infinity, [list[MOST][0], null]);
}

// Extends the known time by a piece, [from, to); a piece after a gap replaces it.
export function join(have, { from, to }) {
  const apart = from > have.to || to < have.from;
  Object.assign(have, apart ? { from, to } : { from: Math.min(have.from, from), to: Math.max(have.to, to) });
}

// Returns the time from which points are missing for a time in view, or null.
export function missing(have, from, to) {
  if (from < have.from || from > have.to) return from;
  return to > have.to ? have.to : null;
}

// Returns the stretches of a lane in a time: [from, to, value], and the edges of a bit or the least and greatest
// value in it. An unknown value is null.
export function stretches(list, from, to) {
  const result = [];
  for (let index = Math.max(after(list, from) - 1, 0); index < list.length && list[index][0] <= to; index++) {
    const [time, ...values] = list[index],
      value = valueOf(list[index]),
      bounds = [Math.max(time, from), Math.min(list[index + 1]?.[0] ?? to, to)];
    result.push([...bounds, value, ...(values.length === 3 ? values.slice(0, 2) : values.slice(1))]);
  }
  return result;
}

// The value from a point on.
export const valueOf = point => (point.length === 4 ? point[3] : point[1]);

// Returns the least and the greatest value in lanes, at least one apart.
export function range(...lists) {
  let low = Infinity, high = -Infinity;
  for (const point of lists.flat()) {
    if (point.length !== 4) continue;
    low = Math.min(low, Number(point[1]));
    high = Math.max(high, Number(point[2]));
  }
  return low < high ? [low, high] : [low === Infinity ? 0 : low, (low === Infinity ? 0 : low) + 1];
}

// Returns the index of the first point later than a time.
export function after(list, time) {
  let low = 0, high = list.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (list[middle][0] > time) high = middle; else low = middle + 1;
  }
  return low;
}

// The bits and positions of the strip.
export class Lanes {
  constructor(order) {
    this.order = order; // names in the order of the lanes
    this.bits = new Map(); // name -> points
    this.curves = new Map(); // name -> points
    this.levels = new Map(); // name -> the latest level
    this.changed = new Set(); // names of bits with an edge so far
    this.have = { from: 0, to: 0 }; // the known time, without gaps
  }

  // Adds a piece; it may begin later than the requested time `queried`.
  take(piece, queried = piece?.from) {
    if (!piece?.bits) return;
    const { from, to, bits, positions } = piece;
    for (const name of new Set([...this.bits.keys(), ...Object.keys(bits)]))
      this.putBit(name, from, to, bits[name] ?? []);
    for (const [name, items] of Object.entries(positions)) putInto(this.curves, name, from, to, items);
    join(this.have, { from: queried, to });
  }

  putBit(name, from, to, items) {
    putInto(this.bits, name, from, to, items);
    for (const [time, level, edges] of items) {
      if (time > SETTLED_NS && level !== null && (edges || (this.levels.get(name) ?? level) !== level))
        this.changed.add(name);
      if (level !== null) this.levels.set(name, level);
    }
  }

  // Adds the names of other lanes, and of those that have changed, for a trace that has no new pieces.
  learn(other) {
    for (const name of other.bits.keys()) if (!this.bits.has(name)) this.bits.set(name, []);
    for (const name of other.changed) this.changed.add(name);
  }

  get names() {
    const rankOf = name => { const index = this.order.indexOf(name); return index < 0 ? this.order.length : index; };
    return [...this.bits.keys()].sort((a, b) => rankOf(a) - rankOf(b));
  }

  // Returns the points of a position in a time, and one on either side.
  points(name, from, to) {
    const all = this.curves.get(name) ?? [];
    return all.slice(Math.max(after(all, from) - 1, 0), after(all, to) + 1);
  }
}

function putInto(lanes, name, from, to, items) {
  if (!lanes.has(name)) lanes.set(name, []);
  const list = lanes.get(name);
  put(list, from, to, items);
  forgetFar(list, to);
}
