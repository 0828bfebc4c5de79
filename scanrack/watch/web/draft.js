// The draft of an edit: texts that replace rungs of the running program, and new tags. The page keeps it, and the
// server checks, accepts, tests and assembles it. Every change can be undone.

import { el, setText } from "./dom.js";
import { count, many } from "./format.js";
import { keep, kept as keptOf } from "./kept.js";
import { tell } from "./notice.js";
import * as orders from "./orders.js";
import { ask } from "./source.js";
import { onHello, run } from "./state.js";

const WOULD_MS = 700; // a draft is tried on the latest scans if it has not changed for this time

const NOTHING = { stage: "", base: "", unsaved: false, edit: "", of: "", by: "", rungs: [], tags: [] };

// `base` is the edited program. `own`: the draft is of this page, and not the accepted edit of another page.
// `moved`: its rungs have other numbers now.
export const draft = {
  rungs: new Map(),
  tags: [],
  base: "",
  own: false,
  moved: false,
  right: false,
  words: null,
  checked: new Map(),
  missing: [],
  mistakes: [],
};
// The latest state from the session: the stage, the running program, and the accepted edit with its original program
// and its page.
export const session = { ...NOTHING };
export const verdict = el("p", { class: "verdict", role: "status" });
export const would = el("div", { class: "would", "aria-live": "polite" });
const watchers = [], ours = new Set(); // ours: edits that this page has accepted
let accepting = false; // whether the answer to an accept step is pending
let done = [], undone = [], queried = 0, timer = 0, extra = null, columns = 88, ordering = 0;

export const onDraft = visit => { watchers.push(visit); };
function changed() {
  save();
  for (const watch of watchers) watch();
}

export const keyOf = (routine, rung) => `${routine}\n${rung}`;
const rungsOf = map =>
  [...map].map(([key, texts]) => {
    const [routine, rung] = key.split("\n");
    return [routine, Number(rung), texts];
  });
const mapOf = rungs => new Map(rungs.map(([routine, rung, texts]) => [keyOf(routine, rung), [...texts]]));
const fields = () => ({ base: draft.base, rungs: rungsOf(draft.rungs), tags: draft.tags });
export const isLocked = () => session.stage === "testing";
export const isAccepted = () =>
  session.edit !== "" &&
  JSON.stringify([rungsOf(draft.rungs), draft.tags]) === JSON.stringify([session.rungs, session.tags]);
export const canUndo = () => done.length > 0;
export const canRedo = () => undone.length > 0;

// The tab keeps the draft for a reload.
const tab = () => sessionStorage;
const save = () =>
  run.hello && keep("draft", draft.own && draft.rungs.size ? { ...fields(), ours: [...ours] } : {}, tab);

// Restores the draft from before a reload of this tab; returns whether there was one.
function restored() {
  const { base, rungs, tags, ours: mine } = keptOf("draft", {}, tab);
  if (draft.own || !rungs?.length || !orders.allowed()) return false;
  Object.assign(draft, { rungs: mapOf(rungs), tags, base, own: true });
  for (const edit of mine) ours.add(edit);
  return true;
}

// Begins to edit; throws the reason if the program's rungs can't be edited.
export async function begin() {
  draft.words = await ask("words");
  session.base ||= draft.words.base;
  if (!draft.own) follow();
  check();
}

const kept = () => structuredClone({ rungs: draft.rungs, tags: draft.tags, base: draft.base });

// Shows the accepted edit, or nothing, in place of a draft.
function follow() {
  const { rungs, tags, of } = ["accepted", "testing"].includes(session.stage)
    ? session
    : { ...NOTHING, of: session.base };
  Object.assign(draft, { rungs: mapOf(rungs), tags: [...tags], base: of, own: false });
}

// Changes the draft; `make` gets a map of texts by key, which it changes.
export function change(make, { tags = draft.tags } = {}) {
  if (isLocked()) return tell("The edit is in test: untest it to change it.");
  const before = kept(), rungs = structuredClone(draft.rungs);
  make(rungs);
  const text = [...rungs.values()].flat().join(" ");
  Object.assign(draft, {
    rungs,
    own: true,
    tags: tags.filter(([name]) => new RegExp(`(?<!\\w)${name}(?!\\w)`, "i").test(text)),
  });
  const after = kept();
  remember({ undo: () => restore(before), redo: () => restore(after) });
  check();
}

function restore(state) {
  if (isLocked()) return tell("The edit is in test: untest it to change it."), null;
  Object.assign(draft, structuredClone(state), { own: true });
  return check();
}

function remember(entry) {
  done.push(entry);
  undone = [];
}

export const undo = () => repeat("undo", done, undone);
export const redo = () => repeat("redo", undone, done);

// Undoes or redoes an entry. A refused one, false, is dropped; one that must wait, null, stays.
async function repeat(method, from, to) {
  const entry = from.pop(), taken = entry && await entry[method]();
  if (entry && taken !== false) (taken === null ? from : to).push(entry);
  changed();
}

// Also requests the drawing of a rung that is not changed, for its elements.
export function look(key, text) {
  extra = !key || draft.rungs.has(key) ? null : [key, [text]];
  return check();
}

export const setColumns = now => { columns = now; };

// Checks the draft. Shows at once that the old verdict is outdated, and moves a draft for an earlier program to the
// running one.
async function check() {
  const mine = ++queried;
  clearTimeout(timer);
  would.replaceChildren();
  if (isLocked()) { said(draft); return changed(); }
  if (draft.base !== session.base && !await rebase(mine)) return;
  if (draft.rungs.size) say("busy", "It is being checked.");
  changed();
  const rungs = rungsOf(extra && !draft.rungs.has(extra[0]) ? new Map([...draft.rungs, extra]) : draft.rungs);
  if (!rungs.length) { draft.checked = new Map(); said({ mistakes: [], missing: [], right: false }); return changed(); }
  let answer;
  try {
    answer = await ask("rungs", { ...fields(), rungs, columns });
  } catch (refused) {
    if (mine === queried) say("mistake", refused.message);
    return;
  }
  if (mine !== queried) return;
  const isDeclared = tag => draft.tags.some(([name, , program]) => name === tag.name && program === tag.program);
  const unambiguous = answer.missing.filter(tag => tag.types.length === 1 && !isDeclared(tag));
  take(answer);
  if (unambiguous.length) { // the use of a tag decides its type
    draft.tags = [...draft.tags, ...unambiguous.map(tag => [tag.name, tag.types[0], tag.program])];
    return check();
  }
  said(answer);
  changed();
  if (answer.right && draft.rungs.size) timer = setTimeout(tryOn, WOULD_MS);
}

async function rebase(mine) {
  let reported = "Another program runs now", moved = { rungs: [], tags: [], base: session.base };
  try {
    if (draft.rungs.size) moved = await ask("rebase", fields());
    reported += moved.rungs.length ? ": your edit is kept." : " that already has your edit.";
    const changed = moved.conflicts === 1 ? "One of its rungs was" : `${moved.conflicts} of its rungs were`;
    if (moved.conflicts) reported += ` ${changed} also changed there.`;
  } catch (refused) {
    if (mine === queried && !refused.lost)
      say(
        "mistake",
        `Another program runs now, and your edit can't be moved to it: ${refused.message}. Cancel drops it.`
      );
    return false; // the next hello requests it again
  }
  if (mine !== queried) return false;
  if (draft.rungs.size) tell(reported, "news");
  const rungs = mapOf(moved.rungs), keys = map => [...map.keys()].join();
  Object.assign(draft, { rungs, tags: moved.tags, base: moved.base, moved: keys(rungs) !== keys(draft.rungs) });
  return true;
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

// Checks the draft again, since answers may be missing after a lost connection.
onHello(() => {
  if (draft.words) return check();
  if (!restored()) return;
  tell("Your draft from before the reload is shown.", "news");
  changed();
});

// Declares a missing tag with a type that the operator has chosen.
export function declare(name, type, program) {
  change(() => {}, { tags: [...draft.tags, [name, type, program]] });
}

function said({ mistakes, missing, right }) {
  Object.assign(draft, { right, mistakes, missing });
  const counted = [...draft.checked.values()].reduce((sum, each) => sum + each.mistakes.length, mistakes.length);
  const places = draft.rungs.size, edited = `${many(places, "place")} edited`, { stage, by } = session;
  const isShown = isLocked() || !places || isAccepted();
  const whose =
    !by || accepting || ours.has(session.edit)
      ? ""
      : draft.own && places
        ? ` The edit of ${by} is ${STAGES[stage][0]}, not this one.`
        : ` It is the edit of ${by}.`;
  if (stage && isShown) return say("good", STAGES[stage][1] + whose);
  if (!places) return say("", "Nothing is edited: click into a rung, or type at the caret.");
  if (missing.length && missing.every(({ types }) => types.length > 1))
    return say("mistake", `${edited}: choose the type of ${missing.map(({ name }) => name).join(", ")}.${whose}`);
  say(
    right ? "good" : "mistake",
    `${edited}, ${right ? "no mistake" : counted === 1 ? "a mistake" : many(counted, "mistake")}.${whose}`
  );
}

const STAGES = {
  accepted: ["accepted", "Accepted: it is loaded, and the old rungs run."],
  testing: ["in test", "Tested: the edited rungs run."],
  assembled: ["assembled", "Assembled: the edit is the program."],
};

function say(kind, text) {
  verdict.dataset.kind = kind;
  setText(verdict, text);
}

async function tryOn() {
  const mine = queried;
  would.replaceChildren(el("p", { class: "busy", role: "status" }, "Trying it on the last 10 s …"));
  let answer;
  try {
    answer = await ask("would", fields());
  } catch (refused) {
    answer = { refused: refused.message };
  }
  if (mine !== queried) return;
  if (answer.refused)
    return would.replaceChildren(el("p", { class: "soft" }, `Not tried on the last scans: ${answer.refused}.`));
  const { groups, more, scans } = answer;
  would.replaceChildren(
    el(
      "p",
      { class: "soft" },
      groups.length
        ? `In the last ${count(scans)} scans it would have changed:`
        : `In the last ${count(scans)} scans it would have changed no value.`
    ),
    el(
      "dl",
      { class: "resets" },
      ...groups.flatMap(({ name, members, scan, output }) => [
        el("dt", {}, name),
        el(
          "dd",
          {},
          [members.join(", "), output ? "an output" : "", `from scan ${count(scan)} on`]
            .filter(Boolean)
            .join("; ")
        ),
      ])
    ),
    more ? el("p", { class: "soft" }, `and ${more} more tags`) : ""
  );
}

const OPPOSITE = { accept: "cancel", test: "untest", untest: "test", assemble: "reopen" };

// Takes a step with the accepted edit; returns false if it was refused.
async function order(step, edit = session.edit) {
  ordering += 1;
  accepting = step === "accept";
  const state = await orders.order("online", {
    step,
    ...(accepting ? fields() : { base: step === "save" ? session.base : edit }),
  });
  if (accepting && state) ours.add(state.edit);
  accepting = false;
  ordering -= 1;
  if (state) heard(state);
  return Boolean(state);
}

// Drops the draft, or the accepted edit if it is shown or in test.
async function cancel() {
  const isShown = isAccepted(), isInTest = isLocked();
  if ((isShown || isInTest) && !await order("cancel")) return false;
  if (isShown || !isInTest) follow();
  return check();
}

export async function step(name) {
  if (name === "cancel") {
    const before = kept();
    if (await cancel() !== false) remember({ undo: () => restore(before), redo: cancel });
  } else {
    const { own } = draft;
    if (!await order(name)) return changed();
    const { edit } = session,
      back = async () => {
        const taken = await order(OPPOSITE[name], edit);
        draft.own ||= taken && own;
        return taken;
      };
    if (OPPOSITE[name]) remember({ undo: back, redo: () => order(name) });
    else { done = []; undone = []; } // saved changes can't be undone
  }
  changed();
}

// Takes the state that the session sends to all pages. A draft of this page stays.
export function heard(state) {
  const old = { ...session }, oldFields = JSON.stringify(fields()), wasMine = draft.own && isAccepted();
  const isGone = old.edit && !state.edit && ![old.of, old.edit].includes(state.base); // another program runs
  Object.assign(session, NOTHING, state);
  if (wasMine && !ordering && state.edit && state.edit !== old.edit)
    tell(`The edit of ${state.by} is accepted in place of yours, which is kept here.`, "news");
  if (wasMine && !ordering && !state.edit && !isGone)
    tell("Another page has canceled the accepted edit, which is kept here.", "news");
  if (isGone && !draft.own) Object.assign(draft, { rungs: mapOf(old.rungs), tags: old.tags, base: old.of, own: true });
  else if (!draft.own || !draft.rungs.size || (state.stage === "assembled" && isAccepted())) follow();
  const isChanged = oldFields !== JSON.stringify(fields()) || draft.base !== state.base;
  if (draft.words && (isChanged || old.stage === "testing")) return check();
  said(draft);
  changed();
}
