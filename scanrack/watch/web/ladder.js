// Rungs: the server draws them, and the page lights them. A frame has a character per element of a changed rung.

import { breakpointsAt, stopButton } from "./breakpoints.js";
import { drawing, el, setAttribute, setFlag } from "./dom.js";
import { shown } from "./format.js";
import { beginNow, paintNow } from "./now.js";
import { isClicked } from "./pointer.js";
import { select } from "./selection.js";
import { namesOf } from "./subject.js";
import { bindValue } from "./values.js";

const MANY = 60; // with more rungs, only rungs in view are laid out

/** @type {(name: string) => void} */
let openRoutine = () => {};
let rungs = new Map(); // Main.3 -> { row, elements, power, stop }

// `open` shows a routine that a JSR calls.
export function buildRungs(routine, list, open) {
  rungs = new Map();
  openRoutine = open;
  const sheet = el(
    "ol",
    { class: list.length > MANY ? "rungs many" : "rungs", "aria-label": "Rungs", focusin: describe },
    ...list.map(rung => rowOf(`${routine}.${rung.number}`, rung))
  );
  sheet.querySelector(".instruction")?.setAttribute("tabindex", "0");
  beginNow(sheet);
  return sheet;
}

function rowOf(ident, { number, svg, comment, file, line }) {
  const picture = drawing(svg);
  const source = { "data-file": file ? `${file}:${line}` : null };
  const stop = stopButton(ident, "rung", number, source, el("small", { "aria-hidden": "true" }));
  const row = el("li", { class: "row", "data-at": ident, click: event => clicked(event, ident), keydown: keyed }, stop,
    el("div", { class: "body" }, comment ? el("p", { class: "comment" }, comment) : null, picture));
  const elements = [...picture.querySelectorAll("[data-element]")];
  elements.forEach(element => element.setAttribute("data-power", "0"));
  for (const group of picture.querySelectorAll(".instruction")) {
    group.setAttribute("role", isCall(group) ? "link" : "button");
    group.setAttribute("tabindex", "-1");
  }
  picture.querySelectorAll("[data-name]").forEach(node => bindValue(node, node.dataset.name, shown));
  rungs.set(ident, { row, elements, power: "", stop });
  return row;
}

// Describes the instruction with the focus for screen readers: its values, and whether it passes power. Tab stops only
// at this instruction; arrows move to the others.
function describe({ target, currentTarget }) {
  const group = target.closest(".instruction");
  if (!group) return;
  const values = [...group.querySelectorAll(".value, .now")].map(node => node.textContent).filter(Boolean);
  setAttribute(group, "aria-description", [...values, group.dataset.power === "1" ? "power" : "no power"].join(", "));
  for (const other of currentTarget.querySelectorAll(".instruction[tabindex='0']"))
    other.setAttribute("tabindex", "-1");
  group.setAttribute("tabindex", "0");
}

const isCall = group => group.dataset.instruction === "JSR";

function clicked(event, ident) {
  const group = event.target.closest(".instruction");
  if (!group) return select({ rung: ident });
  if (isCall(group)) return openRoutine(group.dataset.tag);
  select({ tag: group.dataset.tag || null, element: group.dataset.element, rung: ident, names: namesOf(group) });
}

// Left and right move between the instructions of a rung; Enter and space select one.
function keyed(event) {
  const group = event.target.closest(".instruction");
  if (!group) return;
  if (event.key === "Enter" || (event.key === " " && !isClicked(group))) {
    event.preventDefault();
    return clicked({ target: group }, event.currentTarget.dataset.at);
  }
  const move = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
  if (!move) return;
  const all = [...event.currentTarget.querySelectorAll(".instruction")], next = all[all.indexOf(group) + move];
  event.preventDefault();
  if (!next) return;
  next.focus();
}

// Returns the rung that is a number of rows from another one.
export function moveTo(sheet, from, by) {
  const all = [...sheet.querySelectorAll("[data-at]")].map(node => node.dataset.at);
  const here = all.indexOf(from);
  return here < 0 ? all[by > 0 ? 0 : all.length - 1] : all[Math.min(Math.max(here + by, 0), all.length - 1)];
}

/** @param {{ power?: any, breakpoints?: any, tags?: any }} changes */
export function paintRungs({ power, breakpoints, tags }) {
  for (const [ident, rungPower] of Object.entries(power ?? {})) {
    const rung = rungs.get(ident);
    if (rung) light(rung, rungPower);
  }
  paintNow(tags, power);
  if (breakpoints) {
    for (const [ident, { row, stop }] of rungs) paintStop(ident, row, stop, breakpointsAt(ident, breakpoints));
  }
}

// Shows the conditions of breakpoints at the number of a rung.
function paintStop(ident, row, stop, set) {
  const number = ident.split(".").at(-1), words = set.map(([, short]) => short).join(", ");
  setFlag(row, "data-breakpoint", set.length);
  setAttribute(stop, "aria-pressed", String(set.length > 0));
  setAttribute(stop, "aria-description", words ? `Waits for: ${words}` : null);
  stop.lastChild.textContent = words;
  stop.title = [
    set.length
      ? `Rung ${number}: waits until it ${set.map(([, , text]) => text).join(", or ")}`
      : `Rung ${number}: breakpoint (b); right-click for other conditions`,
    stop.dataset.file,
  ]
    .filter(Boolean)
    .join("\n");
}

function light(rung, power) {
  const oldPower = rung.power;
  if (power === oldPower) return;
  rung.power = power;
  rung.elements.forEach((element, index) => {
    if (power[index] !== oldPower[index]) element.setAttribute("data-power", power[index] ?? "0");
  });
}
