// Edits rungs where they are drawn: with a caret between two elements to type at, or as text below the rung.
// draftrows.js draws the rungs.

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
let on = false, clipboard = "", wantsFocus = false; // whether the caret gets the focus once it can be drawn
// { key, index, place, anchor }: the edited rung, the place of the caret, and the other end of the selection
let at = null;

const mark = el("span", { class: "span", hidden: true });
const input = textField("Instruction, such as XIC Start", {
  class: "typed",
  autocapitalize: "off",
  keydown: onKey,
  input: () => {
    fitInput();
    offers.show();
  },
});
const caret = el("span", { class: "caret" }, input);
const text = textField("Text of the rung", {
  class: "rungtext",
  autocapitalize: "off",
  keydown: onTextKey,
  change: () => replaceText(),
  input: () => textOffers.show(),
});
const offers = completing(input, typed => offered(typed, routine), fitInput);
const textOffers = completing(text, typed => offeredInText(typed, routine));
const below = el("div", { class: "below" }, offers.list, text, textOffers.list);

export function edit(now) {
  on = now;
  if (!now) at = null;
  redraw();
}

// Puts the caret at the start of a rung of the routine that is shown.
export function begin(rung) {
  if (!sheet) { begins = () => begin(rung); return; } // once the routine is drawn
  begins = null;
  const first = rung && sheet.querySelector(`[data-at="${CSS.escape(rung)}"]`);
  const row = first ?? sheet.querySelector(".row[data-key]");
  if (row) moveCaret(row.dataset.key, Number(row.dataset.index), 0);
  else redraw();
}

// Called when a routine has been drawn.
export function decorate(node, name, { rungs, base }, columns) {
  if (sheet !== node) {
    node.addEventListener("click", onClick, true);
    node.addEventListener("keydown", onEnter, true);
  }
  const rungText = program === base ? null : textOf(at);
  [sheet, routine, program] = [node, name, base];
  lay(node, name, rungs);
  setColumns(columns);
  if (on && at && at.key.split("\n")[0] !== name) at = null;
  if (at && rungText !== null && textOf(at) !== rungText) dropCaret(); // the number is another rung's now
  // the caret of the previous drawing had the focus
  wantsFocus ||= on && Boolean(at) && document.activeElement === document.body;
  if (isOpen()) look(at?.key, textOf(at) ?? EMPTY);
  redraw();
  begins?.();
}

// Whether the rungs that are shown can be edited: not those of an earlier program, and none during a test.
const isOpen = () => on && !isLocked() && program === draft.base;

onDraft(redraw);

function redraw() {
  if (!sheet) return;
  if (draft.moved) dropCaret();
  const focused = [input, text].find(each => each === document.activeElement);
  setFlag(sheet, "data-editing", on);
  drawDrafts(isOpen());
  setCaret(focused);
}

// --- the caret

// Further keys would edit a different rung from the one that the user sees.
function dropCaret() {
  [at, draft.moved, input.value] = [null, false, ""];
}

function moveCaret(key, index, where, anchor = where) {
  const isOther = !at || at.key !== key || at.index !== index;
  wantsFocus = true;
  at = { key, index, place: where, anchor };
  if (isOther && !checkedOf(at)) look(key, textOf(at) ?? EMPTY);
  setCaret(input);
}

// Draws the caret at its place, and the text of its rung below the drawing.
function setCaret(focused) {
  const row = at && isOpen() ? rowAt(at) : null,
    rungText = textOf(at),
    svg = row?.querySelector("svg.rung"),
    gaps = row && checkedOf(at)?.gaps;
  if (!row || rungText === undefined) { caret.remove(); below.remove(); mark.remove(); return; }
  const body = row.querySelector(".body");
  body.append(below);
  if (document.activeElement !== text) text.value = rungText;
  const column = checkedOf(at)?.mistakes.find(each => each.column)?.column;
  text.setAttribute("aria-invalid", String(Boolean(column)));
  const isOld = !gaps || checkedOf(at).text !== rungText; // no answer for this text yet; typing continues
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
  focused ??= wantsFocus ? input : null;
  wantsFocus = !svg && (wantsFocus || (focused === input && !checkedOf(at))); // a removed input has lost the focus
  if (focused === text || (focused && !svg && checkedOf(at))) {
    text.focus({ preventScroll: true });
    if (column && focused !== text) text.setSelectionRange(column - 1, column);
  } else if (focused) {
    input.focus({ preventScroll: true });
    row.scrollIntoView({ block: "nearest" });
  }
}

// Returns a function from points of the drawing to points of the box around it.
function pointOf(svg, body) {
  const box = svg.getBoundingClientRect(),
    outer = body.getBoundingClientRect(),
    { width, y } = svg.viewBox.baseVal,
    scale = box.width / width;
  return ([left, top]) => [box.left - outer.left + left * scale, box.top - outer.top + (top - y) * scale];
}

function onClick(event) {
  const row = isOpen() && event.target.closest(".row[data-key]"), svg = row && event.target.closest("svg.rung");
  if (!svg) return;
  event.stopPropagation();
  const { key, index } = row.dataset,
    number = Number(event.target.closest(".instruction")?.dataset.element.split(".").at(-1) ?? NaN);
  // the changed rung below it is edited
  if (row.dataset.edited && !row.classList.contains("draft")) return moveCaret(key, 0, 0);
  if (!Number.isNaN(number)) return choose(key, Number(index), number);
  moveCaret(key, Number(index), 0);
  moveToNearest(svg, row, event);
}

// Moves the caret to the place nearest to a point, once the places of the rung are known.
async function moveToNearest(svg, row, { clientX, clientY }) {
  if (!checkedOf(at)) await look(at.key, textOf(at));
  const gaps = at && checkedOf(at)?.gaps,
    box = row.querySelector(".body").getBoundingClientRect(),
    point = pointOf(svg, row.querySelector(".body"));
  if (!gaps) return;
  const distances = gaps.map(point).map(([x, y]) => Math.hypot(x + box.left - clientX, 3 * (y + box.top - clientY)));
  moveCaret(at.key, at.index, distances.indexOf(Math.min(...distances)));
}

function choose(key, index, number) {
  const element = read(textOf({ key, index }) ?? "")?.elements.find(each => each.number === number);
  if (element) moveCaret(key, index, element.behind, element.before);
}

// Enter on an instruction of the drawing edits it.
function onEnter(event) {
  const group = isOpen() && event.target.closest(".instruction"), row = group && group.closest(".row[data-key]");
  if (!row || !["Enter", "F2"].includes(event.key)) return;
  event.preventDefault();
  event.stopPropagation();
  choose(row.dataset.key, Number(row.dataset.index), Number(group.dataset.element.split(".").at(-1)));
}

// --- changes

// Changes the texts that replace a rung: make(texts) changes their list.
function changeTexts(make, where = at) {
  change(rungs => {
    const texts = textsAt(where.key), rungText = runs(where.key);
    make(texts);
    if (texts.length === 1 ? texts[0] === rungText : !texts.length && rungText === undefined) rungs.delete(where.key);
    else rungs.set(where.key, texts);
  });
}

const setRungText = rungText => changeTexts(texts => { texts[at.index] = rungText; });

function replace(range, piece, inward = 0) {
  const now = spliced(textOf(at), range.from, range.to, piece);
  const place = inward || now.place;
  Object.assign(at, { place, anchor: place });
  setRungText(now.text);
}

const selection = () => between(textOf(at), at.place, at.anchor);

function insert(typed) {
  const piece = pieceOf(typed, draft.words.instructions, tagsOf(routine)),
    range = at.retyped ? selection() : behindCaret();
  at.retyped = false;
  input.value = "";
  fitInput();
  offers.close();
  replace(range, piece);
}

const placeAt = number => { const { at: from } = read(textOf(at)).places[number]; return { from, to: from }; };
const atCaret = () => placeAt(at.place);
const behindCaret = () => placeAt(Math.max(at.place, at.anchor)); // after the selection, as in Studio 5000

function branch() {
  const range = selection() ?? atCaret(),
    rungText = textOf(at).slice(range.from, range.to),
    first = Math.min(at.place, at.anchor);
  const inside = read(rungText)?.places.length ?? 1; // the caret goes into the new leg
  replace(range, `[${rungText},]`, first + (rungText ? inside + 1 : 1));
}

function leg() {
  const { places, legs } = read(textOf(at)), { branch: inside, to } = legs[places[at.place].leg];
  if (!inside) return branch();
  replace({ from: to, to }, ",", places.findLastIndex(each => each.leg === places[at.place].leg) + 1);
}

function remove(forward) {
  const range = at.place === at.anchor ? taken(textOf(at), at.place, forward) : selection();
  if (!range) return forward ? null : step(-1);
  replace(range, "");
}

export function newRung() {
  if (!isOpen()) return;
  const last = lastKey() ?? keyOf(routine, FIRST), where = at ?? { key: last, index: 0 };
  const index = where.key === keyOf(routine, FIRST) && !draft.rungs.has(where.key) ? 0 : where.index + 1;
  changeTexts(texts => { texts.splice(index, 0, EMPTY); }, where);
  moveCaret(where.key, index, 0);
}

export function deleteRung() {
  if (!at) return;
  const where = at, next = neighborOf(at, 1) ?? neighborOf(at, -1);
  at = null;
  changeTexts(texts => { texts.splice(where.index, 1); }, where);
  if (next && next.key !== where.key) moveCaret(next.key, next.index, 0);
}

function replaceText() {
  if (!at || text.value === textOf(at)) return;
  textOffers.close();
  setRungText(text.value.trim() || EMPTY);
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
  Home: () => moveCaret(at.key, at.index, 0),
  End: () => moveCaret(at.key, at.index, read(textOf(at)).places.length - 1),
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

function onKey(event) {
  if (!["Tab", "F6"].includes(event.key)) event.stopPropagation();
  if (offers.keyed(event)) return;
  const typed = input.value.trim(),
    key = event.key.length === 1 && (event.ctrlKey || event.metaKey) ? event.key.toLowerCase() : event.key;
  if (typed && event.key === "Escape") { input.value = ""; at.retyped = false; fitInput(); offers.close(); return; }
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
  // a rung that cannot be read is corrected as text
  if (!read(textOf(at) ?? "") && !["z", "y", "ArrowUp", "ArrowDown", "Escape"].includes(key)) return text.focus();
  act(event);
}

// Letters typed while no control has the focus go to the caret; they are not shortcuts then. Returns whether it is one.
export function takesTyped({ key, target, ctrlKey, metaKey, altKey }) {
  const plain = /^[a-z]$/i.test(key) && !ctrlKey && !metaKey && !altKey;
  if (!plain || !isOpen() || !target.matches("body, #program")) return false;
  at ? moveCaret(at.key, at.index, at.place, at.anchor) : begin(selected.rung);
  if (!input.isConnected) return true;
  input.value += key;
  fitInput();
  offers.show();
  return true;
}

function onTextKey(event) {
  event.stopPropagation();
  if (textOffers.keyed(event)) return;
  if (event.key === "Enter") { replaceText(); input.isConnected && input.focus(); }
  if (event.key === "Escape") { text.value = textOf(at) ?? ""; input.isConnected && input.focus(); }
}

function step(by, wide = false) {
  const { places } = read(textOf(at)), leg = places[at.place].leg;
  let next = at.place + by;
  while (wide && places[next] && places[next].leg !== leg) next += by; // over a branch
  if (places[next]) moveCaret(at.key, at.index, next, wide ? at.anchor : next);
}

// Moves the caret up or down: to the next leg, or else to the next rung.
function toNeighbor(by) {
  const gaps = checkedOf(at)?.gaps ?? [], [x, y] = gaps[at.place] ?? [0, 0];
  const beyond = gaps
    .map(([left, top], number) => ({ number, far: (top - y) * by, off: Math.abs(left - x) }))
    .filter(each => each.far > 1);
  if (beyond.length) {
    const [nearest] = beyond.sort((one, other) => one.far - other.far || one.off - other.off);
    return moveCaret(at.key, at.index, nearest.number);
  }
  const next = neighborOf(at, by);
  if (next) moveCaret(next.key, next.index, 0);
}

// Puts the selected instruction into the input, to be typed again.
function retype() {
  const range = selection();
  if (!range || range.from === range.to) return;
  at.retyped = true;
  input.value = typedOf(textOf(at).slice(range.from, range.to));
  fitInput();
  input.select();
}

function copy() {
  const range = selection();
  if (!range || range.from === range.to) return false;
  clipboard = textOf(at).slice(range.from, range.to);
  navigator.clipboard?.writeText(clipboard).catch(() => {}); // the page has its own clipboard
  return true;
}

const paste = () => { if (clipboard) replace(selection() ?? atCaret(), clipboard); };

function fitInput() {
  const body = caret.parentElement, most = (body?.clientWidth ?? 0) - parseFloat(caret.style.left);
  input.style.width = input.value ? `calc(${input.value.length + 1}ch + 14px)` : "";
  setFlag(caret, "data-typing", input.value !== "");
  input.style.marginLeft = body ? `${Math.min(0, most - input.offsetWidth)}px` : "";
}
