// The rows of the list of events: by time, without repetitions.

import { clocked, grouped } from "./format.js";

// The action that presses an input has its own row, which replaces the row of the input.
const pressOf = ({ order, scan }) => {
  if (!order) return null;
  const { do: action, slot, name } = JSON.parse(order);
  return action === "press" ? `${scan} ${slot} ${name}`.toLowerCase() : null;
};

// Causes come before their effects at the same time.
const cause = ({ kind }) => Number(["stimulus", "order", "incident"].includes(kind));

const isStep = event => event?.name === "step";

// Returns the events in the order of their times, with one row for successive steps.
export function rowsOf(events) {
  const pressed = new Set(events.map(pressOf));
  const isRepetition = ({ kind, scan, slot, name }) =>
    kind === "stimulus" && pressed.has(`${scan} ${slot} ${name}`.toLowerCase());
  const sorted = events.filter(event => !isRepetition(event)).sort((a, b) => a.t - b.t || cause(b) - cause(a));
  const rows = sorted.filter((event, index) => !isStep(event) || !isStep(sorted[index + 1]));
  return rows.map(event => ({ ...event, text: grouped(clocked(event.text)) }));
}
