// The rungs of the routine, with edited rungs below them, as in Studio 5000: r is replaced, d deleted, e edited,
// i inserted. A place is { key, index }: the key of a running rung, and the index of a text that replaces it.

import { button, drawing, el, setFlag } from "./dom.js";
import { declare, draft, keyOf } from "./draft.js";
import { shown } from "./format.js";
import { bindValue, unbindIn } from "./values.js";

let sheet = null, routine = "", running = new Map(); // text of each running rung by key
// Rows of running rungs by key, and of edited rungs by key and index, since a large program has many.
let rows = new Map(), drafts = new Map();
let deleted = [];

// Takes the rungs of a routine after it has been drawn.
export function lay(node, name, rungs = []) {
  [sheet, routine] = [node, name];
  running = new Map(rungs.map(({ number, text }) => [keyOf(name, number), text]));
  rows = new Map();
  for (const row of node.querySelectorAll(".rungs > .row[data-at]")) {
    const key = keyOf(name, row.dataset.at.slice(row.dataset.at.lastIndexOf(".") + 1));
    Object.assign(row.dataset, { key, index: 0 });
    rows.set(key, row);
  }
  drafts = new Map();
}

export const runs = key => running.get(key);
export const lastKey = () => [...running.keys()].at(-1);
export const textsAt = key => [...(draft.rungs.get(key) ?? (running.has(key) ? [running.get(key)] : []))];
export const textOf = where =>
  where && (draft.rungs.get(where.key)?.[where.index] ?? (where.index === 0 ? running.get(where.key) : undefined));
export const checkedOf = where => draft.checked.get(`${where.key}\n${where.index}`);
export const rowAt = where =>
  drafts.get(`${where.key}\n${where.index}`) ??
  (where.index === 0 && !deleted.includes(where.key) ? rows.get(where.key) : undefined);

// Returns the place that is a number of rows from another one, or null.
export function neighborOf(where, by) {
  const all = [...sheet.querySelectorAll(".row[data-key]")].filter(
      row => row.classList.contains("draft") || !row.dataset.edited
    ),
    row = all[all.indexOf(rowAt(where)) + by];
  return row ? { key: row.dataset.key, index: Number(row.dataset.index) } : null;
}

// Draws the edited rungs of the routine, or removes them.
export function drawDrafts(isOpen) {
  for (const row of drafts.values()) {
    unbindIn(row);
    row.remove();
    if (rows.has(row.dataset.key)) delete rows.get(row.dataset.key).dataset.edited;
  }
  for (const key of deleted) delete rows.get(key)?.dataset.edited;
  drafts = new Map();
  deleted = [];
  const list = sheet.querySelector(".rungs");
  if (list && isOpen)
    for (const [key, texts] of draft.rungs) if (key.startsWith(`${routine}\n`)) rowsOf(list, key, texts);
}

function rowsOf(list, key, texts) {
  const own = rows.get(key);
  if (own && !texts.length) deleted.push(key);
  if (own) own.dataset.edited = !texts.length ? "d" : texts[0] === running.get(key) ? "" : "r";
  let previous = own;
  texts.forEach((text, index) => {
    if (own && index === 0 && text === running.get(key)) return;
    const row = rowOf(key, index, text, own && index === 0 ? "e" : "i");
    drafts.set(`${key}\n${index}`, row);
    previous ? previous.after(row) : list.prepend(row);
    previous = row;
  });
}

function rowOf(key, index, text, letter) {
  const checked = checkedOf({ key, index }), title = { e: "Edited", i: "Inserted" }[letter];
  const picture = checked?.svg ? drawing(checked.svg) : el("code", { class: "unread" }, text);
  if (checked?.svg) {
    picture.querySelectorAll("[data-name]").forEach(node => bindValue(node, node.dataset.name, shown));
    picture.querySelectorAll("[data-element]").forEach((group, number) =>
      setFlag(
        group,
        "data-mistake",
        checked.mistakes.some(({ element }) => element === number)
      )
    );
  }
  const notes = [
    ...(checked?.mistakes ?? []).filter(mistake => !isMissing(mistake)).map(mistake => noteOf(mistake.text, "mistake")),
    ...(checked?.warnings ?? []).map(warning => noteOf(warning.text, "finding")),
    ...tagNotes(text),
  ];
  return el(
    "li",
    { class: "row draft", "data-key": key, "data-index": index, "aria-label": `${title} rung` },
    el("span", { class: "letter", title }, letter),
    el("div", { class: "body" }, picture, ...notes)
  );
}

const isMissing = ({ text }) =>
  draft.missing.some(({ name }) => text.includes(`: no tag ${name} (`) || text.includes(`: no tag ${name};`));
const noteOf = (text, kind) => el("p", { class: "note", "data-kind": kind }, text);

// Returns notes about the new tags in a rung: choices of a type, and declared types.
function tagNotes(rungText) {
  const uses = name => new RegExp(`(?<!\\w)${name}(?!\\w)`, "i").test(rungText);
  const choices = draft.missing
    .filter(({ name, types }) => types.length > 1 && uses(name))
    .map(({ name, types, program }) =>
      el(
        "p",
        { class: "note asks", role: "group", "aria-label": `Type of ${name}` },
        `New tag ${name}: `,
        ...types.map(type => button(`${name} is a ${type}`, () => declare(name, type, program), { text: type }))
      )
    );
  const declared = draft.tags
    .filter(([name]) => uses(name))
    .map(([name, type]) => el("p", { class: "note new" }, `New tag ${name} : ${type}`));
  return [...choices, ...declared];
}
