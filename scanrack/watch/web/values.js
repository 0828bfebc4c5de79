// Places that show a value by name: tags, words and bits. One change reaches all places of a name.

import { setAttribute, setText } from "./dom.js";
import { plain, shown } from "./format.js";
import { onHello, onPaint, run } from "./state.js";

const places = new Map(); // name -> [{ node, say }]
const known = new Map(); // name -> value
const addresses = new Map(); // name of a word or bit of an image -> its address

onHello(() => { // before the parts that have places: they name them again
  places.clear();
  known.clear();
  addresses.clear();
});

// Shows the value of a name in a node from now on; say(value) makes its text.
export function place(node, name, say = shown) {
  if (!places.has(name)) places.set(name, []);
  places.get(name).push({ node, say });
  node.dataset.name = name;
  if (known.has(name)) put(node, say, known.get(name));
  mark(node, say, name, run.forced);
}

// Shows the level of a bit in a part of its node: 1 or 0.
export const placeLevel = (node, part, name) =>
  place(node, name, value => { part.textContent = value ? "1" : "0"; return null; });

export function unplace(root) {
  for (const [name, list] of places) {
    const left = list.filter(({ node }) => !root.contains(node));
    left.length ? places.set(name, left) : places.delete(name);
  }
}

function put(node, say, value) {
  const raw = plain(value);
  if (node.dataset.value === raw) return;
  node.dataset.value = raw;
  write(node, say, value);
}

// A forced value in a picture carries an F; elsewhere the style sheet adds it.
function write(node, say, value) {
  const text = say(value);
  if (text !== null) setText(node, node instanceof SVGElement && "forced" in node.dataset ? `${text} F` : text);
}

function mark(node, say, name, forced) {
  const is = isForced(name, forced);
  if (is === "forced" in node.dataset) return;
  setAttribute(node, "data-forced", is ? "" : null);
  if (known.has(name)) write(node, say, known.get(name));
}

export function give(name, value) {
  known.set(name, value);
  for (const { node, say } of places.get(name) ?? []) put(node, say, value);
}

export const valueOf = name => known.get(name);

// The address of a name of a word or bit, else the name.
export const addressOf = name => addresses.get(name) ?? name;

// Names as which a word or bit is forced: a force has its address.
export const isForced = (name, forced = run.forced) => name in forced || addressOf(name) in forced;

// Whether two names mean the same: an alias is its address.
export const isSame = (one, other) => addressOf(one).toUpperCase() === addressOf(other).toUpperCase();

// Remembers the addresses of names.
export function learn(found = {}) {
  for (const [name, address] of Object.entries(found)) addresses.set(name, address);
  for (const name of Object.keys(found)) {
    for (const { node, say } of places.get(name) ?? []) mark(node, say, name, run.forced);
  }
}

// Calls visit(name, address) with each name that is shown, and its address.
export const eachShown = visit => { for (const name of places.keys()) visit(name, addressOf(name)); };

// Writes the value of a name in some nodes again: their radix has changed.
export function again(name, ...nodes) {
  for (const { node, say } of places.get(name) ?? [])
    if (nodes.includes(node) && known.has(name)) write(node, say, known.get(name));
}

onPaint(({ tags, forced }) => {
  for (const [name, value] of Object.entries(tags ?? {})) give(name, value);
  if (!forced) return;
  for (const [name, list] of places) {
    for (const { node, say } of list) mark(node, say, name, forced);
  }
});
