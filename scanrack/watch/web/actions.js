// What can be done with a tag or a rung, by menu and by key: a row each, with the reason why it can't be done now.

import { WAITS, waits } from "./breakpoints.js";
import {
  closed, first, isPython, lacksBreak, lacksForce, notBool, notSingle, past, python, untimed, unwritable,
} from "./lacks.js";
import { showPanel } from "./layout.js";
import * as orders from "./orders.js";
import { select } from "./selection.js";
import { run } from "./state.js";
import { MOST, hasLane, tagNames, toggleTag } from "./taglanes.js";
import { uses, want, why } from "./tag.js";
import { isForced, valueOf } from "./values.js";
import { addToWatch, isWatched } from "./watchtable.js";

const full = ({ tag }) =>
  tagNames().length >= MOST && !hasLane(tag) ? `the strip has room for ${MOST} tags` : "";

const unitOf = rung =>
  run.hello.routines.find(each => rung.startsWith(`${each.name}.`))?.kind === "ladder" ? "rung" : "line";
const onTag = (key, text, says, lacks, act, more) => ({ key, text: () => text, says, lacks, act, of: "tag", ...more });
// The first key is for the first of what a breakpoint can wait for: of a line of Python that it executes.
const onRung = (key, place) => {
  const wait = () => (place ? WAITS[place] : waits()[0]), whole = ({ rung }) => rung + wait()[0];
  return {
    key, of: "rung", fits: () => !place || !isPython(),
    text: ({ rung }) => `Break when ${unitOf(rung)} ${rung.split(".").at(-1)} ${wait()[2]}`,
    says: `breakpoint: when the rung ${WAITS[place][2]}`,
    lacks: first(untimed, () => (waits().includes(wait()) ? "" : "a line of Python executes or not")),
    checked: subject => run.breakpoints.includes(whole(subject)), act: subject => orders.breakpoint(whole(subject)),
  };
};

export const ACTIONS = [
  onTag("t", "Toggle", "toggle the tag", first(closed, past, notBool, unwritable), ({ tag }) =>
    orders.write(tag, !valueOf(tag))
  ),
  onTag("1", "Force on", "force it on", first(notBool, lacksForce), ({ tag }) => orders.force(tag, true)),
  onTag("0", "Force off", "force it off", first(notBool, lacksForce), ({ tag }) => orders.force(tag, false)),
  onTag(
    "r",
    "Remove force",
    "remove its force",
    first(closed, ({ tag }) => (isForced(tag) ? "" : "it is not forced")),
    ({ tag }) => orders.unforce(tag)
  ),
  onTag(
    "w",
    "Why",
    "why it is as it is",
    () => "",
    ({ tag, names }) => {
      select({ tag, names: [...new Set([tag, ...names])] });
      why();
    }
  ),
  onTag(
    "g",
    "What would it take",
    "what it would take to have its other level",
    first(() => (run.hello.shared ? "a shared page runs nothing" : ""), notBool),
    ({ tag }) => {
      select({ tag });
      want();
    }
  ),
  onTag("u", "Uses", "where it is used", python, ({ tag }) => {
    select({ tag });
    uses();
  }),
  onTag("l", "Lane in the strip", "a lane in the strip", first(notSingle, full), ({ tag }) => toggleTag(tag), {
    checked: ({ tag }) => hasLane(tag),
  }),
  onTag(
    "a",
    "Into the watch table",
    "into the watch table",
    ({ tag }) => (isWatched(tag) ? "it is there" : ""),
    ({ tag }) => {
      addToWatch(tag);
      showPanel("watch");
    }
  ),
  onTag(
    "k",
    "Break when it changes",
    "breakpoint: when it changes",
    lacksBreak,
    ({ tag }) => orders.breakpoint(tag),
    { checked: ({ tag }) => run.breakpoints.includes(tag) }
  ),
  ...[..."bBx"].map(onRung),
];

// Does what a row says, or returns why it can't be done.
export function perform(action, subject) {
  if (!subject[action.of])
    return action.of === "tag"
      ? "Select a tag first: click a contact."
      : "Select a rung first: click it, or use the arrows.";
  const lack = action.lacks(subject);
  if (!lack) action.act(subject);
  return lack && `${action.text(subject)}: ${lack}.`;
}
