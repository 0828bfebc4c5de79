// Edits rungs where they are drawn: a caret between two elements, where is typed, and the text of the rung below it.
// A changed rung stands below the one that runs, as in Studio 5000: r is replaced, d deleted, e edited, i inserted.

import { completing, matching } from "./completing.js";
import { button, drawing, el, setFlag } from "./dom.js";
import { change, declare, draft, isLocked, keyOf, look, onDraft, redo, setColumns, undo } from "./draft.js";
import { shown } from "./format.js";
import { between, pieceOf, read, spliced, taken, typedOf } from "./rungtext.js";
import { run } from "./state.js";
import { place, unplace } from "./values.js";

const EMPTY = ";";
const FIRST = -1; // before the first rung

let sheet = null, routine = "", program = "", running = new Map(); // text of each running rung by key
let rows = new Map(), drafts = new Map(); // of running rungs by key, and of edited ones by key and index: a large program has many
let begins = null, deleted = [];
let on = false, clipboard = "", wanted = false; // whether the caret gets the focus once it can be drawn
let at = null; // { key, index, place, anchor }: the rung that is edited, and the places of the caret and of its other end

const mark = el("span", { class: "span", hidden: true });
const input = el("input", { class: "typed", "aria-label": "Instruction, such as XIC Start", spellcheck: "false", autocomplete: "off", autocapitalize: "off", keydown: keyed, input: () => { widen(); offers.show(); } });
const caret = el("span", { class: "caret" }, input);
const text = el("input", { class: "rungtext", "aria-label": "Text of the rung", spellcheck: "false", autocomplete: "off", autocapitalize: "off", keydown: textKeyed, change: () => replaceText(), input: () => words.show() });
const offers = completing(input, offered, widen);
const words = completing(text, offeredInText);
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
  [sheet, routine, program] = [node, name, base];
  running = new Map((rungs ?? []).map(each => [keyOf(name, each.number), each.text]));
  rows = new Map();
  for (const row of node.querySelectorAll(".rungs > .row[data-at]")) {
    const key = keyOf(name, row.dataset.at.slice(row.dataset.at.lastIndexOf(".") + 1));
    Object.assign(row.dataset, { key, index: 0 });
    rows.set(key, row);
  }
  drafts = new Map();
  setColumns(columns);
  if (on && at && at.key.split("\n")[0] !== name) at = null;
  if (isOpen()) look(at?.key, textOf(at) ?? EMPTY);
  redraw();
  begins?.();
}

// Whether the rungs that are shown can be edited: not those of an earlier program, and none in test.
const isOpen = () => on && !isLocked() && program === draft.base;

const textOf = where => where && (draft.rungs.get(where.key)?.[where.index] ?? (where.index === 0 ? running.get(where.key) : undefined));
const checkedOf = where => draft.checked.get(`${where.key}\n${where.index}`);

// --- the picture

onDraft(redraw);

function redraw() {
  if (!sheet) return;
  const list = sheet.querySelector(".rungs"), focused = [input, text].find(each => each === document.activeElement);
  for (const row of drafts.values()) {
    unplace(row);
    row.remove();
    if (rows.has(row.dataset.key)) delete rows.get(row.dataset.key).dataset.edited;
  }
  for (const key of deleted) delete rows.get(key)?.dataset.edited;
  drafts = new Map();
  deleted = [];
  setFlag(sheet, "data-editing", on);
  if (list && isOpen()) {
    for (const [key, texts] of draft.rungs) if (key.startsWith(`${routine}\n`)) rowsOf(list, key, texts);
  }
  setCaret(focused);
}

function rowsOf(list, key, texts) {
  const own = rows.get(key);
  if (own && !texts.length) deleted.push(key);
  if (own) own.dataset.edited = !texts.length ? "d" : texts[0] === running.get(key) ? "" : "r";
  let behind = own;
  texts.forEach((said, index) => {
    if (own && index === 0 && said === running.get(key)) return;
    const row = rowOf(key, index, said, own && index === 0 ? "e" : "i");
    drafts.set(`${key}\n${index}`, row);
    behind ? behind.after(row) : list.prepend(row);
    behind = row;
  });
}

function rowOf(key, index, said, letter) {
  const found = draft.checked.get(`${key}\n${index}`), says = { e: "Edited", i: "Inserted" }[letter];
  const picture = found?.svg ? drawing(found.svg) : el("code", { class: "unread" }, said);
  if (found?.svg) {
    picture.querySelectorAll("[data-name]").forEach(node => place(node, node.dataset.name, shown));
    picture.querySelectorAll("[data-element]").forEach((group, number) => setFlag(group, "data-mistake", found.mistakes.some(each => each.element === number)));
  }
  const notes = [...(found?.mistakes ?? []).filter(each => !isMissing(each)).map(each => noteOf(each.text, "mistake")), ...(found?.warnings ?? []).map(each => noteOf(each.text, "finding")), ...asked(said)];
  return el("li", { class: "row draft", "data-key": key, "data-index": index, "aria-label": `${says} rung` }, el("span", { class: "letter", title: says }, letter), el("div", { class: "body" }, picture, ...notes));
}

const isMissing = ({ text: said }) => draft.missing.some(({ name }) => said.includes(`: no tag ${name} (`) || said.includes(`: no tag ${name};`));
const noteOf = (said, kind) => el("p", { class: "note", "data-kind": kind }, said);

// Asks for the types of new tags, in the line of the rung that uses them; says what has been declared.
function asked(said) {
  const uses = name => new RegExp(`(?<!\\w)${name}(?!\\w)`, "i").test(said);
  const open = draft.missing.filter(({ name, types }) => types.length > 1 && uses(name)).map(({ name, types, program }) =>
    el("p", { class: "note asks", role: "group", "aria-label": `Type of ${name}` }, `New tag ${name}: `, ...types.map(type => button(`${name} is a ${type}`, () => declare(name, type, program), { text: type }))));
  const told = draft.tags.filter(([name]) => uses(name)).map(([name, type]) => el("p", { class: "note new" }, `New tag ${name} : ${type}`));
  return [...open, ...told];
}

// --- the caret

const rowAt = where => drafts.get(`${where.key}\n${where.index}`) ?? (where.index === 0 && !deleted.includes(where.key) ? rows.get(where.key) : undefined);

function go(key, index, where, anchor = where) {
  const far = !at || at.key !== key || at.index !== index;
  wanted = true;
  at = { key, index, place: where, anchor };
  if (far && !checkedOf(at)) look(key, textOf(at) ?? EMPTY);
  setCaret(input);
}

// Draws the caret at its place; the text of its rung stands below the picture.
function setCaret(focused) {
  const row = at && isOpen() ? rowAt(at) : null, said = textOf(at), svg = row?.querySelector("svg.rung"), gaps = row && checkedOf(at)?.gaps;
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
  focused ??= wanted ? input : null;
  wanted &&= !svg;
  if (focused === text || (focused && !svg && checkedOf(at))) { text.focus({ preventScroll: true }); if (column && focused !== text) text.setSelectionRange(column - 1, column); }
  else if (focused) { input.focus({ preventScroll: true }); row.scrollIntoView({ block: "nearest" }); }
}

// Places of the drawing in the box that holds it.
function pointOf(svg, body) {
  const box = svg.getBoundingClientRect(), outer = body.getBoundingClientRect(), { width, y } = svg.viewBox.baseVal, scale = box.width / width;
  return ([left, top]) => [box.left - outer.left + left * scale, box.top - outer.top + (top - y) * scale];
}

function clicked(event) {
  const row = isOpen() && event.target.closest(".row[data-key]"), svg = row && event.target.closest("svg.rung");
  if (!svg) return;
  event.stopPropagation();
  const { key, index } = row.dataset, number = Number(event.target.closest(".instruction")?.dataset.element.split(".").at(-1) ?? NaN);
  if (row.dataset.edited && !row.classList.contains("draft")) return; // the one below it is edited
  if (!Number.isNaN(number)) return choose(key, Number(index), number);
  go(key, Number(index), 0);
  nearest(svg, row, event);
}

// The place nearest to a point, once the places of the rung are known.
async function nearest(svg, row, { clientX, clientY }) {
  if (!checkedOf(at)) await look(at.key, textOf(at));
  const gaps = at && checkedOf(at)?.gaps, box = row.querySelector(".body").getBoundingClientRect(), point = pointOf(svg, row.querySelector(".body"));
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
    const texts = [...(rungs.get(where.key) ?? (running.has(where.key) ? [running.get(where.key)] : []))];
    make(texts);
    if (texts.length === 1 && texts[0] === running.get(where.key)) rungs.delete(where.key);
    else if (!texts.length && !running.has(where.key)) rungs.delete(where.key);
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
  const piece = pieceOf(typed, draft.words.instructions, tagsNow());
  input.value = "";
  widen();
  offers.close();
  splice(selection() ?? here(), piece);
}

const here = () => { const { at: from } = read(textOf(at)).places[at.place]; return { from, to: from }; };

function branch() {
  const range = selection() ?? here(), said = textOf(at).slice(range.from, range.to), first = Math.min(at.place, at.anchor);
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
  const last = [...running.keys()].at(-1) ?? keyOf(routine, FIRST), where = at ?? { key: last, index: 0 };
  const index = where.key === keyOf(routine, FIRST) && !draft.rungs.has(where.key) ? 0 : where.index + 1;
  put(texts => { texts.splice(index, 0, EMPTY); }, where);
  go(where.key, index, 0);
}

export function deleteRung() {
  if (!at) return;
  const where = at, next = neighbor(1) ?? neighbor(-1);
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
  z: event => event.shiftKey ? redo() : undo(), y: redo, c: () => copy(), x: () => { if (copy()) remove(true); }, v: () => paste(),
  Delete: deleteRung, Enter: newRung, b: branch,
};
const PLAIN = {
  ArrowLeft: event => step(-1, event.shiftKey), ArrowRight: event => step(1, event.shiftKey), ArrowUp: () => toNeighbor(-1), ArrowDown: () => toNeighbor(1),
  Home: () => go(at.key, at.index, 0), End: () => go(at.key, at.index, read(textOf(at)).places.length - 1),
  Backspace: () => remove(false), Delete: () => remove(true), Enter: () => at.place === at.anchor ? newRung() : retype(), F2: retype,
  "[": branch, ",": leg, Escape: () => { at = null; setCaret(null); },
};

function keyed(event) {
  if (event.key !== "Tab") event.stopPropagation();
  if (offers.keyed(event)) return;
  const typed = input.value.trim(), key = event.key.length === 1 && (event.ctrlKey || event.metaKey) ? event.key.toLowerCase() : event.key;
  if (typed && event.key === "Escape") { input.value = ""; widen(); offers.close(); return; }
  if (typed && event.key !== "Enter") return;
  const act = event.ctrlKey || event.metaKey ? CONTROL[key] : event.altKey ? null : typed ? () => insert(input.value) : PLAIN[key];
  if (!act || event.isComposing) return;
  event.preventDefault();
  if (!read(textOf(at) ?? "") && !["z", "y", "ArrowUp", "ArrowDown", "Escape"].includes(key)) return text.focus(); // only its text can be mended
  act(event);
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

function neighbor(by) {
  const rows = [...sheet.querySelectorAll(".row[data-key]")].filter(row => row.classList.contains("draft") || !row.dataset.edited), row = rows[rows.indexOf(rowAt(at)) + by];
  return row ? { key: row.dataset.key, index: Number(row.dataset.index) } : null;
}

// Up and down go to the next leg, then to the next rung.
function toNeighbor(by) {
  const gaps = checkedOf(at)?.gaps ?? [], [x, y] = gaps[at.place] ?? [0, 0];
  const beyond = gaps.map(([left, top], number) => ({ number, far: (top - y) * by, off: Math.abs(left - x) })).filter(each => each.far > 1);
  if (beyond.length) return go(at.key, at.index, beyond.sort((one, other) => one.far - other.far || one.off - other.off)[0].number);
  const next = neighbor(by);
  if (next) go(next.key, next.index, 0);
}

// Types the chosen instruction again.
function retype() {
  const range = selection();
  if (!range || range.from === range.to) return;
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

// --- completion

const tagsNow = () => [...draft.tags.map(([name, type]) => ({ text: name, says: `${type}, new` })), ...(run.hello.tags ?? []).map(each => ({ text: short(each.name), says: each.type }))];

// A tag of the routine's own program has its plain name there.
function short(name) {
  const own = /^\\[^.]+\./.exec(routine)?.[0];
  return own && name.toUpperCase().startsWith(own.toUpperCase()) ? name.slice(own.length) : name;
}

function offered(typed) {
  const [, before, word] = /^(.*?)([^\s,(]*)$/s.exec(typed), name = typed.trim().split(/[\s,(]/)[0].toUpperCase();
  if (!before.trim()) return word ? { from: before.length, found: matching(word, draft.words.instructions.map(each => ({ text: each.name, says: each.operands.join(", ") }))).filter(each => each.text.startsWith(word.toUpperCase())) } : null;
  if (!word) return null;
  const found = matching(word, tagsNow()), bits = draft.words.instructions.find(each => each.name === name)?.bits;
  return { from: before.length, found: bits ? [...found.filter(each => each.says.startsWith("BOOL")), ...found.filter(each => !each.says.startsWith("BOOL"))] : found };
}

function offeredInText(typed) {
  const [, before, word] = /^(.*?)([\w.:\\]*)$/s.exec(typed);
  if (!word || !/[(,]$/.test(before)) return null;
  return { from: before.length, found: matching(word, tagsNow()) };
}
