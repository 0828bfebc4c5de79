// Breakpoints on rungs and lines.

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

// Sets a breakpoint that waits until a rung is true, or a line of Python executes; or removes all of it.
export function toggleBreakpoint(ident) {
  const set = breakpointsAt(ident);
  for (const [end] of set.length ? set : waits().slice(0, 1)) orders.breakpoint(ident + end);
}
