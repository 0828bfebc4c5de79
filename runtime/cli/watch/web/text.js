// Structured text with values beside its lines; Python with the line that runs and the variables that are recorded.

import { el, setAttribute, setText } from "./dom.js";
import { clock, shown } from "./format.js";
import { select } from "./selection.js";
import { run } from "./state.js";
import { place } from "./values.js";

let lines = new Map(); // Main.12 -> row
let since = null; // where it is said how long a line has run

export function buildText(routine, { text = [], names = [] }) {
  lines = new Map();
  since = (run.hello.sequences ?? []).length ? el("p", { class: "since", "aria-live": "off" }) : null;
  const code = el("ol", { class: "code" }, ...text.map(line => rowOf(routine, line)));
  const values = names.length ? el("div", { class: "variables", role: "group", "aria-label": "Variables" }, ...names.map(chip)) : null;
  return el("div", {}, values ?? "", since ?? "", code);
}

function rowOf(routine, { number, text, names = [] }) {
  const ident = `${routine.name}.${number}`;
  const row = el("li", { class: "code-line", "data-element": `${ident}.0`, "data-at": ident, "data-power": "0", click: () => select({ rung: ident, tag: names[0] ?? null, names }) },
    el("span", { class: "number" }, number ? String(number) : ""), el("code", {}, text), el("span", { class: "beside" }, ...names.map(chip)));
  lines.set(ident, row);
  return row;
}

function chip(name) {
  const value = el("output", { class: "figure" }, "–");
  place(value, name, shown);
  return el("button", { type: "button", class: "chip", click: event => { event.stopPropagation(); select({ tag: name }); } }, el("span", {}, name), value);
}

export function paintText({ power, lines: running }) {
  for (const [ident, now] of Object.entries(power ?? {})) {
    const row = lines.get(ident);
    if (row) setAttribute(row, "data-power", now[0]);
  }
  if (running && since) paintRunning();
}

// A sequence runs one line at a time: that line is marked, and how long it has been waiting there.
function paintRunning() {
  for (const row of lines.values()) setAttribute(row, "data-power", "0");
  const said = Object.entries(run.lines).filter(([, at]) => at).map(([name, { line, since: from }]) => {
    const row = [...lines.values()].find(each => each.dataset.at.endsWith(`.${line}`));
    if (row) setAttribute(row, "data-power", "1");
    return `${name}: line ${line}${from === undefined || from === null ? "" : `, since ${clock(from)}`}`;
  });
  setText(since, said.join("  ·  "));
}
