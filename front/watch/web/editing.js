// Edits of the program: a text that is typed here, or a saved file that waits. Each is shown before it is taken over:
// what differs, its mistakes at their lines, what begins anew.

import { button, el, setFlag, setText } from "./dom.js";
import { hush, tell } from "./notice.js";
import * as orders from "./orders.js";
import { onHello, onProgram } from "./state.js";

const ROWS = 18; // lines of the field
const BYTES_MOST = 60000; // of a text as JSON
const KEYS_MS = 600; // a text is previewed when nothing has been typed for so long

export const editButton = button("Edit", open, { title: "Edit the program's text", hidden: true });
const title = el("h3");
const field = el("textarea", { "aria-label": "Text of the program", rows: ROWS, spellcheck: "false", autocomplete: "off", wrap: "off", input: typed, keydown: keyed });
const shown = el("div", { class: "shown", "aria-live": "polite" });
const takeButton = button("Take over", () => take(), { title: "Continue with it from the next scan on" });
const anewButton = button("Take over anew", () => take(restarts.join(",")), { title: "Continue with it; these sequences begin anew", hidden: true });
const backButton = button("Back", back, { title: "Leave the running program as it is" });
export const editor = el("div", { class: "editing", role: "group", "aria-label": "Edit", hidden: true },
  title, field, el("div", { class: "line" }, takeButton, anewButton, backButton), shown);

let base = null; // of a typed text: what it is an edit of; null of a saved file
let restarts = [], timer = 0, asked = 0;

onHello(() => { if (base === null) back(); });
onProgram(hello => {
  const names = (hello.routines ?? []).map(each => each.kind);
  setFlag(editButton, "hidden", !orders.allowed() || !names.length);
});

async function open() {
  const source = await orders.order("source");
  if (!source) return;
  if (source.lacks) return tell(`${source.lacks[0].toUpperCase()}${source.lacks.slice(1)}. Or save the file: it is taken over at once.`);
  base = source.base;
  field.value = source.text;
  field.rows = Math.min(ROWS, source.text.split("\n").length + 1);
  present(source.file, true);
  field.focus({ preventScroll: true });
  field.setSelectionRange(0, 0);
  field.scrollTop = 0;
  typed();
}

function present(file, typing) {
  setText(title, typing ? `Edit ${file}` : `${file} was saved, and waits`);
  setFlag(field, "hidden", !typing);
  setFlag(editor, "hidden", false);
  setFlag(editButton, "hidden", true);
}

// Shows the preview of a saved file; null when it is as the running program.
export function waits(preview) {
  if (!preview) { if (base === null) back(); return; }
  base = null;
  present(preview.file, false);
  show(preview);
}

// The edit has been taken over.
export function taken() {
  if (!editor.hidden) back();
}

function back() {
  base = null;
  clearTimeout(timer);
  asked++;
  setFlag(editor, "hidden", true);
  setFlag(editButton, "hidden", !orders.allowed());
  shown.replaceChildren();
}

function typed() {
  clearTimeout(timer);
  permit(false);
  timer = setTimeout(preview, KEYS_MS);
}

// Tab goes on to the next control; Escape leaves the field, not the edit.
function keyed(event) {
  event.stopPropagation();
  if (event.key === "Escape") backButton.focus();
}

const isTooLong = () => new TextEncoder().encode(JSON.stringify(field.value)).length > BYTES_MOST;

async function preview() {
  if (isTooLong()) return tell(`The text is too long to be edited here: up to ${BYTES_MOST} bytes.`);
  const mine = ++asked, said = await orders.order("draft", { text: field.value, base });
  if (mine === asked && said) show(said.preview);
}

async function take(restart = "") {
  permit(false);
  if (base === null) return orders.reload(restart);
  const text = field.value;
  if (await orders.order("draft", { text, base, restart, take: true })) return hush();
  permit(true);
}

function permit(on, { mistakes = [], restart = [], rows = [] } = {}) {
  restarts = restart;
  takeButton.disabled = !on || mistakes.length > 0 || !rows.length;
  setFlag(anewButton, "hidden", !restart.length);
  anewButton.disabled = !on;
  setText(anewButton, `Take over, ${restart.join(", ")} anew`);
}

function show(preview) {
  permit(true, preview);
  const { mistakes, findings, rows, groups, keeps, more } = preview;
  const notes = [...mistakes.map(each => ({ ...each, kind: "mistake" })), ...findings.map(each => ({ ...each, kind: "finding" }))];
  const isAt = (note, row) => row.text !== null && (note.old ? row.old === note.old && (row.sign === "-" || row.sign === " ") : note.line && row.new === note.line);
  shown.replaceChildren(
    verdict(preview),
    ...notes.filter(note => !rows.some(row => isAt(note, row))).map(noteOf),
    rows.length ? el("ol", { class: "diff", tabindex: "0", "aria-label": "Differences" }, ...rows.flatMap(row => [rowOf(row), ...notes.filter(note => isAt(note, row)).map(noteOf)])) : "",
    more ? el("p", { class: "soft" }, `${more} further lines differ`) : "",
    keeps ? el("p", { class: "keeps" }, `${keeps[0].toUpperCase()}${keeps.slice(1)}.`) : "",
    groups.length ? el("dl", { class: "resets" }, ...groups.flatMap(groupOf)) : "");
}

function verdict({ mistakes, rows, restart }) {
  const count = mistakes.length;
  const said = restart.length ? `It can't continue as it is, but with ${restart.join(", ")} begun anew.` : count ? `${count === 1 ? "A mistake" : `${count} mistakes`}: it can't be taken over.` : rows.length ? "It can be taken over." : "It is the program that runs.";
  return el("p", { class: "verdict", "data-kind": count ? "mistake" : "good" }, said);
}

const TITLES = {
  "of another type": "Begin anew, of another type", "changed": "Begin anew, or have another constant",
  "keep their value": "Keep their value, whatever the text says",
};

const titleOf = name => TITLES[name] ?? name[0].toUpperCase() + name.slice(1);

const groupOf = ({ title: name, names }) => [el("dt", {}, titleOf(name)), el("dd", {}, names.join(", "))];

function rowOf({ sign, old, new: number, text }) {
  if (text === null) return el("li", { class: "gap" }, "⋯");
  return el("li", { "data-sign": sign, "data-old": old, "data-new": number }, el("span", { class: "number" }, String(number ?? old)), el("span", { class: "sign" }, sign), el("code", {}, text || " "));
}

function noteOf({ kind, line, old, text, rule }) {
  const where = line ? el("button", { type: "button", class: "plain", title: `To line ${line}`, click: () => toLine(line) }, `Line ${line}`) : old ? el("b", {}, `Line ${old} now`) : "";
  return el("li", { class: "note", "data-kind": kind, "data-line": line ?? old ?? "" }, where, ` ${rule ? `${rule}: ` : ""}${text}`);
}

// Puts the caret into a line of the field.
function toLine(line) {
  if (field.hidden) return;
  const lines = field.value.split("\n"), start = lines.slice(0, line - 1).join("\n").length + (line > 1 ? 1 : 0);
  field.focus();
  field.setSelectionRange(start, start + (lines[line - 1]?.length ?? 0));
  field.scrollTop = (line - ROWS / 2) * (field.scrollHeight / Math.max(lines.length, 1));
}
