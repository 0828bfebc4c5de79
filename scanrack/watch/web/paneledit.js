// Builds an operator panel: items are dragged onto the grid, then moved and resized, also with keys. Only Save writes
// the file.

import { at, button, el, fill, setFlag, setText, textField } from "./dom.js";
import { tell } from "./notice.js";
import * as orders from "./orders.js";
import { lay } from "./panelitems.js";

const MOVES = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const FREE_ROWS = 4; // below the last item
const isList = key => ["positions", "values"].includes(key),
  isNumber = key => ["least", "most", "decimals"].includes(key);
const DEFAULTS = { least: 0, most: 100, positions: ["Off", "On"] };

let panelNow = null,
  view = null,
  draft = null,
  bound = [],
  chosen = null,
  itemInForm,
  node = null,
  changed = false,
  lastCheck = 0;
const form = el("div", { class: "row form", role: "group" });
const errorText = el("p", { class: "wrong", role: "status" });
const saveButton = button("Save panel", save, { text: "Save" }),
  leaveButton = button("Discard changes", () => view.edit(false));

// The tools of the panel that is being edited, or null.
export const editing = () => node;

// Begins to edit a panel; null ends the editing. `by` is the view of the panel, with functions show, edit and take.
export function editor(panel, by) {
  [panelNow, view, chosen, itemInForm, changed] = [panel, by, null, undefined, false];
  node =
    panel &&
    el(
      "div",
      { class: "building" },
      el(
        "div",
        { class: "line", role: "group", "aria-label": "Add an item" },
        ...Object.entries(panel.kinds).map(([kind, { title }]) =>
          el(
            "button",
            {
              type: "button",
              class: "kind",
              title: `Drag onto the grid: ${title}`,
              pointerdown: event => dragNew(event, kind),
              click: event => {
                if (!event.detail) add(kind);
              },
            },
            `+ ${kind}`
          )
        ),
        el("span", { class: "ways" }, saveButton, leaveButton)
      ),
      form,
      errorText
    );
  if (!node) return;
  draft = structuredClone(panel.items);
  bound = panel.bound;
  redraw();
}

function redraw() {
  const cells = at("panel").querySelector(".grid"), inGrid = cells.contains(document.activeElement);
  view.show(draft, bound);
  cells.dataset.building = "";
  cells.style.setProperty(
    "--rows",
    Math.max(0, ...draft.map(({ at: [, row], size: [, height] }) => row + height)) + FREE_ROWS
  );
  for (const cell of cells.children) makeEditable(cell, draft.find(item => item.name === cell.dataset.item));
  if (inGrid) focus();
  saveButton.disabled = !changed;
  setText(leaveButton, changed ? "Discard" : "Close");
  fillForm();
}

// Makes an item editable: dragging moves it, dragging its corner resizes it.
function makeEditable(cell, item) {
  const corner = el("i", { class: "corner", "aria-hidden": "true" }),
    [column, row] = item.at,
    [width, height] = item.size;
  cell.firstChild.inert = true;
  setFlag(cell, "data-chosen", item === chosen);
  fill(
    cell,
    {
      tabindex: 0,
      role: "group",
      "aria-label":
        `${item.name}, ${panelNow.kinds[item.kind].title}, ` +
        `column ${column + 1}, row ${row + 1}, ${width} by ${height}`,
      focus: () => choose(item, cell),
      pointerdown: event => {
        event.preventDefault();
        cell.focus();
        choose(item, cell);
        drag(event, cell, item, event.target === corner);
      },
      keydown: event => {
        const move = MOVES[event.key];
        if (event.key === "Delete" || event.key === "Backspace") event.preventDefault(), remove(item);
        else if (event.key === "Enter") event.preventDefault(), form.querySelector("input")?.focus();
        else if (move && !event.ctrlKey) event.preventDefault(), moveByKey(item, move, event.shiftKey);
      },
    },
    [corner]
  );
}

function choose(item, cell) {
  if (chosen === item) return;
  chosen = item;
  for (const each of cell.parentElement.children) setFlag(each, "data-chosen", each === cell);
  fillForm();
}

const focus = () => at("panel").querySelector("[data-chosen]")?.focus();

function moveByKey(item, [x, y], resizes) {
  const key = resizes ? "size" : "at", next = { ...item, [key]: [item[key][0] + x, item[key][1] + y] };
  if (!fits(next, item)) return;
  item[key] = next[key];
  draftChanged();
}

/**
 * Whether the item is within the grid and no other item has its cells; `own` is the item that it replaces.
 * @param {{ at: number[], size: number[] }} item
 * @param {any} [own]
 */
function fits({ at: [column, row], size: [width, height] }, own) {
  const inside =
    column >= 0 &&
    row >= 0 &&
    width > 0 &&
    height > 0 &&
    height <= 8 &&
    column + width <= panelNow.columns &&
    row + height <= 60;
  return (
    inside &&
    draft.every(
      each =>
        each === own ||
        each.at[0] >= column + width ||
        column >= each.at[0] + each.size[0] ||
        each.at[1] >= row + height ||
        row >= each.at[1] + each.size[1]
    )
  );
}

function cellAt({ clientX, clientY }) {
  const cells = at("panel").querySelector(".grid"),
    { left, top, width } = cells.getBoundingClientRect(),
    style = getComputedStyle(cells),
    gap = parseFloat(style.rowGap);
  return [
    Math.floor((clientX - left) / ((width + gap) / panelNow.columns)),
    Math.floor((clientY - top) / (parseFloat(style.gridAutoRows) + gap)),
  ];
}

function drag(begin, cell, item, resizes) {
  const first = cellAt(begin), from = resizes ? item.size : item.at, key = resizes ? "size" : "at";
  trackPointer(begin, cell, event => {
    const now = cellAt(event), next = { ...item, [key]: from.map((each, way) => each + now[way] - first[way]) };
    if (String(next[key]) === String(item[key]) || !fits(next, item)) return;
    item[key] = next[key];
    changed = true;
    lay(cell, item);
  }, () => { if (item[key] !== from) draftChanged(); });
}

// Shows a new item under the pointer while it is over the grid, and adds it where it is dropped.
function dragNew(begin, kind) {
  if (begin.button !== 0) return;
  const item = newItem(kind), ghost = el("div", { class: "item ghost" }, item.name), here = begin.currentTarget;
  let moved = false;
  trackPointer(begin, here, event => {
    const [column, row] = cellAt(event),
      next = { ...item, at: [Math.min(Math.max(column, 0), panelNow.columns - item.size[0]), Math.max(row, 0)] };
    moved ||= Math.hypot(event.clientX - begin.clientX, event.clientY - begin.clientY) > 6;
    const cells = at("panel").querySelector(".grid"),
      over = moved && document.elementsFromPoint(event.clientX, event.clientY).includes(cells);
    item.at = over && fits(next) ? next.at : over ? item.at : null;
    if (!item.at) return ghost.remove();
    if (!ghost.isConnected) cells.append(ghost);
    lay(ghost, item);
  }, () => { ghost.remove(); if (item.at) put(item); else if (!moved) add(kind); });
}

function trackPointer(begin, on, moved, ended) {
  on.setPointerCapture(begin.pointerId);
  const end = () => { on.onpointermove = on.onpointerup = on.onpointercancel = null; ended(); };
  Object.assign(on, { onpointermove: moved, onpointerup: end, onpointercancel: end });
}

// A new item of a kind with a free name and default fields; its position is null.
function newItem(kind) {
  const { title, size, needs } = panelNow.kinds[kind], word = title.split(" ").at(-1);
  let number = 1;
  while (draft.some(each => each.name === `${word} ${number}`)) number += 1;
  return {
    name: `${word} ${number}`,
    kind,
    tag: "",
    at: null,
    size: [...size],
    ...Object.fromEntries(needs.filter(key => key in DEFAULTS).map(key => [key, structuredClone(DEFAULTS[key])])),
  };
}

// Adds an item at the first free place.
function add(kind) {
  const item = newItem(kind);
  for (let place = 0; !item.at && place < 60 * panelNow.columns; place += 1) {
    const next = { ...item, at: [place % panelNow.columns, Math.floor(place / panelNow.columns)] };
    if (fits(next)) item.at = next.at;
  }
  if (item.at) put(item);
}

function put(item) {
  draft.push(item);
  bound.push({ read: "", type: "", broken: "" });
  chosen = item;
  draftChanged();
  form.querySelector("[name=tag]").focus();
}

function remove(item) {
  const place = draft.indexOf(item);
  draft.splice(place, 1);
  bound.splice(place, 1);
  chosen = null;
  draftChanged();
}

// Redraws the changed draft and asks the server what its items are bound to.
async function draftChanged() {
  changed = true;
  redraw();
  const check = lastCheck += 1, answer = await orders.order("panel", { items: draft });
  if (answer && check === lastCheck && node) bound = answer.bound, redraw();
}

// Fills the form with the fields of the chosen item. They are kept as long as the item is chosen: the user may type.
function fillForm() {
  setText(errorText, bound[draft.indexOf(chosen)]?.broken ?? "");
  if (itemInForm === chosen) return;
  itemInForm = chosen;
  form.setAttribute("aria-label", chosen ? `Fields of ${chosen.name}` : "Fields");
  if (!chosen)
    return form.replaceChildren(
      el(
        "span",
        { class: "soft" },
        "Drag a kind onto the grid, or select an item: arrows move it, Shift and arrows resize it, Delete removes it."
      )
    );
  const { needs, may } = panelNow.kinds[chosen.kind], item = chosen;
  form.replaceChildren(
    ...[...needs, ...may]
      .filter(key => key !== "kind")
      .map(key => el("label", { title: panelNow.allowed[key] }, key, field(item, key))),
    button("Remove item", () => remove(item), { text: "Remove" })
  );
}

function field(item, key) {
  const value = isList(key) ? (item[key] ?? []).join(", ") : (item[key] ?? ""),
    onChange = event => setField(item, key, event.target.value);
  if (key === "color")
    return el(
      "select",
      { name: key, change: onChange },
      ...["", ...panelNow.allowed.color.split(", ")].map(each =>
        el("option", { value: each, selected: each === value }, each || "none")
      )
    );
  return textField(null, { name: key, value, list: key === "tag" ? "tags" : null, change: onChange });
}

function setField(item, key, text) {
  const numberOf = each => each.trim() === "" || Number.isNaN(Number(each)) ? each.trim() : Number(each);
  const parts = text.split(",").map(each => each.trim()).filter(Boolean);
  const value =
    key === "positions" ? parts : key === "values" ? parts.map(numberOf) : isNumber(key) ? numberOf(text) : text.trim();
  if (text.trim() === "" && panelNow.kinds[item.kind].may.includes(key)) delete item[key];
  else item[key] = value;
  draftChanged();
}

async function save() {
  const saved = await orders.order("save_panel", { items: draft, base: panelNow.base });
  if (!saved) return;
  editor(null, view);
  view.take(saved);
  tell(`${saved.file} is saved.`, "news");
}
