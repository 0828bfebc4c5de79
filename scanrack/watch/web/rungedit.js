// Edits rungs where they are drawn: a caret between two elements, where is typed, and the text of the rung below it.
// `draftrows` has the rungs themselves.

import { completing } from "./completing.js";
import { el, setFlag, textField } from "./dom.js";
import { change, draft, isLocked, keyOf, look, onDraft, redo, setColumns, undo } from "./draft.js";
import { checkedOf, drawDrafts, lastKey, lay, neighborOf, rowAt, runs, textOf, textsAt } from "./draftrows.js";
import { between, pieceOf, read, spliced, taken, typedOf } from "./rungtext.js";
import { offered, offeredInText, tagsOf } from "./rungwords.js";
import { selected } from "./selection.js";

const EMPTY = ";";
const FIRST = -1; // before the first rung

let sheet = null, routine = "", program = "", begins = null;
let on = false, clipboard = "", requested = false; // whether the caret gets the focus once it can be drawn
// { key, index, place, anchor }: the rung that is edited, and the places of the caret and of its other end
let at = null;

const mark = el("span", { class: "span", hidden: true });
const input = textField("Instruction, such as XIC Start", {
  class: "typed",
  autocapitalize: "off",
  keydown: keyed,
  input: () => {
    widen();
    offers.show();
  },
});
const caret = el("span", { class: "caret" }, input);
const text = textField("Text of the rung", {
  class: "rungtext",
  autocapitalize: "off",
  keydown: textKeyed,
  change: () => replaceText(),
  input: () => words.show(),
});
const offers = completing(input, typed => offered(typed, routine), widen);
const words = completing(text, typed => offeredInText(typed, routine));
const below = el("div", { class: "below" }, offers.list, text, words.list);

export function edit(now) {
  on = now;
  if (!now) at = null;
  redraw();
}

// Puts the caret at the start of a rung of the routine that is shown.
export function begin(rung) {
  if (!sheet) { begins = () => begin(rung); return; } // it is being drawn
  begins = null;
  const first = rung && sheet.querySelector(`[data-at="${CSS.escape(rung)}"]`);
  const row = first ?? sheet.querySelector(".row[data-key]");
  if (row) go(row.dataset.key, Number(row.dataset.index), 0);
  else redraw();
}

// Called when a routine has been drawn.
export function decorate(node, name, { rungs, base }, columns) {
  if (sheet !== node) {
    node.addEventListener("click", clicked, true);
    node.addEventListener("keydown", entered, true);
  }
  const said = program === base ? null : textOf(at);
  [sheet, routine, program] = [node, name, base];
  lay(node, name, rungs);
  setColumns(columns);
  if (on && at && at.key.split("\n")[0] !== name) at = null;
  if (at && said !== null && textOf(at) !== said) leave(); // another rung has its number now
  requested ||= on && Boolean(at) && document.activeElement === document.body; // the caret had it in the drawing before
  if (isOpen()) look(at?.key, textOf(at) ?? EMPTY);
  redraw();
  begins?.();
}

// Whether the rungs that are shown can be edited: not those of an earlier program, and none in test.
const isOpen = () => on && !isLocked() && program === draft.base;

onDraft(redraw);

function redraw() {
  if (!sheet) return;
  if (draft.moved) leave();
  const focused = [input, text].find(each => each === document.activeElement);
  setFlag(sheet, "data-editing", on);
  drawDrafts(isOpen());
  setCaret(focused);
}

// --- the caret

// Keys that follow would edit another rung than the one that was looked at.
function leave() {
  [at, draft.moved, input.value] = [null, false, ""];
}

function go(key, index, where, anchor = where) {
  const far = !at || at.key !== key || at.index !== index;
  requested = true;
  at = { key, index, place: where, anchor };
  if (far && !checkedOf(at)) look(key, textOf(at) ?? EMPTY);
  setCaret(input);
}

// Draws the caret at its place; the text of its rung stands below the picture.
function setCaret(focused) {
  const row = at && isOpen() ? rowAt(at) : null,
    said = textOf(at),
    svg = row?.querySelector("svg.rung"),
    gaps = row && checkedOf(at)?.gaps;
  if (!row || said === undefined) { caret.remove(); below.remove(); mark.remove(); return; }
  const body = row.querySelector(".body");
  body.append(below);
  if (document.activeElement !== text) text.value = said;
  const column = checkedOf(at)?.mistakes.find(each => each.column)?.column;
  text.setAttribute("aria-invalid", String(Boolean(column)));
  const isOld = !gaps || checkedOf(at).text !== said; // the answer for the rung is on its way; typing goes on
  if (svg && isOld) {
    body.append(caret);
  } else if (svg) {
    at.place = Math.min(at.place, gaps.length - 1);
    at.anchor = Math.min(at.anchor, gaps.length - 1);
    const point = pointOf(svg, body), [x, y] = point(gaps[at.place]), [from] = point(gaps[at.anchor]);
    caret.style.left = `${x}px`;
    caret.style.top = `${y}px`;
    setFlag(mark, "hidden", at.anchor === at.place);
    Object.assign(mark.style, { left: `${Math.min(x, from)}px`, width: `${Math.abs(x - from)}px`, top: `${y - 16}px` });
    body.append(mark, caret);
  } else {
    caret.remove();
    mark.remove();
  }
  focused ??= requested ? input : null;
  requested = !svg && (requested || (focused === input && !checkedOf(at))); // an input that is taken out has lost it
  if (focused === text || (focused && !svg && checkedOf(at))) {
    text.focus({ preventScroll: true });
    if (column && focused !== text) text.setSelectionRange(column - 1, column);
  } else if (focused) {
    input.focus({ preventScroll: true });
    row.scrollIntoView({ block: "nearest" });
  }
}

// Places of the drawing in the box that holds it.
function pointOf(svg, body) {
  const box = svg.getBoundingClientRect(),
    outer = body.getBoundingClientRect(),
    { width, y } = svg.viewBox.baseVal,
    scale = box.width / width;
  return ([left, top]) => [box.left - outer.left + left * scale, box.top - outer.top + (top - y) * scale];
}

function clicked(event) {
  const row = isOpen() && event.target.closest(".row[data-key]"), svg = row && event.target.closest("svg.rung");
  if (!svg) return;
  event.stopPropagation();
  const { key, index } = row.dataset,
    number = Number(event.target.closest(".instruction")?.dataset.element.split(".").at(-1) ?? NaN);
  if (row.dataset.edited && !row.classList.contains("draft")) return go(key, 0, 0); // the one below it is edited
  if (!Number.isNaN(number)) return choose(key, Number(index), number);
  go(key, Number(index), 0);
  nearest(svg, row, event);
}

// The place nearest to a point, once the places of the rung are known.
async function nearest(svg, row, { clientX, clientY }) {
  if (!checkedOf(at)) await look(at.key, textOf(at));
  const gaps = at && checkedOf(at)?.gaps,
    box = row.querySelector(".body").getBoundingClientRect(),
    point = pointOf(svg, row.querySelector(".body"));
  if (!gaps) return;
  const far = gaps.map(point).map(([x, y]) => Math.hypot(x + box.left - clientX, 3 * (y + box.top - clientY)));
  go(at.key, at.index, far.indexOf(Math.min(...far)));
}

function choose(key, index, number) {
  const element = read(textOf({ key, index }) ?? "")?.elements.find(each => each.number === number);
  if (element) go(key, index, element.behind, element.before);
}

// Enter on an instruction of the picture edits it.
function entered(event) {
  const group = isOpen() && event.target.closest(".instruction"), row = group && group.closest(".row[data-key]");
  if (!row || !["Enter", "F2"].includes(event.key)) return;
  event.preventDefault();
  event.stopPropagation();
  choose(row.dataset.key, Number(row.dataset.index), Number(group.dataset.element.split(".").at(-1)));
}

// --- changes

// Puts texts in place of the rung that is edited, and the caret into one of them.
function put(make, where = at) {
  change(rungs => {
    const texts = textsAt(where.key), said = runs(where.key);
    make(texts);
    if (texts.length === 1 ? texts[0] === said : !texts.length && said === undefined) rungs.delete(where.key);
    else rungs.set(where.key, texts);
  });
}

const write = said => put(texts => { texts[at.index] = said; });

function splice(range, piece, inward = 0) {
  const now = spliced(textOf(at), range.from, range.to, piece);
  const place = inward || now.place;
  Object.assign(at, { place, anchor: place });
  write(now.text);
}

const selection = () => between(textOf(at), at.place, at.anchor);

function insert(typed) {
  const piece = pieceOf(typed, draft.words.instructions, tagsOf(routine)), range = at.retyped ? selection() : after();
  at.retyped = false;
  input.value = "";
  widen();
  offers.close();
  splice(range, piece);
}

const placeAt = number => { const { at: from } = read(textOf(at)).places[number]; return { from, to: from }; };
const here = () => placeAt(at.place);
const after = () => placeAt(Math.max(at.place, at.anchor)); // of what is chosen, as in Studio

function branch() {
  const range = selection() ?? here(),
    said = textOf(at).slice(range.from, range.to),
    first = Math.min(at.place, at.anchor);
  const inside = read(said)?.places.length ?? 1; // the caret goes into the new leg
  splice(range, `[${said},]`, first + (said ? inside + 1 : 1));
}

function leg() {
  const { places, legs } = read(textOf(at)), { branch: inside, to } = legs[places[at.place].leg];
  if (!inside) return branch();
  splice({ from: to, to }, ",", places.findLastIndex(each => each.leg === places[at.place].leg) + 1);
}

function remove(forward) {
  const range = at.place === at.anchor ? taken(textOf(at), at.place, forward) : selection();
  if (!range) return forward ? null : step(-1);
  splice(range, "");
}

export function newRung() {
  if (!isOpen()) return;
  const last = lastKey() ?? keyOf(routine, FIRST), where = at ?? { key: last, index: 0 };
  const index = where.key === keyOf(routine, FIRST) && !draft.rungs.has(where.key) ? 0 : where.index + 1;
  put(texts => { texts.splice(index, 0, EMPTY); }, where);
  go(where.key, index, 0);
}

export function deleteRung() {
  if (!at) return;
  const where = at, next = neighborOf(at, 1) ?? neighborOf(at, -1);
  at = null;
  put(texts => { texts.splice(where.index, 1); }, where);
  if (next && next.key !== where.key) go(next.key, next.index, 0);
}

function replaceText() {
  if (!at || text.value === textOf(at)) return;
  words.close();
  write(text.value.trim() || EMPTY);
}

// --- keys

const CONTROL = {
  z: event => (event.shiftKey ? redo() : undo()),
  y: redo,
  c: () => copy(),
  x: () => {
    if (copy()) remove(true);
  },
  v: () => paste(),
  Delete: deleteRung,
  Enter: newRung,
  b: branch,
};
const PLAIN = {
  ArrowLeft: event => step(-1, event.shiftKey),
  ArrowRight: event => step(1, event.shiftKey),
  ArrowUp: () => toNeighbor(-1),
  ArrowDown: () => toNeighbor(1),
  Home: () => go(at.key, at.index, 0),
  End: () => go(at.key, at.index, read(textOf(at)).places.length - 1),
  Backspace: () => remove(false),
  Delete: () => remove(true),
  Enter: () => (at.place === at.anchor ? newRung() : retype()),
  F2: retype,
  "[": branch,
  ",": leg,
  Escape: () => {
    at = null;
    setCaret(null);
  },
};

function keyed(event) {
  if (!["Tab", "F6"].includes(event.key)) event.stopPropagation();
  if (offers.keyed(event)) return;
  const typed = input.value.trim(),
    key = event.key.length === 1 && (event.ctrlKey || event.metaKey) ? event.key.toLowerCase() : event.key;
  if (typed && event.key === "Escape") { input.value = ""; at.retyped = false; widen(); offers.close(); return; }
  if (typed && event.key !== "Enter") return;
  const act =
    event.ctrlKey || event.metaKey
      ? CONTROL[key]
      : event.altKey
        ? null
        : typed
          ? () => insert(input.value)
          : PLAIN[key];
  if (!act || event.isComposing) return;
  event.preventDefault();
  // only its text can be mended
  if (!read(textOf(at) ?? "") && !["z", "y", "ArrowUp", "ArrowDown", "Escape"].includes(key)) return text.focus();
  act(event);
}

// Letters that are typed while no control has the focus go to the caret: they are no keys of the page then.
export function takesTyped({ key, target, ctrlKey, metaKey, altKey }) {
  const plain = /^[a-z]$/i.test(key) && !ctrlKey && !metaKey && !altKey;
  if (!plain || !isOpen() || !target.matches("body, #program")) return false;
  at ? go(at.key, at.index, at.place, at.anchor) : begin(selected.rung);
  if (!input.isConnected) return true;
  input.value += key;
  widen();
  offers.show();
  return true;
}

function textKeyed(event) {
  event.stopPropagation();
  if (words.keyed(event)) return;
  if (event.key === "Enter") { replaceText(); input.isConnected && input.focus(); }
  if (event.key === "Escape") { text.value = textOf(at) ?? ""; input.isConnected && input.focus(); }
}

function step(by, wide = false) {
  const { places } = read(textOf(at)), leg = places[at.place].leg;
  let next = at.place + by;
  while (wide && places[next] && places[next].leg !== leg) next += by; // over a branch
  if (places[next]) go(at.key, at.index, next, wide ? at.anchor : next);
}

// Up and down go to the next leg, then to the next rung.
function toNeighbor(by) {
  const gaps = checkedOf(at)?.gaps ?? [], [x, y] = gaps[at.place] ?? [0, 0];
  const beyond = gaps
    .map(([left, top], number) => ({ number, far: (top - y) * by, off: Math.abs(left - x) }))
    .filter(each => each.far > 1);
  if (beyond.length)
    return go(at.key, at.index, beyond.sort((one, other) => one.far - other.far || one.off - other.off)[0].number);
  const next = neighborOf(at, by);
  if (next) go(next.key, next.index, 0);
}

// Types the chosen instruction again.
function retype() {
  const range = selection();
  if (!range || range.from === range.to) return;
  at.retyped = true;
  input.value = typedOf(textOf(at).slice(range.from, range.to));
  widen();
  input.select();
}

function copy() {
  const range = selection();
  if (!range || range.from === range.to) return false;
  clipboard = textOf(at).slice(range.from, range.to);
  navigator.clipboard?.writeText(clipboard).catch(() => {}); // the page's own one is enough
  return true;
}

const paste = () => { if (clipboard) splice(selection() ?? here(), clipboard); };

function widen() {
  const body = caret.parentElement, most = (body?.clientWidth ?? 0) - parseFloat(caret.style.left);
  input.style.width = input.value ? `calc(${input.value.length + 1}ch + 14px)` : "";
  setFlag(caret, "data-typing", input.value !== "");
  input.style.marginLeft = body ? `${Math.min(0, most - input.offsetWidth)}px` : "";
}
