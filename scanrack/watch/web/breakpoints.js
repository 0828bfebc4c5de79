// Breakpoints on rungs and lines.

import { el } from "./dom.js";
import { isPython } from "./lacks.js";
import * as orders from "./orders.js";
import { run } from "./state.js";

// Conditions of breakpoints: suffix of the location, short name, and text.
/** @type {[string, string, string][]} */
export const WAITS = [
  ["", "true", "is true"],
  [" changes", "changes", "changes"],
  [" executes", "executes", "executes"],
];
export const breakpointsAt = (ident, list = run.breakpoints) =>
  WAITS.filter(([suffix]) => list.includes(ident + suffix));

// The conditions that are available: a line of Python can only execute.
export const waits = () => (isPython() ? WAITS.slice(2) : WAITS);

// The number of a rung or line, which is the button of its breakpoint. `unit` is "rung" or "line".
export const stopButton = (ident, unit, number, properties = {}, ...more) =>
  el(
    "button",
    {
      type: "button",
      class: "stop",
      tabindex: -1,
      "aria-label": `Breakpoint on ${unit} ${number}`,
      "aria-pressed": "false",
      disabled: !orders.timed(),
      click: event => { event.stopPropagation(); toggleBreakpoint(ident); },
      ...properties,
    },
    String(number),
    ...more
  );

// Sets a breakpoint for the first condition; with breakpoints at the rung or line, removes all of them.
function toggleBreakpoint(ident) {
  const present = breakpointsAt(ident);
  for (const [suffix] of present.length ? present : waits().slice(0, 1)) orders.breakpoint(ident + suffix);
}
