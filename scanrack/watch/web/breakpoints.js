// Breakpoints on rungs and lines.

import { el } from "./dom.js";
import { isPython } from "./lacks.js";
import * as orders from "./orders.js";
import { run } from "./state.js";

// What one waits for: the end of its place, and words.
/** @type {[string, string, string][]} */
export const WAITS = [
  ["", "true", "is true"],
  [" changes", "changes", "changes"],
  [" executes", "executes", "executes"],
];
export const breakpointsAt = (ident, list = run.breakpoints) => WAITS.filter(([end]) => list.includes(ident + end));

// What a breakpoint can wait for: of a line of Python that it executes.
export const waits = () => (isPython() ? WAITS.slice(2) : WAITS);

// The number of a rung or a line is the button of its breakpoint. `unit` is "rung" or "line".
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

// Sets a breakpoint that waits until a rung is true, or a line of Python executes; or removes all of it.
function toggleBreakpoint(ident) {
  const set = breakpointsAt(ident);
  for (const [end] of set.length ? set : waits().slice(0, 1)) orders.breakpoint(ident + end);
}
