// The chain of causes in an answer: a list whose links lead to their scans and rungs, and marks on the strip.

import { el } from "./dom.js";
import { clock } from "./format.js";
import { showRung } from "./program.js";
import { lookAt } from "./scrub.js";
import { select, selected } from "./selection.js";

const followers = [];
export const marks = []; // times of the links, ns

// Calls a function when there are other marks.
export const onMarks = follow => { followers.push(follow); };

// The list of a chain's links; it marks them on the strip.
export function chainOf(links = []) {
  mark(links);
  if (links.length < 2) return "";
  return el("div", { class: "chain", role: "group", "aria-label": "Chain of causes" }, el("h3", {}, "Because"), el("ol", {}, ...behind(links, 0, new Set([0]))));
}

export const clearChain = () => mark([]);

function mark(links) {
  marks.splice(0, marks.length, ...links.map(({ t }) => t));
  for (const follow of followers) follow();
}

// The items of what is behind a link; one behind the other while there is one only, else in a list of their own.
function behind(links, number, seen) {
  return links[number].causes.flatMap((group, place) => group.map((cause, option) => {
    const word = option ? "or" : place ? "and" : "", again = seen.has(cause);
    seen.add(cause);
    const further = again ? [] : behind(links, cause, seen), alone = links[number].causes.length === 1 && group.length === 1;
    const item = el("li", { "data-kind": links[cause].kind }, ...itemOf(links[cause], word));
    if (alone) return [item, ...further];
    if (further.length) item.append(el("ol", {}, ...further));
    return [item];
  }).flat());
}

// Looks at a scan and a rung; the tag that was asked about stays selected.
function show(scan, rung) {
  const { tag, names } = selected;
  lookAt(scan);
  showRung(rung);
  select({ tag, names });
}

function itemOf({ scan, t, text, at }, word) {
  const said = text.replace(/ \(([\d.e+-]+) s(?:, )?/, " (");
  return [
    el("button", { type: "button", class: "plain", title: `Look at scan ${scan}`, click: () => lookAt(scan) }, el("time", { class: "figure" }, clock(t))),
    el("span", {}, word ? el("b", {}, `${word} `) : "", at ? el("button", { type: "button", class: "plain", title: `Show ${at}`, click: () => show(scan, at) }, said) : said)];
}
