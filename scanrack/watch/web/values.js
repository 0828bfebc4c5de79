// Nodes that show a value by name: of tags, words and bits. A change of a value reaches all nodes bound to its name.

import { setAttribute, setText } from "./dom.js";
import { plain, shown } from "./format.js";
import { onHello, onPaint, run } from "./state.js";

const bindings = new Map(); // name -> [{ node, toText }]
const known = new Map(); // name -> value
const addresses = new Map(); // name of a word or bit of an image -> its address

onHello(() => { // before the parts of the page, which bind their nodes again
  bindings.clear();
  known.clear();
  addresses.clear();
});

// Shows the value of a name in a node from now on. toText(value) makes the text; null: the node has none.
export function bindValue(node, name, toText = shown) {
  if (!bindings.has(name)) bindings.set(name, []);
  bindings.get(name).push({ node, toText });
  node.dataset.name = name;
  if (known.has(name)) update(node, toText, known.get(name));
  markForced(node, toText, name, run.forced);
}

// Shows the level of a bit, 1 or 0, in a part of its node.
export const bindLevel = (node, part, name) =>
  bindValue(node, name, value => { part.textContent = value ? "1" : "0"; return null; });

export function unbindIn(root) {
  for (const [name, list] of bindings) {
    const left = list.filter(({ node }) => !root.contains(node));
    left.length ? bindings.set(name, left) : bindings.delete(name);
  }
}

function update(node, toText, value) {
  const raw = plain(value);
  if (node.dataset.value === raw) return;
  node.dataset.value = raw;
  write(node, toText, value);
}

// A forced value in a drawing gets an F here; elsewhere the style sheet adds it.
function write(node, toText, value) {
  const text = toText(value);
  if (text !== null) setText(node, node instanceof SVGElement && "forced" in node.dataset ? `${text} F` : text);
}

function markForced(node, toText, name, forced) {
  const is = isForced(name, forced);
  if (is === "forced" in node.dataset) return;
  setAttribute(node, "data-forced", is ? "" : null);
  if (known.has(name)) write(node, toText, known.get(name));
}

export function setValue(name, value) {
  known.set(name, value);
  for (const { node, toText } of bindings.get(name) ?? []) update(node, toText, value);
}

export const valueOf = name => known.get(name);

// The address of a word or bit; other names are returned unchanged.
export const addressOf = name => addresses.get(name) ?? name;

// Whether a tag, word or bit is forced; forces of words and bits are listed by address.
export const isForced = (name, forced = run.forced) => name in forced || addressOf(name) in forced;

// Whether two names mean the same tag: an alias equals its address.
export const isSame = (one, other) => addressOf(one).toUpperCase() === addressOf(other).toUpperCase();

// Remembers the addresses of names.
export function learn(found = {}) {
  for (const [name, address] of Object.entries(found)) addresses.set(name, address);
  for (const name of Object.keys(found)) {
    for (const { node, toText } of bindings.get(name) ?? []) markForced(node, toText, name, run.forced);
  }
}

// Calls visit(name, address) with each name that is shown, and its address.
export const eachShown = visit => { for (const name of bindings.keys()) visit(name, addressOf(name)); };

// Writes the value of a name again in some of its nodes, after their radix has changed.
export function rewrite(name, ...nodes) {
  for (const { node, toText } of bindings.get(name) ?? [])
    if (nodes.includes(node) && known.has(name)) write(node, toText, known.get(name));
}

onPaint(({ tags, forced }) => {
  for (const [name, value] of Object.entries(tags ?? {})) setValue(name, value);
  if (!forced) return;
  for (const [name, list] of bindings) {
    for (const { node, toText } of list) markForced(node, toText, name, forced);
  }
});
