// Structured text with values beside its lines; Python with the line that runs and the recorded variables.

import { breakpointsAt, stopButton } from "./breakpoints.js";
import { at as partOf, el, setAttribute, setFlag, setText, textButton } from "./dom.js";
import { clock, shown } from "./format.js";
import { select } from "./selection.js";
import { askRanLines, ranLines } from "./ranlines.js";
import { run } from "./state.js";
import { bindValue } from "./values.js";

let lines = new Map(); // Main.12 -> its rows: of structured text there may be several
let routine = ""; // its name
let variables = null, chips = new Set(); // the node with the values of a Python program, and their names
let followed = null; // the row that was scrolled into view last
let waits = null; // the list of sequences, with the line at which each waits
let ranNote = null; // the sentence about the lines that ran
let users = []; // { beside, uses } of Python lines: the node for values, and the names in the line

export function buildText({ name, kind }, { text = [], names = [] }) {
  lines = new Map();
  users = [];
  routine = name;
  followed = null;
  waits = kind === "st" ? null : el("ul", { class: "waits", "aria-label": "Sequences" });
  ranNote = kind === "python" ? el("p", { class: "soft", role: "status" }) : null;
  const code = el("ol", { class: "code" }, ...text.map(rowOf));
  variables = waits && el("div", { class: "variables", role: "group", "aria-label": "Variables" });
  chips = new Set();
  addChips(names);
  return el("div", {}, variables ?? "", waits ?? "", ranNote ?? "", code);
}

// Adds variables, which a Python program may make while it runs: above the text, and beside the lines that name them.
function addChips(names) {
  const more = names.filter(name => !chips.has(name));
  if (!variables || !more.length) return;
  variables.append(...more.map(name => chip(name)));
  for (const name of more) {
    chips.add(name);
    const own = name.slice(name.indexOf(".")); // `.step` of line.step, for self.step
    for (const { beside, uses } of users)
      if (uses.includes(name) || uses.includes(own)) beside.append(chip(name, own.slice(1)));
  }
}

// The text of a line, divided into spans that have kinds.
function pieces(text, spans) {
  const found = [];
  let done = 0;
  for (const [from, to, kind] of spans) {
    found.push(text.slice(done, from), el("span", { "data-kind": kind }, text.slice(from, to)));
    done = to;
  }
  return [...found, text.slice(done)];
}

function rowOf({ number, text, names = [], spans = [], uses = [] }) {
  const ident = `${routine}.${number}`, beside = el("span", { class: "beside" }, ...names.map(name => chip(name)));
  const parts = [
    number
      ? stopButton(ident, "line", number, { class: "stop number", title: `Line ${number}: breakpoint (b)` })
      : el("span", { class: "number" }),
    el("code", {}, ...pieces(text, spans)),
    beside,
  ];
  if (!number) return el("li", { class: "code-line" }, ...parts); // nothing runs there
  if (uses.length) users.push({ beside, uses });
  const row = el(
    "li",
    {
      class: "code-line",
      "data-element": `${ident}.0`,
      "data-at": ident,
      "data-power": "0",
      click: () => select({ rung: ident, tag: names[0] ?? null, names }),
    },
    ...parts
  );
  if (!lines.has(ident)) lines.set(ident, []);
  lines.get(ident).push(row);
  return row;
}

function chip(name, text = name) {
  const value = el("output", { class: "figure" }, "–");
  bindValue(value, name, shown);
  return el(
    "button",
    {
      type: "button",
      class: "chip",
      title: name,
      click: event => {
        event.stopPropagation();
        select({ tag: name });
      },
    },
    el("span", {}, text),
    value
  );
}

export function paintText({ power, tags, lines: running, breakpoints, met, ran, scan, state }) {
  if (tags) addChips(Object.keys(tags));
  if (breakpoints)
    for (const [ident, rows] of lines)
      for (const row of rows) paintStop(row, breakpointsAt(ident, breakpoints).length > 0);
  for (const [ident, now] of Object.entries(power ?? {})) {
    for (const row of lines.get(ident) ?? []) setAttribute(row, "data-power", now[0] ?? "0");
  }
  if ((running || met) && waits) paintRunning();
  if (ranNote && (ran || scan !== undefined || state)) {
    askRanLines(paintRan);
    paintRan();
  }
}

function paintRan() {
  if (!ranNote) return;
  const { lines: ran, says } = ranLines();
  for (const [ident, [row]] of lines) setFlag(row, "data-ran", ran.includes(lineOf(ident)));
  setText(ranNote, says);
}

function paintStop(row, isSet) {
  setFlag(row, "data-breakpoint", isSet);
  setAttribute(row.firstChild, "aria-pressed", String(isSet));
}

// Marks the line at which each sequence waits, and lists for what it waits and since when.
function paintRunning() {
  const here = Object.entries(run.lines).filter(([, at]) => at);
  const marked = new Set([...here.filter(([, at]) => isHere(at)).map(([, { line }]) => line), ...metLines()]);
  for (const [ident, [row]] of lines) setAttribute(row, "data-power", marked.has(lineOf(ident)) ? "1" : "0");
  while (waits.children.length < here.length)
    waits.append(el("li", {}, textButton("", jump), el("code")));
  while (waits.children.length > here.length) waits.lastChild.remove();
  here.forEach(([name, at], place) => paintWait(waits.children[place], name, at));
  follow(lines.get(`${routine}.${metLines()[0] ?? here.find(([, at]) => isHere(at))?.[1].line}`)?.[0]);
}

const lineOf = ident => Number(ident.split(".").at(-1));

// The lines whose breakpoints ended the latest run.
const metLines = () => (run.met ?? []).map(said => Number(/ line (\d+) has run$/.exec(said)?.[1])).filter(Boolean);

// Scrolls to the line at which the first sequence waits, unless the user has scrolled elsewhere.
function follow(row) {
  // a narrow page scrolls as a whole
  if (!row || row === followed || !matchMedia("(min-width: 1000px)").matches) return;
  if (!followed || isSeen(followed)) row.scrollIntoView({ block: "center" });
  followed = row;
}

function isSeen(row) {
  const { top, bottom } = partOf("program").getBoundingClientRect(), place = row.getBoundingClientRect();
  return place.bottom > top && place.top < bottom;
}

// Whether a line is in the shown file: a program may import its sequences.
const isHere = ({ file }) => !file || file.split("/").at(-1) === routine;

function paintWait(item, name, at) {
  const [button, code] = item.children,
    { line, text, since } = at,
    row = isHere(at) ? lines.get(`${routine}.${line}`)?.[0] : null;
  button.dataset.line = isHere(at) ? line : "";
  setText(code, row?.querySelector("code").textContent.trim() ?? "");
  const parts = [
    `${name} waits at line ${line}`,
    isHere(at) ? "" : ` of ${at.file.split("/").at(-1)}`,
    text ? ` for ${text}` : "",
    since === undefined || since === null ? "" : ` since ${clock(since)}`,
  ];
  setText(button, parts.join(""));
}

function jump(event) {
  const { line } = event.currentTarget.dataset;
  const [ident, [row] = []] = [...lines].find(([ident]) => ident.endsWith(`.${line}`)) ?? [];
  if (!row) return;
  select({ rung: ident, tag: null });
  row.scrollIntoView({ block: "center" });
}
