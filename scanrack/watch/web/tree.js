// A structure or an array as a tree that opens: its members by name, each with its value; a click selects a member.

import { el, setFlag, setText, textButton } from "./dom.js";
import { shown } from "./format.js";
import { select } from "./selection.js";
import { place } from "./values.js";

const MOST = 256; // members shown of one value

const isGroup = value => typeof value === "object" && value !== null;
const countOf = value => (Array.isArray(value) ? `${value.length} elements` : `${Object.keys(value).length} members`);

// The text of a value beside its tree: how many members it has, or else what `say` makes of it.
export const brief = say => value => (isGroup(value) ? countOf(value) : say(value));

// The tree of a tag; hidden while its value is a single one. `say` makes the text of a member.
export function treeOf(tag, say = shown, open = false) {
  const root = branch(tag, "members", say);
  root.node.open = open;
  place(root.node, tag, value => { root.fill(value); return null; });
  return root.node;
}

// A node that opens, filled while it is open.
function branch(name, title, say, isRow = false) {
  const node = el("details", { class: "tree", hidden: true, toggle: () => fill(latest) }, el("summary", {}, title));
  const rows = new Map();
  let latest = null;
  function fill(value) {
    latest = value;
    setFlag(node, "hidden", !isGroup(value));
    if (!isGroup(value) || !node.open) return;
    for (const [key, item] of Object.entries(value).slice(0, MOST)) {
      if (!rows.has(key))
        node.append(
          rows.set(key, rowOf(memberOf(name, key, value, isRow), key, say, Array.isArray(value))).get(key).node
        );
      rows.get(key).show(item);
    }
  }
  return { node, fill };
}

// Axis.State of Axis, Words[3] of Words; Grid[1,2] of a row of Grid, `Grid[1]`.
function memberOf(name, key, value, isRow) {
  if (!Array.isArray(value)) return `${name}.${key}`;
  return isRow ? `${name.slice(0, -1)},${key}]` : `${name}[${key}]`;
}

function rowOf(name, key, say, inArray) {
  const value = el("output", { class: "figure" }), inner = branch(name, "members", say, inArray);
  const line = el(
    "div",
    { class: "part" },
    textButton(inArray ? `[${key}]` : key, () => select({ tag: name }), name),
    value
  );
  return { node: el("div", {}, line, inner.node), show(item) {
    setText(value, brief(say)(item));
    inner.fill(item);
  } };
}
