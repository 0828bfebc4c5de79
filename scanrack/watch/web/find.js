// The search for text in rungs, comments and tags. A hit opens its rung or its tag.

import { el, textField } from "./dom.js";
import { order } from "./orders.js";
import { select } from "./selection.js";
import { showRung } from "./program.js";

const hits = el("ul", { class: "hits", role: "listbox", "aria-label": "Hits", hidden: true });
export const field = textField("Find", {
  type: "search", placeholder: "Find  /",
  input: () => queried(), focus: () => { hits.hidden = !hits.children.length; },
});
const box = el("div", { class: "find", focusout: left, keydown: keyed }, field, hits);

let asking = 0, first = null; // number of the latest question; the best hit

export const findBox = () => box;

async function queried() {
  const text = field.value.trim(), mine = ++asking;
  const answer = text ? await order("find", { text }) : { hits: [] };
  if (mine === asking && answer) show(answer.hits ?? []);
}

function show(found) {
  first = found[0] ?? null;
  hits.replaceChildren(...found.slice(0, 40).map(hit =>
    el("li", {}, el("button", { type: "button", click: () => open(hit) },
      el("b", {}, hit.rung ?? hit.tag ?? ""), el("span", {}, hit.says ?? hit.text)))));
  if (!found.length && field.value.trim()) hits.append(el("li", { class: "none" }, "no hits"));
  hits.hidden = !hits.children.length;
}

function open(hit) {
  hits.hidden = true;
  if (hit.tag) select({ tag: hit.tag });
  if (hit.rung) showRung(hit.rung);
}

// Arrows move through the hits. Enter opens the hit with the focus, or the first one.
function keyed(event) {
  const all = [field, ...hits.querySelectorAll("button")],
    move = { ArrowDown: 1, ArrowUp: -1 }[event.key],
    isTyping = event.target === field;
  if (event.key === "Escape") { hits.hidden = true; event.target.blur(); }
  else if (move) all.at((all.indexOf(event.target) + move) % all.length).focus();
  else if (event.key === "Enter" && isTyping) enter();
  else return;
  event.preventDefault();
}

// Opens the first hit; searches again, since the latest answer may still be missing.
async function enter() {
  await queried();
  if (first) { open(first); field.blur(); }
}

function left(event) {
  if (!box.contains(event.relatedTarget)) hits.hidden = true;
}
