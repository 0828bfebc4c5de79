// The program: its routines as tabs, the rungs or text of the chosen one, and what is selected in it.

import { faultPlaces, markCauses, onCauses } from "./causes.js";
import { editButton, editor } from "./editing.js";
import { at, button, el, goTo, heading, setAttribute, setFlag, setText } from "./dom.js";
import { buildChart, buildDiagram } from "./diagram.js";
import { keep, kept } from "./kept.js";
import { buildRungs, moveTo, paintRungs } from "./ladder.js";
import { decorate } from "./rungedit.js";
import { link } from "./link.js";
import { isTree, treeOf } from "./routines.js";
import { onSelect, select, selected } from "./selection.js";
import { tell } from "./notice.js";
import { order } from "./orders.js";
import { onPaint, onProgram, run } from "./state.js";
import { buildText, paintText } from "./text.js";
import { learn, unbindIn } from "./values.js";

const PROGRAM = /^\\[^.]+\./; // the program in the name of a routine, such as \Filling.Main
const UNIT = 8, LEAST = 40, MOST = 160; // CSS pixels of a column; columns between the rails

const tabs = el("div", { class: "tabs", role: "tablist", "aria-label": "Routines" });
const sheet = el("div", { class: "sheet", role: "tabpanel", "aria-label": "Routine" });
const unknown = el("p", { class: "unknown", role: "status" });
let routine = null,
  columns = 0,
  requestedDrawing = "",
  presentDrawing = "",
  drawnName = "",
  wantedRung = null,
  smooth = true,
  generation = 0;

const operandsButton = button(
  "Parameters",
  () => {
    keep("parameters", { on: operandsButton.getAttribute("aria-pressed") !== "true" });
    open(routine.name);
  },
  { title: "Show the parameters of blocks that say what they do", hidden: true }
);

const narrow = matchMedia("(max-width: 999px)");

const columnsNow = () => Math.max(LEAST, Math.min(MOST, Math.floor((sheet.clientWidth - 64) / UNIT)));

onProgram(hello => {
  const routines = hello.routines ?? [];
  const tree = routines.length > 1 && isTree(routines);
  const { scrollTop } = at("program"); // the routine that was shown stays where it was
  at("program").replaceChildren(
    heading("Program", tree ? null : tabs, el("span", { class: "tools" }, operandsButton, editButton)),
    editor,
    unknown,
    el("div", { class: "book" }, tree ? tabs : null, sheet)
  );
  setFlag(tabs, "data-tree", tree);
  const [program, ...others] = new Set(routines.map(each => PROGRAM.exec(each.name)?.[0] ?? ""));
  tabs.replaceChildren(
    ...(tree ? treeOf(routines) : routines).map(each =>
      tabOf(each, others.length ? each.name : each.name.slice(program?.length))
    )
  );
  tabs.hidden = routines.length < 2;
  const before = routines.find(each => each.name === routine?.name);
  requestedDrawing = "";
  if (before) at("program").scrollTop = scrollTop;
  if (routines.length) open((before ?? routines[0]).name);
  else
    sheet.replaceChildren(
      el("p", { class: "soft" }, hello.lacks || "The program has no source to show: its images are below.")
    );
});

function tabOf({ name, comment, depth = 0, callers = [] }, text) {
  const hint = [comment, callers.length && `Called by ${callers.join(", ")}`].filter(Boolean).join("\n");
  const tab = el(
    "button",
    {
      type: "button",
      role: "tab",
      "data-routine": name,
      "aria-selected": "false",
      title: hint || null,
      click: () => open(name),
      keydown: event => goTo(event, [...tabs.children], { ArrowLeft: -1, ArrowRight: 1, ArrowUp: -1, ArrowDown: 1 }),
    },
    text
  );
  tab.style.setProperty("--depth", depth);
  return tab;
}

// Shows a routine. Requests its drawing if it is not the present one: another routine, or another width.
async function open(name) {
  const found = run.hello.routines.find(each => each.name === name);
  if (!found) return;
  routine = found;
  columns = columnsNow();
  const all = kept("parameters", {}).on === true && !run.hello.shared, drawing = `${name} ${columns} ${all}`;
  setAttribute(operandsButton, "aria-pressed", String(all));
  for (const tab of tabs.children) {
    setAttribute(tab, "aria-selected", String(tab.dataset.routine === name));
    tab.tabIndex = tab.dataset.routine === name ? 0 : -1;
  }
  if (drawing === requestedDrawing) return reveal();
  requestedDrawing = drawing;
  const request = ++generation;
  const answer = await order("show", { routine: name, columns, ...(all ? { operands: true } : {}) });
  if (!answer) { requestedDrawing = ""; return; }
  if (request !== generation) return;
  presentDrawing = drawing;
  learn(answer.addresses);
  const focused = sheet.contains(document.activeElement) ? document.activeElement.dataset.element : undefined;
  unbindIn(sheet);
  const { scrollTop } = at("program");
  sheet.replaceChildren(
    answer.diagram
      ? buildDiagram(answer)
      : answer.chart
        ? buildChart(answer)
        : answer.rungs
          ? buildRungs(name, answer.rungs, openCalled)
          : buildText(found, answer)
  );
  sheet.dataset.kind = found.kind;
  setFlag(
    operandsButton,
    "hidden",
    Boolean(run.hello.shared) || (!all && !sheet.querySelector(".instruction:has([data-now]):not(:has(.caption))"))
  );
  decorate(sheet, name, answer, columns);
  paintRungs({ power: run.power, breakpoints: run.breakpoints });
  const { power, tags, lines, met, breakpoints, ran, scan, state } = run;
  paintText({ power, tags, lines, met, breakpoints, ran, scan, state });
  markSelected(selected);
  markFaults();
  markCauses(sheet);
  if (name === drawnName) at("program").scrollTop = scrollTop;
  drawnName = name;
  if (focused) sheet.querySelector(`[data-element="${CSS.escape(focused)}"]`)?.focus({ preventScroll: true });
  reveal();
}

// Whether the chosen routine is drawn, for the present width.
export const isDrawn = () => requestedDrawing !== "" && presentDrawing === requestedDrawing && columnsNow() === columns;

// Opens the routine that a JSR of the present one calls.
function openCalled(name) {
  const program = PROGRAM.exec(routine.name)?.[0] ?? "";
  const found = run.hello.routines.find(each =>
    [program + name, name].some(requested => requested.toUpperCase() === each.name.toUpperCase())
  );
  if (!found) return tell(`There is no routine ${name}.`);
  at("program").scrollTop = 0;
  open(found.name);
}

const routineOf = rung => rung.slice(0, rung.lastIndexOf("."));

// Opens the routine of a rung, such as Main.6, and brings the rung into view.
export function showRung(rung, smoothly = true) {
  wantedRung = rung;
  smooth = smoothly && !matchMedia("(prefers-reduced-motion: reduce)").matches;
  markFaults();
  select({ tag: selected.tag, names: selected.names, rung });
  open(routineOf(rung));
}

function reveal() {
  if (!wantedRung) return;
  const node = sheet.querySelector(`[data-at="${CSS.escape(wantedRung)}"]`);
  if (!node) return; // the routine is not drawn yet
  wantedRung = null;
  // of a tall rung
  const cause = node.offsetHeight > at("program").clientHeight / 2 ? node.querySelector("[data-because]") : null;
  (cause ?? node).scrollIntoView({ block: "center", behavior: smooth ? "smooth" : "auto" });
}

// Moves to the next rung, or to the previous one. An instruction with the focus passes it to one of that rung.
export function moveRung(by) {
  const focused = document.activeElement?.closest?.(".sheet .instruction"),
    from = focused?.closest("[data-at]").dataset.at ?? selected.rung,
    // the line at which a sequence waits
    begin = from ? null : sheet.querySelector(".code-line[data-power='1']")?.dataset.at;
  const rung = moveTo(sheet, from ?? begin, begin ? 0 : by);
  if (!rung) return;
  showRung(rung);
  if (focused) sheet.querySelector(`[data-at="${CSS.escape(rung)}"] .instruction`)?.focus({ preventScroll: true });
}

function markSelected({ rung, element }) {
  for (const node of sheet.querySelectorAll("[aria-current]")) node.removeAttribute("aria-current");
  if (rung) sheet.querySelector(`[data-at="${CSS.escape(rung)}"]`)?.setAttribute("aria-current", "true");
  if (element) sheet.querySelector(`[data-element="${CSS.escape(element)}"]`)?.setAttribute("aria-current", "true");
}

onSelect(chosen => {
  link({ rung: chosen.rung });
  markSelected(chosen);
  if (chosen.element && narrow.matches)
    // above the tag's sheet
    sheet.querySelector(`[data-at="${CSS.escape(chosen.rung)}"]`)?.scrollIntoView({ block: "nearest" });
});

// Marks the rung or line of a fault, or of the error that is shown.
function markFaults() {
  const places = faultPlaces();
  for (const row of sheet.querySelectorAll("[data-at]")) setFlag(row, "data-fault", places.includes(row.dataset.at));
}

onPaint(changes => {
  setText(
    unknown,
    run.state === "paused"
      ? "Power and values come with the next scan."
      : "Power and values of this scan are being computed."
  );
  if (changes.faults || changes.scan !== undefined) markFaults();
  paintRungs(changes);
  paintText(changes);
});

onCauses(() => markCauses(sheet));

let settling = 0;
new ResizeObserver(() => {
  // several routines differ in size
  const isSmall = sheet.offsetHeight < innerHeight / 2 && run.hello?.routines?.length < 2;
  setFlag(document.documentElement, "data-fits", isSmall);
  clearTimeout(settling);
  settling = setTimeout(() => { if (routine && run.hello && columnsNow() !== columns) open(routine.name); }, 200);
}).observe(sheet);
