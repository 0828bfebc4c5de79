// The causes of the latest answer, numbered by time. The band, the strip and the rungs show the same numbers.

import { ask } from "./source.js";
import { run } from "./state.js";
import { isSame } from "./values.js";

const followers = [];
let reader = null; // { rung, tag }: the rung that reads a cause, where no rung is one
export const causes = []; // { number, scan, t, kind, text, at, because: names of what is directly behind it }
export let claim = null; // the one that the question was about

// Calls follow(true) when there are other causes, follow(false) when another rung reads them.
export const onCauses = follow => { followers.push(follow); };

// The links of a chain, the claim first, as causes: by time, each with its number and the place of its link.
export function ordered(links) {
  const order = links
    .map((_link, place) => place)
    .sort((one, other) => links[one].scan - links[other].scan || other - one);
  return order.map((place, before) => ({
    ...links[place],
    link: place,
    number: before + 1,
    because: links[place].causes.flat().map(each => links[each].name),
  }));
}

let failed = null; // { place, scan }: of the failure that is reported

export const setFailed = found => { failed = found; };

// The rungs and lines to be marked: of faults, and of the error in its scan.
export const faultPlaces = () => [
  ...run.faults.map(({ at }) => at),
  ...(failed?.place && run.scan === failed.scan ? [failed.place] : []),
];

// Takes the links of a chain; none take the causes away.
export function takeCauses(links = []) {
  const found = ordered(links);
  causes.splice(0, causes.length, ...found);
  claim = found.find(each => each.link === 0) ?? null;
  reader = null;
  for (const follow of followers) follow(true);
}

export const numberOf = link => causes.find(each => each.link === link)?.number;

// The rung behind causes, the latest; of those that modules have made the one that reads the earliest of them.
export async function rungOf(links) {
  const made = links.findLast(each => each.at)?.at;
  for (const { name } of made ? [] : links) {
    const { hits = [] } = await ask("xref", { tag: name }).catch(() => ({}));
    reader = hits.find(({ rung }) => run.hello.routines.some(each => rung?.startsWith(`${each.name}.`))) ?? null;
    if (reader) break;
  }
  if (reader) for (const follow of followers) follow(false);
  return made ?? reader?.rung;
}

// Marks the rows of a routine with the numbers of their causes, and the elements that these are due to.
export function markCauses(sheet) {
  for (const row of sheet.querySelectorAll("[data-at]")) {
    const here = causes.filter(each => each.at === row.dataset.at),
      reads = reader?.rung === row.dataset.at,
      names = [...here.flatMap(each => each.because), ...(reads ? [reader.tag] : [])];
    if (here.length) row.dataset.cause = here.map(each => each.number).join(" ");
    else delete row.dataset.cause;
    for (const group of row.querySelectorAll(".instruction")) {
      group.toggleAttribute(
        "data-because",
        (group.dataset.names ?? "").split("\n").some(name => names.some(each => isSame(each, name)))
      );
    }
  }
}
