// The draft of an edit: the texts that stand in place of rungs of the running program, and new tags. It is kept
// here, checked by the server, and accepted, tested and assembled there. Every change can be undone.

import { el, setText } from "./dom.js";
import { tell } from "./notice.js";
import * as orders from "./orders.js";
import { ask } from "./source.js";

const WOULD_MS = 700; // a draft is tried on the last scans when nothing has been changed for so long

// `base` is the program that is edited; `changed` says that the draft is not the one that was accepted.
export const draft = { rungs: new Map(), tags: [], base: "", stage: "", changed: true, right: false, unsaved: false, words: null, checked: new Map(), missing: [], mistakes: [] };
export const verdict = el("p", { class: "verdict", role: "status" });
export const would = el("div", { class: "would", "aria-live": "polite" });
const watchers = [];
let done = [], undone = [], asked = 0, timer = 0, extra = null, columns = 88;

export const onDraft = visit => { watchers.push(visit); };
const changed = () => { for (const each of watchers) each(); };

export const keyOf = (routine, rung) => `${routine}\n${rung}`;
const rungsOf = map => [...map].map(([key, texts]) => { const [routine, rung] = key.split("\n"); return [routine, Number(rung), texts]; });
export const isLocked = () => draft.stage === "testing";
export const canUndo = () => done.length > 0;
export const canRedo = () => undone.length > 0;

// Begins to edit; throws why the program's rungs are not edited.
export async function begin() {
  draft.words = await ask("words");
  if (!isLocked()) draft.base = draft.words.base;
  check();
}

export function end() {
  asked++;
  clearTimeout(timer);
  clear();
  done = [];
  undone = [];
  would.replaceChildren();
}

const clear = () => Object.assign(draft, { rungs: new Map(), tags: [], checked: new Map(), missing: [], changed: true });

const kept = () => ({ rungs: structuredClone(draft.rungs), tags: structuredClone(draft.tags) });

// Changes the draft; `make` gets a map of texts by key, and may change it.
export function change(make, { tags = draft.tags } = {}) {
  if (isLocked()) return tell("The edit is in test: untest it to change it.");
  const before = kept(), rungs = structuredClone(draft.rungs);
  make(rungs);
  const text = [...rungs.values()].flat().join(" ");
  Object.assign(draft, { rungs, tags: tags.filter(([name]) => new RegExp(`(?<!\\w)${name}(?!\\w)`, "i").test(text)) });
  const after = kept();
  remember({ undo: () => restore(before), redo: () => restore(after) });
  recheck();
}

function restore(state) {
  Object.assign(draft, structuredClone(state));
  return recheck();
}

export function remember(entry) {
  done.push(entry);
  undone = [];
}

export async function undo() {
  const entry = done.pop();
  if (entry && await entry.undo() !== false) undone.push(entry);
  changed();
}

export async function redo() {
  const entry = undone.pop();
  if (entry && await entry.redo() !== false) done.push(entry);
  changed();
}

function recheck() {
  draft.changed = true;
  return check();
}

// Also asks for the places of a rung that has not been changed.
export function look(key, text) {
  extra = !key || draft.rungs.has(key) ? null : [key, [text]];
  return check();
}

export const setColumns = now => { columns = now; };

// Says at once that the old verdict is none of the changed draft.
async function check() {
  const mine = ++asked;
  clearTimeout(timer);
  would.replaceChildren();
  if (draft.rungs.size) say("busy", "It is being checked.");
  changed();
  const rungs = rungsOf(extra && !draft.rungs.has(extra[0]) ? new Map([...draft.rungs, extra]) : draft.rungs);
  if (!rungs.length) { draft.checked = new Map(); said({ mistakes: [], missing: [], right: false }); return changed(); }
  let answer;
  try {
    answer = await ask("rungs", { base: draft.base, rungs, tags: draft.tags, columns });
  } catch (refused) {
    if (mine === asked) say("mistake", refused.message);
    return;
  }
  if (mine !== asked) return;
  const one = answer.missing.filter(each => each.types.length === 1 && !draft.tags.some(([name, , program]) => name === each.name && program === each.program));
  take(answer);
  if (one.length) { // of one type by its use: declared where it is typed
    draft.tags = [...draft.tags, ...one.map(each => [each.name, each.types[0], each.program])];
    return check();
  }
  said(answer);
  changed();
  if (answer.right && draft.rungs.size) timer = setTimeout(tryOn, WOULD_MS);
}

function take({ rungs }) {
  const counts = new Map();
  draft.checked = new Map();
  for (const each of rungs) {
    const key = keyOf(each.routine, each.rung), index = counts.get(key) ?? 0;
    counts.set(key, index + 1);
    draft.checked.set(`${key}\n${index}`, each);
    const texts = draft.rungs.get(key);
    if (texts && each.svg) texts[index] = each.text;
  }
}

// Declares a missing tag whose type its use does not decide.
export function declare(name, type, program) {
  change(() => {}, { tags: [...draft.tags, [name, type, program]] });
}

function said({ mistakes, missing, right }) {
  Object.assign(draft, { right, mistakes, missing });
  const counted = [...draft.checked.values()].reduce((sum, each) => sum + each.mistakes.length, mistakes.length);
  const count = draft.rungs.size, edited = `${count} ${count === 1 ? "place" : "places"} edited`;
  const shown = count && draft.changed && !isLocked() ? null : STAGES[draft.stage];
  if (shown) return say("good", shown);
  if (!count) return say("", "Nothing is edited: click into a rung, or type where the caret is.");
  if (missing.length && missing.every(each => each.types.length > 1)) return say("mistake", `${edited}: choose the type of ${missing.map(each => each.name).join(", ")}.`);
  say(right ? "good" : "mistake", right ? `${edited}, no mistake.` : `${edited}, ${counted === 1 ? "a mistake" : `${counted} mistakes`}.`);
}

const STAGES = {
  accepted: "Accepted: it is loaded, and the old rungs run.",
  testing: "Tested: the edited rungs run.",
  assembled: "Assembled: the edit is the program.",
};

function say(kind, text) {
  verdict.dataset.kind = kind;
  setText(verdict, text);
}

async function tryOn() {
  const mine = asked;
  would.replaceChildren(el("p", { class: "busy", role: "status" }, "Tried on the scans of the last 10 s …"));
  let answer;
  try {
    answer = await ask("would", { base: draft.base, rungs: rungsOf(draft.rungs), tags: draft.tags });
  } catch (refused) {
    answer = { refused: refused.message };
  }
  if (mine !== asked) return;
  if (answer.refused) return would.replaceChildren(el("p", { class: "soft" }, `Not tried on the last scans: ${answer.refused}.`));
  const { groups, more, scans } = answer, count = scans.toLocaleString("en-US");
  would.replaceChildren(el("p", { class: "soft" }, groups.length ? `In the last ${count} scans it would have made another:` : `In the last ${count} scans it would have changed no value.`),
    el("dl", { class: "resets" }, ...groups.flatMap(({ name, members, scan, output }) => [el("dt", {}, name), el("dd", {}, [members.join(", "), output ? "an output" : "", `from scan ${scan.toLocaleString("en-US")} on`].filter(Boolean).join("; "))])),
    more ? el("p", { class: "soft" }, `and ${more} further tags`) : "");
}

// A step of the edit: false if it was refused.
async function order(step, fields = {}) {
  const state = await orders.order("online", { step, ...fields });
  if (!state) return false;
  heard(state);
  return true;
}

const OPPOSITE = { test: "untest", untest: "test", assemble: "reopen" };

export async function step(name) {
  if (name === "accept") {
    const fields = { base: draft.base, rungs: rungsOf(draft.rungs), tags: draft.tags }, accept = async () => {
      const taken = await order("accept", fields);
      draft.changed = !taken || JSON.stringify([rungsOf(draft.rungs), draft.tags]) !== JSON.stringify([fields.rungs, fields.tags]); // typed on meanwhile
      if (taken) heard(draft);
      return taken;
    };
    if (await accept()) remember({ undo: recheck, redo: accept });
  } else if (name === "cancel") {
    const before = kept(), drop = async () => {
      if (["accepted", "testing"].includes(draft.stage) && !await order("cancel")) return false;
      clear();
      return check();
    };
    if (await drop() !== false) remember({ undo: () => restore(before), redo: drop });
  } else {
    const before = kept(), back = async () => {
      if (name === "assemble") Object.assign(draft, structuredClone(before), { changed: false });
      return order(OPPOSITE[name]);
    };
    if (await order(name)) {
      if (OPPOSITE[name]) remember({ undo: back, redo: () => order(name) });
      else { done = []; undone = []; } // saved: its changes are the program, and can't be taken back
    }
  }
  changed();
}

// The state that the session tells all pages.
export function heard({ stage, base, unsaved }) {
  const elsewhere = draft.base && base !== draft.base && (stage === "" || (stage === "assembled" && draft.changed));
  if (elsewhere && draft.rungs.size) tell("Another program runs now: the edit of the one before is dropped.");
  if (elsewhere) end();
  else if (stage === "assembled" && draft.stage !== stage) clear();
  if (stage !== "testing") draft.base = base;
  Object.assign(draft, { stage, unsaved });
  said(draft);
  changed();
}
