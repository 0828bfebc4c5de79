// What the timing strip knows: edges of bits, envelopes of positions, the latest two minutes of them.

const KEPT_NS = 120e9;
const SETTLED_NS = 50e6; // edges before that are of the power-up and of no interest to begin with
const MOST = 60000; // entries of a lane

export class Lanes {
  constructor(order) {
    this.order = order; // names in the order of the lanes
    this.bits = new Map(); // name -> [[t, value], ...]
    this.curves = new Map(); // name -> [[t, least, most, last], ...]
    this.changed = new Set(); // names of bits that have had an edge
  }

  take({ strip, env }) {
    for (const [name, items] of Object.entries(strip ?? {})) {
      add(this.bits, name, items);
      const last = this.bits.get(name);
      if (last?.length > 1 && last.at(-1)[0] > SETTLED_NS) this.changed.add(name);
    }
    for (const [name, items] of Object.entries(env ?? {})) add(this.curves, name, items);
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

  // The bit's stretches from one time to another: [from, to, value], the first one from before.
  stretches(name, from, to) {
    const edges = this.bits.get(name) ?? [], found = [];
    let at = Math.max(after(edges, from) - 1, 0);
    for (; at < edges.length && edges[at][0] <= to; at++) {
      found.push([Math.max(edges[at][0], from), Math.min(edges[at + 1]?.[0] ?? to, to), edges[at][1]]);
    }
    return found;
  }

  // The least and the greatest value of a position that are known here or in other lanes: a scale that rests.
  range(name, other) {
    let low = Infinity, high = -Infinity;
    for (const lanes of new Set([this, other])) {
      for (const point of lanes.curves.get(name) ?? []) {
        low = Math.min(low, point[1]);
        high = Math.max(high, point[2]);
      }
    }
    return low < high ? [low, high] : [low === Infinity ? 0 : low, (low === Infinity ? 0 : low) + 1];
  }

  points(name, from, to) {
    const all = this.curves.get(name) ?? [];
    return all.slice(Math.max(after(all, from) - 1, 0), after(all, to) + 1);
  }
}

function add(lanes, name, items) {
  if (!items.length) return;
  let list = lanes.get(name);
  if (!list) lanes.set(name, list = []);
  if (list.length && items[0][0] < list.at(-1)[0]) list.length = after(list, items[0][0] - 1); // repeated, or changed
  for (const item of items) {
    if (item.length === 2 && list.length && list.at(-1)[1] === item[1]) continue; // no edge
    list.push(item);
  }
  const old = list.at(-1)[0] - KEPT_NS;
  if (list.length > MOST || list[0][0] < old - KEPT_NS / 4) list.splice(0, Math.max(after(list, old) - 1, list.length - MOST));
}

// Index of the first entry later than a time.
export function after(list, time) {
  let low = 0, high = list.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (list[middle][0] > time) high = middle; else low = middle + 1;
  }
  return low;
}
