// What can be done with a tag or a rung, by menu and by key: a row each, with the reason why it can't be done now.

import * as orders from "./orders.js";
import { showPanel } from "./layout.js";
import { select } from "./selection.js";
import { run } from "./state.js";
import { MOST, hasLane, tagNames, toggleTag } from "./taglanes.js";
import { isPython, uses, want, why } from "./tag.js";
import { addressOf, isForced, valueOf } from "./values.js";
import { addToWatch, isWatched } from "./watchtable.js";

export const declared = tag => run.hello?.tags?.find(each => each.name.toUpperCase() === tag.toUpperCase());

const IMAGE = /^(Local:\d+:|[IO]:)/i;
const isImage = tag => IMAGE.test(addressOf(tag));
const isInput = tag => /^(Local:\d+:I|I:)/i.test(addressOf(tag));
const isBool = tag => typeof valueOf(tag) === "boolean" || declared(tag)?.type === "BOOL" || /^Local:.*\.\d+$|^[IO]:.*\/\d+$/i.test(addressOf(tag));

// Reasons; "" for none.
const closed = () => (orders.allowed() ? "" : orders.recorded() ? "a recording takes no orders" : "this page is read-only");
const untimed = () => closed() || (orders.timed() ? "" : "a real controller does not wait");
const past = () => (run.state === "past" ? "a scan of the past is shown: Live first" : "");
const notBool = ({ tag }) => (isBool(tag) ? "" : "not a BOOL");
const notSingle = ({ tag }) => (typeof valueOf(tag) === "object" && valueOf(tag) !== null ? "it has members: take one of them" : "");
const unwritable = ({ tag }) => {
  if (isInput(tag)) return "an input of a module: press it at the machine, or force it";
  if (isImage(tag)) return "an output image, which every scan writes: force it";
  return (declared(tag)?.writable ?? run.hello.settable) ? "" : "it can't be set";
};
const unforceable = subject => (isImage(subject.tag) ? "" : unwritable(subject));
const python = () => (isPython() ? "the program is in Python: it has no rungs" : "");
const full = ({ tag }) => (tagNames().length >= MOST && !hasLane(tag) ? `the strip has room for ${MOST} tags` : "");

const first = (...checks) => subject => checks.reduce((found, check) => found || check(subject), "");

export const lacksWrite = first(closed, unwritable), lacksForce = first(closed, unforceable);
export const lacksBreak = first(untimed, ({ tag }) => (isImage(tag) ? "" : python()));

// What a breakpoint on a rung waits for: the end of its place, and words.
/** @type {[string, string, string][]} */
export const WAITS = [["", "true", "is true"], [" changes", "changes", "changes"], [" executes", "executes", "executes"]];
export const breakpointsAt = (ident, list = run.breakpoints) => WAITS.filter(([end]) => list.includes(ident + end));

const unitOf = rung => (run.hello.routines.find(each => rung.startsWith(`${each.name}.`))?.kind === "ladder" ? "rung" : "line");
const onTag = (key, text, says, lacks, act, more) => ({ key, text: () => text, says, lacks, act, of: "tag", ...more });
const onRung = (key, [end, , words]) => ({
  key, of: "rung", text: ({ rung }) => `Break when ${unitOf(rung)} ${rung.split(".").at(-1)} ${words}`, says: `breakpoint: when the rung ${words}`, lacks: first(untimed, python),
  checked: ({ rung }) => run.breakpoints.includes(rung + end), act: ({ rung }) => orders.breakpoint(rung + end),
});

export const ACTIONS = [
  onTag("t", "Toggle", "toggle the tag", first(closed, past, notBool, unwritable), ({ tag }) => orders.write(tag, !valueOf(tag))),
  onTag("1", "Force on", "force it on", first(notBool, lacksForce), ({ tag }) => orders.force(tag, true)),
  onTag("0", "Force off", "force it off", first(notBool, lacksForce), ({ tag }) => orders.force(tag, false)),
  onTag("r", "Remove force", "remove its force", first(closed, ({ tag }) => (isForced(tag) ? "" : "it is not forced")), ({ tag }) => orders.unforce(tag)),
  onTag("w", "Why", "why it is as it is", () => "", ({ tag, names }) => { select({ tag, names: [...new Set([tag, ...names])] }); why(); }),
  onTag("g", "What would it take", "what it would take to have its other level", first(() => (run.hello.shared ? "a shared page runs nothing" : ""), notBool), ({ tag }) => { select({ tag }); want(); }),
  onTag("u", "Uses", "where it is used", python, ({ tag }) => { select({ tag }); uses(); }),
  onTag("l", "Lane in the strip", "a lane in the strip", first(notSingle, full), ({ tag }) => toggleTag(tag), { checked: ({ tag }) => hasLane(tag) }),
  onTag("a", "Into the watch table", "into the watch table", ({ tag }) => (isWatched(tag) ? "it is there" : ""), ({ tag }) => { addToWatch(tag); showPanel("watch"); }),
  onTag("k", "Break when it changes", "breakpoint: when it changes", lacksBreak, ({ tag }) => orders.breakpoint(tag), { checked: ({ tag }) => run.breakpoints.includes(tag) }),
  ...WAITS.map((wait, place) => onRung("bBx"[place], wait)),
];

// Does what a row says, or returns why it can't be done.
export function perform(action, subject) {
  if (!subject[action.of]) return action.of === "tag" ? "Select a tag first: click a contact." : "Select a rung first: click it, or use the arrows.";
  const lack = action.lacks(subject);
  if (!lack) action.act(subject);
  return lack && `${action.text(subject)}: ${lack}.`;
}
