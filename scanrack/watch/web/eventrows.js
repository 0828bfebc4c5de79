// The rows of the list of events: by time, each thing once.

import { clocked, grouped } from "./format.js";

// An order that presses an input is reported; that the input is on then says the same.
const pressOf = ({ order, scan }) => {
  if (!order) return null;
  const { do: what, slot, name } = JSON.parse(order);
  return what === "press" ? `${scan} ${slot} ${name}`.toLowerCase() : null;
};

// What happens to a rack stands before what it leads to at the same time.
const cause = ({ kind }) => Number(["stimulus", "order", "incident"].includes(kind));

const isStep = event => event?.name === "step";

// Events in the order of their times, one row for many steps.
export function rowsOf(events) {
  const pressed = new Set(events.map(pressOf));
  const isSaid = ({ kind, scan, slot, name }) =>
    kind === "stimulus" && pressed.has(`${scan} ${slot} ${name}`.toLowerCase());
  const reported = events
    .filter(event => !isSaid(event))
    .sort((one, other) => one.t - other.t || cause(other) - cause(one));
  const rows = reported.filter((event, place) => !isStep(event) || !isStep(reported[place + 1]));
  return rows.map(event => ({ ...event, text: grouped(clocked(event.text)) }));
}
