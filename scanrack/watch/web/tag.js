// The card of the selected tag: its value, writing and forcing it, and why it has this value.

import { chainOf, clearChain } from "./chain.js";
import { toNext, toPrevious } from "./changes.js";
import { at, button, el, setFlag, setText, textButton, textField } from "./dom.js";
import { clock, clocked, count, parsed, plain, sentence, shown } from "./format.js";
import { declared, isPython, lacksBreak, lacksForce, lacksWrite } from "./lacks.js";
import { tell } from "./notice.js";
import * as orders from "./orders.js";
import { showRung } from "./program.js";
import { lookAt } from "./scrub.js";
import { onSelect, select, selected } from "./selection.js";
import { lastChange, wait } from "./since.js";
import { ask } from "./source.js";
import { onHello, onPaint, run } from "./state.js";
import { hasLane, toggleTag } from "./taglanes.js";
import { brief, treeOf } from "./tree.js";
import { addressOf, bindValue, isForced, unbindIn, valueOf } from "./values.js";
import { addToWatch, sendWatched } from "./watchtable.js";
import { answersTo } from "./wanting.js";
import { bitAt, named, nameOf } from "./words.js";

const SINCE_MS = 500; // between two questions about the latest change
const TRIES = 10, AGAIN_MS = 300; // how often an answer that is being computed is requested, and the wait between
const LATE_MS = 300; // after this time the page says that it waits for an answer

const name = el("strong", { class: "name" });
const type = el("span", { class: "soft" });
const says = el("p", { class: "says" });
const entry = textField("New value", { keydown: event => { if (event.key === "Enter") write(); } });
const forceButton = button("Force", () => forceSelected(true));
const unforceButton = button("Remove force", () => orders.unforce(selected.tag));
const writeButton = button("Write", write);
const breakButton = button("Breakpoint", () => orders.breakpoint(selected.tag), {
  title: "Pause in the scan in which the tag changes",
});
const whyButton = button("Why", why, { title: "Why the tag is as it is" });
const wantButton = button("What would it take", want, {
  title: "What the owner could do to give the tag its other level, or the typed value",
});
const usesButton = button("Uses", uses, { title: "Where the tag is read and written" });
const watchButton = button("Watch", () => addToWatch(selected.tag), { title: "Into the watch table" });
const stripButton = button(
  "Strip",
  () => {
    toggleTag(selected.tag);
    paintForced();
  },
  { title: "Into the timing strip, or out of it", "aria-pressed": "false" }
);
const closeButton = button("Deselect", () => select({}), { text: "✕", title: "Select nothing (Esc)", class: "sign" });
const previousButton = button("Previous change", () => toPrevious(selected.tag), {
  text: "◀",
  title: "Look at its previous change (p)",
  class: "sign",
});
const nextButton = button("Next change", () => toNext(selected.tag), {
  text: "▶",
  title: "Look at its next change (n)",
  class: "sign",
});
const own = el("span", {}), parts = el("div", { class: "parts" });
const since = el("p", { class: "since" });
const answer = el("div", { class: "answer", "aria-live": "polite" });
const HINTS = new Map([writeButton, forceButton, breakButton].map(each => [each, each.title]));
// the latest question, and the latest one with an answer: tag, value and scan
let latestQuestion = "", answeredQuestion = "", isAsking = false;
let answered = null; // the tag whose answer is shown
const head = el(
  "div",
  { class: "head" },
  el("div", { class: "line" }, name, type, own, el("span", { class: "ways" }, previousButton, nextButton, closeButton)),
  el("div", { class: "line" }, whyButton, wantButton, usesButton, watchButton, stripButton, breakButton)
);
const card = el(
  "div",
  { class: "tag" },
  head,
  says,
  parts,
  since,
  el("div", { class: "line write" }, entry, writeButton, forceButton, unforceButton),
  answer
);

onHello(() => {
  at("tag").replaceChildren(el("h2", { class: "hidden" }, "Tag"), card);
  setFlag(at("tag"), "data-selected", Boolean(selected.tag));
  if (selected.tag) show(selected);
});

onSelect(show);

function show({ tag, names }) {
  setFlag(at("tag"), "data-selected", Boolean(tag));
  if (!tag) return;
  const known = declared(tag) ?? {};
  setText(name, nameOf(tag));
  setText(type, known.type ?? "");
  setText(says, known.description || meaningOf(tag));
  unbindIn(card);
  own.replaceChildren(el("output", { class: "figure" }, "–"));
  bindValue(own.firstChild, tag, brief(shown));
  parts.replaceChildren(treeOf(tag), ...[...new Set(names)].filter(each => each !== tag).map(part));
  if (tag !== answered) answer.replaceChildren(), clearChain();
  answered = tag;
  entry.value = "";
  enableButtons(tag);
  entry.placeholder = known.type === "BOOL" ? "0 or 1" : "value, 16#, 2#";
  sendWatched(names).then(() => { if (tag === selected.tag) enableButtons(tag), paintForced(); });
  paintForced();
  setText(since, "");
  latestQuestion = "";
  askSince();
  at("tag").scrollIntoView({ block: "nearest" });
}

// Asks since when the tag has its value; again when the value changes, or another scan of the past is shown.
async function askSince() {
  const question = questionNow(), { tag } = selected;
  if (!tag || question === latestQuestion || isAsking) return;
  latestQuestion = question;
  isAsking = true;
  try {
    const reported = await lastChange(
      tag,
      () => question === questionNow(),
      from => setText(since, `It has not changed since scan ${count(from)}; earlier scans are being searched …`)
    );
    if (reported !== undefined) showSince(reported), answeredQuestion = question;
  } catch { if (tag === selected.tag) setText(since, ""); }
  setTimeout(() => { isAsking = false; askSince(); }, SINCE_MS);
}

const questionNow = () =>
  `${selected.tag} ${plain(valueOf(selected.tag))} ${run.state === "past" ? run.scan : run.state}`;

function showSince(reported) {
  if (!reported) return setText(since, "It has not changed in any scan up to here.");
  const { before } = reported,
    simple = before === null || typeof before === "object" ? "" : `, before that ${shown(before)}`;
  since.replaceChildren(
    "Since ",
    textButton(
      reported.t === null ? `scan ${count(reported.scan)}` : clock(reported.t),
      () => lookAt(reported.scan),
      `Look at scan ${reported.scan}`
    ),
    simple
  );
}

// The address of a bit of an image, with the section of the manual.
function meaningOf(tag) {
  const bit = bitAt(addressOf(tag));
  return bit ? [bit.address, bit.section].filter(Boolean).join(", ") : "";
}

// Disables the buttons that cannot be used with a tag; their tooltips say why.
function enableButtons(tag) {
  const lacks = [
    [writeButton, lacksWrite({ tag })],
    [forceButton, lacksForce({ tag })],
    [breakButton, lacksBreak({ tag })],
  ];
  for (const [button, lack] of lacks) {
    button.disabled = Boolean(lack);
    button.title = lack ? `${button.getAttribute("aria-label")}: ${lack}` : HINTS.get(button);
  }
  entry.disabled = forceButton.disabled;
  usesButton.disabled = isPython();
  setFlag(wantButton, "hidden", Boolean(run.hello.shared));
}

function part(tag) {
  const value = el("output", { class: "figure" }, "–");
  bindValue(value, tag, brief(shown));
  const line = el(
    "div",
    { class: "part" },
    textButton(nameOf(tag), () => select({ ...selected, tag, names: [tag] })),
    value
  );
  return el("div", {}, line, treeOf(tag));
}

function typed() {
  const value = parsed(
    entry.value,
    declared(selected.tag)?.type ?? (typeof valueOf(selected.tag) === "boolean" ? "BOOL" : "")
  );
  if (value === undefined)
    tell(
      entry.value ? `${entry.value} is not a value for ${selected.tag}.` : `Type a value for ${selected.tag} first.`
    );
  return value;
}

async function write() {
  const value = selected.tag ? typed() : undefined;
  if (value !== undefined) await orders.write(selected.tag, value);
}

// The typed value; without one the other level of a BOOL.
function newValue(tag) {
  const present = valueOf(tag);
  return entry.value.trim() || typeof present !== "boolean" ? typed() : !present;
}

// Forces the selected tag to the new value. Key f also removes a force; `only` does not.
export async function forceSelected(only = false) {
  const { tag } = selected;
  if (!tag) return tell("Select a tag first: click a contact.");
  if (only !== true && isForced(tag)) return orders.unforce(tag);
  const value = newValue(tag);
  if (value !== undefined) await orders.force(tag, value);
}

export function why() {
  showWhy(selected.tag);
}

// Selects a tag and shows why it has its value. Calls then(links, text) with the chain of causes.
export async function explain(tag, then) {
  select({ tag });
  const reply = await showWhy(tag, TRIES);
  if (reply) then(reply.chain ?? [], reply.text);
}

// Asks why a tag has its value, and shows the answer. Returns it, or null.
async function showWhy(tag, tries = 1) {
  const late = setTimeout(
    () => answer.replaceChildren(el("p", { class: "soft" }, "The program runs again up to this scan …")),
    LATE_MS
  );
  let refusal = "";
  const reply = await askWhy({ tag }, () => tag === selected.tag, tries).catch(({ message }) => { refusal = message; });
  clearTimeout(late);
  if (tag !== selected.tag) return null;
  if (!reply) return answer.replaceChildren(refusal && el("p", { class: "refused" }, sentence(refusal))), null;
  // a longer chain shows the rest
  const lines = linesOf(reply), text = reply.chain?.length > 1 ? reply.text.split("\n")[0] : reply.text;
  const when = textButton(`In scan ${count(reply.scan)}:`, () => lookAt(reply.scan), "Look at this scan");
  answer.replaceChildren(
    when,
    el("p", {}, text),
    lines.length ? el("div", { class: "line" }, ...lines.map(toLine)) : "",
    chainOf(reply.chain)
  );
  showAnswer();
  return reply;
}

// Asks why; the answer has names of words and bits in place of addresses. Returns null if it is no longer requested.
export async function askWhy(fields, requested, tries = TRIES) {
  const reply = await askAgain(fields, requested, tries);
  return (
    reply && {
      ...reply,
      text: clocked(named(reply.text)),
      chain: reply.chain?.map(link => ({ ...link, text: clocked(named(link.text)) })),
    }
  );
}

// Repeats the question while the scan is being computed, as long as the answer is requested.
async function askAgain(fields, requested, tries) {
  while (--tries > 0 && !isPython()) {
    try {
      return await ask("why", fields);
    } catch {
      await wait(AGAIN_MS);
      if (!requested()) return null;
    }
  }
  return ask("why", fields);
}

// Scrolls an answer that does not fit to the top of the card, below the part that stays: no row is cut.
function showAnswer() {
  const box = at("tag"), { offsetHeight: high } = getComputedStyle(head).display === "block" ? head : head.firstChild;
  answer.style.minHeight = "";
  if (box.scrollHeight <= box.clientHeight) return;
  answer.style.minHeight = `${box.clientHeight - high}px`;
  box.scrollTop += answer.getBoundingClientRect().top - box.getBoundingClientRect().top - high;
}

// The lines of the Python program that an answer names.
function linesOf({ lines = [] }) {
  const names = (run.hello.routines ?? []).map(each => each.name);
  return lines.filter(({ file }) => names.includes(file)).map(({ file, line }) => `${file}.${line}`);
}

const toLine = place => {
  const [, number] = /\.(\d+)$/.exec(place);
  return el("button", { type: "button", click: () => showRung(place) }, `Line ${number}`);
};

export async function want() {
  const { tag } = selected, value = newValue(tag);
  if (value === undefined) return;
  answer.replaceChildren(el("p", { class: "soft" }, "Copies of the rack try it …"));
  const found = await answersTo(tag, value);
  if (tag !== selected.tag) return;
  answer.replaceChildren(...found);
  showAnswer();
}

export async function uses() {
  const tag = selected.tag, reply = await orders.order("xref", { tag });
  if (reply && tag === selected.tag) answer.replaceChildren(el("ul", {}, ...(reply.hits ?? []).map(hit)));
}

const hit = ({ text, rung }) =>
  el(
    "li",
    {},
    rung ? textButton(rung, () => showRung(rung)) : "",
    el("span", {}, ` ${text}`)
  );

function paintForced() {
  const forced = Boolean(selected.tag) && isForced(selected.tag);
  setFlag(card, "data-forced", forced);
  unforceButton.disabled = !forced || !orders.allowed();
  const stops = run.breakpoints.includes(selected.tag);
  breakButton.setAttribute("aria-pressed", String(stops));
  stripButton.setAttribute("aria-pressed", String(Boolean(selected.tag) && hasLane(selected.tag)));
}

onPaint(changes => {
  nextButton.disabled = run.state !== "past";
  if (changes.forced || changes.breakpoints) paintForced();
  if (!selected.tag || !(changes.tags || changes.words || changes.scan !== undefined)) return;
  setFlag(since, "data-old", answeredQuestion && answeredQuestion !== questionNow());
  askSince();
});
