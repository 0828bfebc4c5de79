// What is known of lanes, in points:
//   [t, value]               the value from then on; null: not known
//   [t, level, edges]        so many edges of a bit in a stretch, and its level behind them
//   [t, least, most, last]   the values of a number in a stretch

const MOST = 60000; // points of a lane
const KEPT_NS = 120e9; // how long a lane that grows is kept
const SETTLED_NS = 50e6; // edges before that are of the power-up and of no interest to begin with

// Puts a piece in the place of what a lane had of its time, [from, to). A piece whose first point is later than its
// start continues from what was known before it. What follows the piece stays as it was; if that is nothing, it is
// unknown.
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
  if (item.length !== 2 || last?.length !== 2 || last[1] !== item[1]) list.push(item); // else it is no edge
}

// Forgets what is far from the piece that ends at a time: what is older than two minutes, or more than there is room
// for.
export function forgetFar(list, to) {
  const grows = list.at(-1)[0] === to,
    old = grows && list[0][0] < to - 1.25 * KEPT_NS ? after(list, to - KEPT_NS) - 1 : 0;
  list.splice(0, Math.max(old, after(list, to) - MOST, 0));
  if (list.length > MOST) list.splice(MOST, Infinity, [list[MOST][0], null]);
}

// Joins a piece to the time that is there without a gap, [from, to); else that restarts.
export function join(have, { from, to }) {
  const apart = from > have.to || to < have.from;
  Object.assign(have, apart ? { from, to } : { from: Math.min(have.from, from), to: Math.max(have.to, to) });
}

// From which time on something is missing of a time in view; null if nothing is.
export function missing(have, from, to) {
  if (from < have.from || from > have.to) return from;
  return to > have.to ? have.to : null;
}

// The stretches of a lane from one time to another: [from, to, value], and the edges of a bit or the least and the
// greatest value in it. Of what is not known the value is null.
export function stretches(list, from, to) {
  const found = [];
  for (let at = Math.max(after(list, from) - 1, 0); at < list.length && list[at][0] <= to; at++) {
    const [time, ...rest] = list[at],
      value = valueOf(list[at]),
      within = [Math.max(time, from), Math.min(list[at + 1]?.[0] ?? to, to)];
    found.push([...within, value, ...(rest.length === 3 ? rest.slice(0, 2) : rest.slice(1))]);
  }
  return found;
}

// The value behind a point.
export const valueOf = point => (point.length === 4 ? point[3] : point[1]);

// The least and the greatest value in lanes; a scale of at least one step.
export function range(...lists) {
  let low = Infinity, high = -Infinity;
  for (const point of lists.flat()) {
    if (point.length !== 4) continue;
    low = Math.min(low, Number(point[1]));
    high = Math.max(high, Number(point[2]));
  }
  return low < high ? [low, high] : [low === Infinity ? 0 : low, (low === Infinity ? 0 : low) + 1];
}

// Index of the first point later than a time.
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
    this.levels = new Map(); // name -> the level that was last put
    this.changed = new Set(); // names of bits that have had an edge
    this.have = { from: 0, to: 0 }; // the time of the latest pieces, without a gap
  }

  // Takes a piece; it may begin later than it was requested.
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

  // Takes over the names of other lanes, and which of them have changed: of a recording nothing else comes.
  learn(other) {
    for (const name of other.bits.keys()) if (!this.bits.has(name)) this.bits.set(name, []);
    for (const name of other.changed) this.changed.add(name);
  }

  get names() {
    const place = name => { const found = this.order.indexOf(name); return found < 0 ? this.order.length : found; };
    return [...this.bits.keys()].sort((one, other) => place(one) - place(other));
  }

  // The points of a position from one time to another, and one on either side.
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
