// A structure or an array as a tree of members, each with its value; a click on a member selects it.

import { el, setFlag, setText, textButton } from "./dom.js";
import { shown } from "./format.js";
import { select } from "./selection.js";
import { bindValue } from "./values.js";

const MOST = 256; // members shown of one value

const isGroup = value => typeof value === "object" && value !== null;
const countOf = value => (Array.isArray(value) ? `${value.length} elements` : `${Object.keys(value).length} members`);

// Text of a value for a place beside its tree: the number of members of a structure; else the text of the value.
export const brief = toText => value => (isGroup(value) ? countOf(value) : toText(value));

// The tree of a tag, hidden while its value has no members. `toText` makes the text of a member.
export function treeOf(tag, toText = shown, open = false) {
  const root = branch(tag, "members", toText);
  root.node.open = open;
  bindValue(root.node, tag, value => { root.fill(value); return null; });
  return root.node;
}

// A node of the tree; it is filled only while it is open.
function branch(name, title, toText, isRow = false) {
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
          rows.set(key, rowOf(memberOf(name, key, value, isRow), key, toText, Array.isArray(value))).get(key).node
        );
      rows.get(key).show(item);
    }
  }
  return { node, fill };
}

// Names of members: Axis.State of Axis, Words[3] of Words, Grid[1,2] of the row Grid[1].
function memberOf(name, key, value, isRow) {
  if (!Array.isArray(value)) return `${name}.${key}`;
  return isRow ? `${name.slice(0, -1)},${key}]` : `${name}[${key}]`;
}

function rowOf(name, key, toText, inArray) {
  const value = el("output", { class: "figure" }), inner = branch(name, "members", toText, inArray);
  const line = el(
    "div",
    { class: "part" },
    textButton(inArray ? `[${key}]` : key, () => select({ tag: name }), name),
    value
  );
  return { node: el("div", {}, line, inner.node), show(item) {
    setText(value, brief(toText)(item));
    inner.fill(item);
  } };
}
