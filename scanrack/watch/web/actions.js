// The actions on a tag or a rung, for menus and keys. A row each, with the reason why it is not available now.

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
  run.hello.routines.find(({ name }) => rung.startsWith(`${name}.`))?.kind === "ladder" ? "rung" : "line";
const onTag = (key, text, says, lacks, act, more) => ({ key, text: () => text, says, lacks, act, of: "tag", ...more });
// The first key is for the first condition of a breakpoint, which for a line of Python is that it executes.
const onRung = (key, index) => {
  const condition = () => (index ? WAITS[index] : waits()[0]), location = ({ rung }) => rung + condition()[0];
  return {
    key, of: "rung", fits: () => !index || !isPython(),
    text: ({ rung }) => `Break when ${unitOf(rung)} ${rung.split(".").at(-1)} ${condition()[2]}`,
    says: `breakpoint: when the rung ${WAITS[index][2]}`,
    lacks: first(untimed, () => (waits().includes(condition()) ? "" : "a line of Python can only execute")),
    checked: subject => run.breakpoints.includes(location(subject)),
    act: subject => orders.breakpoint(location(subject)),
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
    "explain its value",
    () => "",
    ({ tag, names }) => {
      select({ tag, names: [...new Set([tag, ...names])] });
      why();
    }
  ),
  onTag(
    "g",
    "What would it take",
    "find actions that change its value",
    first(() => (run.hello.shared ? "not available in a shared page" : ""), notBool),
    ({ tag }) => {
      select({ tag });
      want();
    }
  ),
  onTag("u", "Uses", "list its uses", python, ({ tag }) => {
    select({ tag });
    uses();
  }),
  onTag("l", "Lane in the strip", "show a lane in the strip", first(notSingle, full), ({ tag }) => toggleTag(tag), {
    checked: ({ tag }) => hasLane(tag),
  }),
  onTag(
    "a",
    "Into the watch table",
    "into the watch table",
    ({ tag }) => (isWatched(tag) ? "it is already there" : ""),
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

// Carries out an action; returns "", or why the action is not available.
export function perform(action, subject) {
  if (!subject[action.of])
    return action.of === "tag"
      ? "Select a tag first: click a contact."
      : "Select a rung first: click it, or use the arrows.";
  const obstacle = action.lacks(subject);
  if (!obstacle) action.act(subject);
  return obstacle && `${action.text(subject)}: ${obstacle}.`;
}
