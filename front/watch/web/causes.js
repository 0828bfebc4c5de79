// The causes of the latest answer, numbered by time. The band, the strip and the rungs show the same numbers.

const followers = [];
export const causes = []; // { number, scan, t, kind, text, at, because: names of what is directly behind it }
export let claim = null; // the one that was asked about

// Calls a function when there are other causes.
export const onCauses = follow => { followers.push(follow); };

// The links of a chain, the claim first, as causes: by time, each with its number and the place of its link.
export function ordered(links) {
  const order = links.map((_link, place) => place).sort((one, other) => links[one].scan - links[other].scan || other - one);
  return order.map((place, before) => ({ ...links[place], link: place, number: before + 1, because: links[place].causes.flat().map(each => links[each].name) }));
}

// Takes the links of a chain; none take the causes away.
export function takeCauses(links = []) {
  const found = ordered(links);
  causes.splice(0, causes.length, ...found);
  claim = found.find(each => each.link === 0) ?? null;
  for (const follow of followers) follow();
}

export const numberOf = link => causes.find(each => each.link === link)?.number;

// Marks the rows of a routine with the numbers of their causes, and the elements that these are due to.
export function markCauses(sheet) {
  for (const row of sheet.querySelectorAll("[data-at]")) {
    const here = causes.filter(each => each.at === row.dataset.at), names = new Set(here.flatMap(each => each.because));
    if (here.length) row.dataset.cause = here.map(each => each.number).join(" ");
    else delete row.dataset.cause;
    for (const group of row.querySelectorAll(".instruction")) {
      group.toggleAttribute("data-because", (group.dataset.names ?? "").split("\n").some(name => names.has(name)));
    }
  }
}
