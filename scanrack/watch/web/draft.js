// The draft of an edit: the texts that stand in place of rungs of the running program, and new tags. It is kept
// here, checked by the server, and accepted, tested and assembled there. Every change can be undone.

import { el, setText } from "./dom.js";
import { count, many } from "./format.js";
import { keep, kept as keptOf } from "./kept.js";
import { tell } from "./notice.js";
import * as orders from "./orders.js";
import { ask } from "./source.js";
import { onHello, run } from "./state.js";

const WOULD_MS = 700; // a draft is tried on the last scans when nothing has been changed for so long

const NOTHING = { stage: "", base: "", unsaved: false, edit: "", of: "", by: "", rungs: [], tags: [] };

// `base` is the program that is edited; `own` says that the draft is this page's, not the accepted one of another;
// `moved` that its rungs have other numbers now.
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
// What the session has reported last: the stage, the program that runs, and the edit that is accepted, of which program
// and by whom.
export const session = { ...NOTHING };
export const verdict = el("p", { class: "verdict", role: "status" });
export const would = el("div", { class: "would", "aria-live": "polite" });
const watchers = [], ours = new Set(); // edits that were accepted here
let accepting = false; // an edit, whose name the answer brings
let done = [], undone = [], queried = 0, timer = 0, extra = null, columns = 88, ordering = 0;

export const onDraft = visit => { watchers.push(visit); };
function changed() {
  save();
  for (const each of watchers) each();
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

// A draft outlives a reload of its tab.
const tab = () => sessionStorage;
const save = () =>
  run.hello && keep("draft", draft.own && draft.rungs.size ? { ...fields(), ours: [...ours] } : {}, tab);

// Takes the draft that this tab had before it was loaded again; returns whether there was one.
function restored() {
  const { base, rungs, tags, ours: mine } = keptOf("draft", {}, tab);
  if (draft.own || !rungs?.length || !orders.allowed()) return false;
  Object.assign(draft, { rungs: mapOf(rungs), tags, base, own: true });
  for (const each of mine) ours.add(each);
  return true;
}

// Begins to edit; throws why the program's rungs are not edited.
export async function begin() {
  draft.words = await ask("words");
  session.base ||= draft.words.base;
  if (!draft.own) follow();
  check();
}

const kept = () => structuredClone({ rungs: draft.rungs, tags: draft.tags, base: draft.base });

// Shows what is accepted, if anything is, in place of a draft.
function follow() {
  const { rungs, tags, of } = ["accepted", "testing"].includes(session.stage)
    ? session
    : { ...NOTHING, of: session.base };
  Object.assign(draft, { rungs: mapOf(rungs), tags: [...tags], base: of, own: false });
}

// Changes the draft; `make` gets a map of texts by key, and may change it.
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

// One that is refused for good is gone; one that waits, null, stays where it is.
async function repeat(way, from, to) {
  const entry = from.pop(), taken = entry && await entry[way]();
  if (entry && taken !== false) (taken === null ? from : to).push(entry);
  changed();
}

// Also asks for the places of a rung that has not been changed.
export function look(key, text) {
  extra = !key || draft.rungs.has(key) ? null : [key, [text]];
  return check();
}

export const setColumns = now => { columns = now; };

// Says at once that the old verdict is none of the changed draft. One of an earlier program is moved to the one that
// runs.
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
  const one = answer.missing.filter(
    each =>
      each.types.length === 1 &&
      !draft.tags.some(([name, , program]) => name === each.name && program === each.program)
  );
  take(answer);
  if (one.length) { // of one type by its use: declared where it is typed
    draft.tags = [...draft.tags, ...one.map(each => [each.name, each.types[0], each.program])];
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
    reported += moved.rungs.length ? ": your edit is kept." : " that has your edit already.";
    const changed = moved.conflicts === 1 ? "One of its rungs was" : `${moved.conflicts} of its rungs were`;
    if (moved.conflicts) reported += ` ${changed} changed there, too.`;
  } catch (refused) {
    if (mine === queried && !refused.lost)
      say(
        "mistake",
        `Another program runs now, and your edit can't be moved to it: ${refused.message}. Cancel drops it.`
      );
    return false; // what was lost is requested again with the next hello
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

// What was typed while the connection was lost, or requested before that, has no answer yet.
onHello(() => {
  if (draft.words) return check();
  if (!restored()) return;
  tell("Your draft from before this tab was loaded again is shown.", "news");
  changed();
});

// Declares a missing tag whose type its use does not decide.
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
  if (!places) return say("", "Nothing is edited: click into a rung, or type where the caret is.");
  if (missing.length && missing.every(each => each.types.length > 1))
    return say("mistake", `${edited}: choose the type of ${missing.map(each => each.name).join(", ")}.${whose}`);
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
  would.replaceChildren(el("p", { class: "busy", role: "status" }, "Tried on the scans of the last 10 s …"));
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
        ? `In the last ${count(scans)} scans it would have made another:`
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
    more ? el("p", { class: "soft" }, `and ${more} further tags`) : ""
  );
}

const OPPOSITE = { accept: "cancel", test: "untest", untest: "test", assemble: "reopen" };

// Takes a step with the edit that is accepted; false if it was refused.
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

// Drops the draft, or the accepted edit if that is shown or in test.
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
    else { done = []; undone = []; } // saved: its changes are the program, and can't be taken back
  }
  changed();
}

// The state that the session tells all pages. What is typed here stays, whatever other pages do.
export function heard(now) {
  const was = { ...session }, before = JSON.stringify(fields()), wasMine = draft.own && isAccepted();
  const isGone = was.edit && !now.edit && ![was.of, was.edit].includes(now.base); // another program runs in its place
  Object.assign(session, NOTHING, now);
  if (wasMine && !ordering && now.edit && now.edit !== was.edit)
    tell(`The edit of ${now.by} is accepted in place of yours, which is kept here.`, "news");
  if (wasMine && !ordering && !now.edit && !isGone)
    tell("Another page has cancelled the accepted edit, which is kept here.", "news");
  if (isGone && !draft.own) Object.assign(draft, { rungs: mapOf(was.rungs), tags: was.tags, base: was.of, own: true });
  else if (!draft.own || !draft.rungs.size || (now.stage === "assembled" && isAccepted())) follow();
  if (draft.words && (before !== JSON.stringify(fields()) || draft.base !== now.base || was.stage === "testing"))
    return check();
  said(draft);
  changed();
}
