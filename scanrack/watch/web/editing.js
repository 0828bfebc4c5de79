// Edits of the program: drawn rungs, a text that is typed here, or a saved file that waits. The page shows each edit
// before it is accepted: its differences, its mistakes with their lines, and the sequences that restart.

import { completing, matching } from "./completing.js";
import { button, el, setFlag, setText, textButton } from "./dom.js";
import * as draft from "./draft.js";
import { capital, many, sentence } from "./format.js";
import { hush, tell } from "./notice.js";
import { isClicked } from "./pointer.js";
import * as orders from "./orders.js";
import { begin, deleteRung, edit, newRung } from "./rungedit.js";
import { selected } from "./selection.js";
import { onHello, onProgram, run } from "./state.js";

const ROWS = 18; // lines of the field
const BYTES_MOST = 60000; // of a text as JSON
const KEYS_MS = 600; // a text is previewed if nothing has been typed for this time

export const editButton = button("Edit", open, { title: "Edit the program", hidden: true });

// --- drawn rungs

const STEPS = {
  // title, and whether the step is available
  accept: [
    "Check and load the edit; the running program continues",
    ({ right, rungs }, { stage }) => right && rungs.size > 0 && !draft.isAccepted() && stage !== "testing",
  ],
  test: ["Run the edited rungs", (_, { stage }) => stage === "accepted" && draft.isAccepted()],
  untest: ["Run the old rungs again", (_, { stage }) => stage === "testing"],
  assemble: [
    "Make the edit the program",
    (_, { stage }) => stage === "testing" || (stage === "accepted" && draft.isAccepted()),
  ],
  cancel: ["Drop the edit", ({ rungs }, { stage }) => rungs.size > 0 || stage === "accepted" || stage === "testing"],
  save: [
    "Write the program's file and keep a backup",
    (_, { stage, unsaved }) => unsaved && (stage === "" || stage === "assembled"),
  ],
};
const stepButtons = new Map(
  Object.entries(STEPS).map(([name, [title]]) => [
    name,
    button(`${capital(name)} edits`, () => draft.step(name), { text: capital(name), title }),
  ])
);
const undoButton = button("Undo", draft.undo, { text: "↶", title: "Undo (Ctrl+Z)", class: "sign" });
const redoButton = button("Redo", draft.redo, { text: "↷", title: "Redo (Ctrl+Y)", class: "sign" });
const others = el("div", { class: "soft" });
const hint = el(
  "p",
  { class: "soft hint" },
  "Type XIC Start and Enter to insert it after the selection; F2 replaces the selection. " +
    "Arrows move, [ makes a branch, the comma makes a leg, Shift selects, Enter makes a new rung."
);
const bar = el(
  "div",
  { id: "edit", class: "editing rungbar", role: "group", "aria-label": "Edit rungs", hidden: true, keydown: barKeyed },
  el(
    "div",
    { class: "line" },
    ...stepButtons.values(),
    undoButton,
    redoButton,
    button("New rung", newRung, { text: "+ Rung", title: "New rung (Enter)" }),
    button("Delete rung", deleteRung, { text: "− Rung", title: "Delete the rung (Ctrl+Delete)" }),
    button(
      "Text",
      () => {
        close();
        openText();
      },
      { title: "Edit the text of the file" }
    ),
    button("Close edit", close, { text: "Close", title: "Close the edit and keep it here" })
  ),
  draft.verdict,
  others,
  draft.would,
  hint
);

let pressed = null; // the button of the bar with the focus, even after it was disabled

draft.onDraft(() => {
  const { activeElement: focused } = document;
  if (focused !== document.body) pressed = bar.contains(focused) ? focused : null;
  for (const [name, node] of stepButtons) node.disabled = !STEPS[name][1](draft.draft, draft.session);
  undoButton.disabled = !draft.canUndo();
  redoButton.disabled = !draft.canRedo();
  setFlag(hint, "hidden", draft.draft.rungs.size > 0 || draft.session.stage !== "" || draft.would.hasChildNodes());
  others.replaceChildren(...draft.draft.mistakes.map(text => el("p", { class: "note", "data-kind": "mistake" }, text)));
  keepFocus();
  const hasEdit = draft.session.stage || (draft.draft.own && !draft.draft.words); // or a draft from before a reload
  if (hasEdit && bar.hidden && orders.allowed() && panel.hidden) resume();
});

// Moves the focus from a button that is disabled after a key press to the next one, since Firefox loses the focus.
function keepFocus() {
  if (!pressed?.disabled || isClicked(pressed) || ![pressed, document.body].includes(document.activeElement)) return;
  const all = [...bar.querySelectorAll("button")], at = all.indexOf(pressed);
  [...all.slice(at), ...all].find(({ disabled }) => !disabled).focus();
}

// Shows an edit that another page has accepted, or this page before a reload.
async function resume() {
  showBar(true);
  await draft.begin().catch(refused => tell(refused.message));
}

function barKeyed(event) {
  if (!(event.ctrlKey || event.metaKey) || !"zy".includes(event.key.toLowerCase())) return;
  event.preventDefault();
  event.key.toLowerCase() === "y" || event.shiftKey ? draft.redo() : draft.undo();
}

function showBar(on) {
  setFlag(bar, "hidden", !on);
  setFlag(editButton, "hidden", on || !orders.allowed());
  edit(on);
}

function close() {
  showBar(false);
  editButton.focus();
}

// Opens the editor of drawn rungs, or the text of another routine.
async function open() {
  const { routines } = run.hello,
    name = document.querySelector("#program [data-routine][aria-selected='true']")?.dataset.routine;
  if ((routines.find(routine => routine.name === name) ?? routines[0]).kind !== "ladder") return openText();
  const refused = await draft.begin().then(() => null, error => error.message);
  if (refused) return openText(sentence(refused));
  showBar(true);
  begin(selected.rung);
}

// --- text

const title = el("h3");
const marks = el("div", { class: "marks", "aria-hidden": "true" });
const field = el("textarea", {
  "aria-label": "Text of the program",
  rows: ROWS,
  spellcheck: "false",
  autocomplete: "off",
  wrap: "off",
  input: () => {
    words.show();
    typed();
  },
  keydown: keyed,
  scroll: paintMarks,
});
const shown = el("div", { class: "shown", "aria-live": "polite" });
const takeButton = button("Take over", () => take(), { title: "Run it from the next scan on" });
const restartButton = button("Take over with restart", () => take(restarts.join(",")), {
  title: "Run it and restart these sequences",
  hidden: true,
});
const backButton = button("Back", back, { title: "Keep the running program" });
const words = completing(field, offered);
const panel = el(
  "div",
  { class: "editing", role: "group", "aria-label": "Edit", hidden: true },
  title,
  el("div", { class: "page" }, marks, field),
  words.list,
  el("div", { class: "line" }, takeButton, restartButton, backButton),
  shown
);

export const editor = el("div", {}, bar, panel);

let base = null; // digest of the text before the edit; null for a saved file
let restarts = [], timer = 0, queried = 0, noted = [];

onHello(() => { if (base === null) back(); });
onProgram(hello => {
  const hasRoutines = hello.routines?.length > 0;
  setFlag(editButton, "hidden", !orders.allowed() || !hasRoutines || !bar.hidden || !panel.hidden);
});

async function openText(why = "") {
  const source = await orders.order("source");
  if (!source) return;
  if (why) tell(why, "news");
  if (source.lacks) return tell(`${why} ${sentence(source.lacks)} Or save the file, which runs at once.`.trim());
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
  setFlag(panel, "hidden", false);
  setFlag(editButton, "hidden", true);
}

// Shows the preview of a saved file; null if it equals the running program.
export function waits(preview) {
  if (!preview) { if (base === null) back(); return; }
  base = null;
  present(preview.file, false);
  show(preview);
}

// Closes the preview after the edit was accepted.
export function taken() {
  if (!panel.hidden) back();
}

function back() {
  base = null;
  clearTimeout(timer);
  queried++;
  setFlag(panel, "hidden", true);
  setFlag(editButton, "hidden", !orders.allowed());
  shown.replaceChildren();
}

function typed() {
  clearTimeout(timer);
  queried++;
  permit(false);
  shown.replaceChildren(el("p", { class: "verdict", "data-kind": "busy" }, "It is being checked."));
  noted = [];
  paintMarks();
  timer = setTimeout(preview, KEYS_MS);
}

// Shows mistakes also at their lines in the field.
function paintMarks() {
  const { lineHeight, paddingTop } = getComputedStyle(field), high = parseFloat(lineHeight);
  marks.replaceChildren(...noted.filter(note => note.line).map(({ kind, line, text }) => {
    const mark = el("div", { "data-kind": kind, "data-line": line }, text);
    mark.style.top = `${(line - 1) * high + parseFloat(paddingTop) + 1 - field.scrollTop}px`;
    return mark;
  }));
}

function offered(before) {
  const [, rest, word] = /^(.*?)([\w.:\\]*)$/s.exec(before);
  if (word.length < 2) return null;
  return {
    from: rest.length,
    found: matching(
      word,
      (run.hello.tags ?? []).map(({ name, type }) => ({ text: name.replace(/^\\[^.]+\./, ""), says: type }))
    ),
  };
}

// Tab moves to the next control; Escape leaves the field and keeps the edit.
function keyed(event) {
  event.stopPropagation();
  if (words.keyed(event)) return;
  if (event.key === "Escape") backButton.focus();
}

const isTooLong = () => new TextEncoder().encode(JSON.stringify(field.value)).length > BYTES_MOST;

async function preview() {
  if (isTooLong()) return tell(`The text is too long to edit here: at most ${BYTES_MOST} bytes.`);
  const mine = ++queried, text = field.value, answer = await orders.order("draft", { text, base });
  if (mine !== queried || !answer) return;
  show(answer.preview);
  const { mistakes, rows, file, groups } = answer.preview;
  if (mistakes.length || !rows.length || file.endsWith(".py")) return;
  const busy = el("p", { class: "busy", role: "status" }, "Searching for possible effects in any run …");
  shown.append(busy);
  const more = await orders.order("draft", { text, base, effects: true });
  if (mine !== queried) return;
  busy.remove();
  if (more) shown.append(groupsOf(more.preview.groups.slice(groups.length)));
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
  setFlag(restartButton, "hidden", !restart.length);
  restartButton.disabled = !on;
  setText(restartButton, `Take over, restart ${restart.join(", ")}`);
}

function show(preview) {
  permit(true, preview);
  const { mistakes, findings, rows, groups, keeps, more } = preview;
  const notes = [
    ...mistakes.map(mistake => ({ ...mistake, kind: "mistake" })),
    ...findings.map(finding => ({ ...finding, kind: "finding" })),
  ];
  noted = base === null ? [] : notes;
  paintMarks();
  const isAt = (note, row) =>
    row.text !== null &&
    (note.old ? row.old === note.old && (row.sign === "-" || row.sign === " ") : note.line && row.new === note.line);
  shown.replaceChildren(
    verdict(preview),
    ...notes.filter(note => !rows.some(row => isAt(note, row))).map(noteOf),
    rows.length
      ? el(
          "ol",
          { class: "diff", tabindex: "0", "aria-label": "Differences" },
          ...rows.flatMap(row => [rowOf(row), ...notes.filter(note => isAt(note, row)).map(noteOf)])
        )
      : "",
    more ? el("p", { class: "soft" }, `${more} more lines differ`) : "",
    keeps ? el("p", { class: "keeps" }, sentence(keeps)) : "",
    groupsOf(groups)
  );
}

const groupsOf = groups => groups.length ? el("dl", { class: "resets" }, ...groups.flatMap(groupOf)) : "";

function verdict({ mistakes, rows, restart }) {
  const count = mistakes.length;
  const text = restart.length
    ? `It can't continue as it is, but with ${restart.join(", ")} restarted.`
    : count
      ? `${count === 1 ? "A mistake" : many(count, "mistake")}: it can't be taken over.`
      : rows.length
        ? "It can be taken over."
        : "It is the program that runs.";
  return el("p", { class: "verdict", "data-kind": count ? "mistake" : "good" }, text);
}

const TITLES = {
  "of another type": "Restart, of another type", "changed": "Restart, or have another constant",
  "keep their value": "Keep their value, whatever the text says",
};

const titleOf = name => TITLES[name] ?? capital(name);

const groupOf = ({ title: name, names }) => [el("dt", {}, titleOf(name)), el("dd", {}, byTag(names).join(", "))];

// Groups the members of a tag: Fill (ACC, DN).
function byTag(names) {
  const tags = new Map();
  for (const name of names) {
    const [, tag, member] = /^((?:\\[^.]+\.)?\w+)\.([\w.[\]]+)$/.exec(name) ?? [name, name, ""];
    if (!tags.has(tag)) tags.set(tag, []);
    if (member) tags.get(tag).push(member);
  }
  return [...tags].map(([tag, members]) =>
    members.length > 1 ? `${tag} (${members.join(", ")})` : members.length ? `${tag}.${members[0]}` : tag
  );
}

function rowOf({ sign, old, new: number, text }) {
  if (text === null) return el("li", { class: "gap" }, "⋯");
  return el(
    "li",
    { "data-sign": sign, "data-old": old, "data-new": number },
    el("span", { class: "number" }, String(number ?? old)),
    el("span", { class: "sign" }, sign),
    el("code", {}, text || " ")
  );
}

function noteOf({ kind, line, old, text, rule }) {
  const where = line
    ? textButton(`Line ${line}`, () => toLine(line), `To line ${line}`)
    : old
      ? el("b", {}, `Line ${old} now`)
      : "";
  return el(
    "li",
    { class: "note", "data-kind": kind, "data-line": line ?? old ?? "" },
    where,
    ` ${rule ? `${rule}: ` : ""}${text}`
  );
}

// Moves the caret to a line of the field.
function toLine(line) {
  if (field.hidden) return;
  const lines = field.value.split("\n"), start = lines.slice(0, line - 1).join("\n").length + (line > 1 ? 1 : 0);
  field.focus();
  field.setSelectionRange(start, start + (lines[line - 1]?.length ?? 0));
  field.scrollTop = (line - ROWS / 2) * (field.scrollHeight / Math.max(lines.length, 1));
}
