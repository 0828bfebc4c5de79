// Breakpoints on rungs and lines.

import * as orders from "./orders.js";
import { run } from "./state.js";

// What one waits for: the end of its place, and words.
export const WAITS = [["", "true", "is true"], [" changes", "changes", "changes"], [" executes", "executes", "executes"]];
export const breakpointsAt = (ident, list = run.breakpoints) => WAITS.filter(([end]) => list.includes(ident + end));

// Sets a breakpoint that waits until a rung is true, or removes all of it.
export function toggleBreakpoint(ident) {
  const set = breakpointsAt(ident);
  for (const [end] of set.length ? set : WAITS.slice(0, 1)) orders.breakpoint(ident + end);
}
