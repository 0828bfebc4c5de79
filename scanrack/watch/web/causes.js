// The causes of the latest answer, numbered by time. The band, the strip and the rungs show the same numbers.

import { ask } from "./source.js";
import { run } from "./state.js";
import { isSame } from "./values.js";

const followers = [];
let reader = null; // { rung, tag }: the rung that reads a cause, if no cause is in a rung
export const causes = []; // { number, scan, t, kind, text, at, because }; `because` has the names of direct causes
export let claim = null; // the cause that is the subject of the question

// Calls follow(true) when the causes change, follow(false) when the rung that reads them changes.
export const onCauses = follow => { followers.push(follow); };

// Returns the links of a chain, the claim first, as causes by time, each with its number and the index of its link.
export function ordered(links) {
  const order = links.map((_link, index) => index).sort((a, b) => links[a].scan - links[b].scan || b - a);
  return order.map((index, earlierCount) => ({
    ...links[index],
    link: index,
    number: earlierCount + 1,
    because: links[index].causes.flat().map(cause => links[cause].name),
  }));
}

let failed = null; // { place, scan } of the reported failure

export const setFailed = failure => { failed = failure; };

// The rungs and lines to mark: of faults, and of the failure in its scan.
export const faultPlaces = () => [
  ...run.faults.map(({ at }) => at),
  ...(failed?.place && run.scan === failed.scan ? [failed.place] : []),
];

// Shows the links of a chain as causes; without links, no causes.
export function takeCauses(links = []) {
  causes.splice(0, causes.length, ...ordered(links));
  claim = causes.find(cause => cause.link === 0) ?? null;
  reader = null;
  for (const follow of followers) follow(true);
}

export const numberOf = link => causes.find(cause => cause.link === link)?.number;

// Returns the latest rung among causes; if no cause is in a rung, the rung that reads the earliest of them.
export async function rungOf(links) {
  const latest = links.findLast(link => link.at)?.at;
  if (latest) return latest;
  for (const { name } of links) {
    const { hits = [] } = await ask("xref", { tag: name }).catch(() => ({}));
    reader = hits.find(({ rung }) => run.hello.routines.some(routine => rung?.startsWith(`${routine.name}.`))) ?? null;
    if (reader) break;
  }
  if (reader) for (const follow of followers) follow(false);
  return reader?.rung;
}

// Marks the rows of a routine with the numbers of their causes, and the elements with their direct causes.
export function markCauses(sheet) {
  for (const row of sheet.querySelectorAll("[data-at]")) {
    const rowCauses = causes.filter(cause => cause.at === row.dataset.at),
      isReader = reader?.rung === row.dataset.at,
      names = [...rowCauses.flatMap(cause => cause.because), ...(isReader ? [reader.tag] : [])];
    if (rowCauses.length) row.dataset.cause = rowCauses.map(cause => cause.number).join(" ");
    else delete row.dataset.cause;
    for (const group of row.querySelectorAll(".instruction")) {
      const operands = (group.dataset.names ?? "").split("\n");
      group.toggleAttribute("data-because", operands.some(operand => names.some(name => isSame(name, operand))));
    }
  }
}
