// The chain of causes in an answer: a list of links to scans and rungs.

import { numberOf, takeCauses } from "./causes.js";
import { el, textButton } from "./dom.js";
import { clock } from "./format.js";
import { showRung } from "./program.js";
import { lookAt } from "./scrub.js";
import { select, selected } from "./selection.js";

// Returns the list of a chain's links; the page then shows their numbers everywhere.
export function chainOf(links = []) {
  takeCauses(links);
  if (links.length < 2) return "";
  return el(
    "div",
    { class: "chain", role: "group", "aria-label": "Chain of causes" },
    el("h3", {}, "Because"),
    el("ol", {}, ...causeItems(links, 0, new Set([0])))
  );
}

export const clearChain = () => takeCauses();

// Returns the items of the causes of a link. A single cause continues the list; several causes have nested lists.
function causeItems(links, number, listed) {
  return links[number].causes.flatMap((group, groupIndex) => group.map((cause, option) => {
    const conjunction = option ? "or" : groupIndex ? "and" : "", isListed = listed.has(cause);
    listed.add(cause);
    const deeper = isListed ? [] : causeItems(links, cause, listed),
      isSingle = links[number].causes.length === 1 && group.length === 1;
    const item = el(
      "li",
      { "data-kind": links[cause].kind, "data-number": numberOf(cause) },
      ...itemOf(links[cause], conjunction)
    );
    if (isSingle) return [item, ...deeper];
    if (deeper.length) item.append(el("ol", {}, ...deeper));
    return [item];
  }).flat());
}

// Shows the scan and the rung of a link; the tag of the question stays selected.
export function visit({ scan, at }) {
  const { tag, names } = selected;
  lookAt(scan);
  if (!at) return;
  showRung(at);
  select({ tag, names });
}

function itemOf({ scan, t, text, at }, conjunction) {
  const cause = text.replace(/ \([\d:.]+(?:, )?/, " (").replace(/ \(\)/, "");
  return [
    textButton(el("time", { class: "figure" }, clock(t)), () => lookAt(scan), `Look at scan ${scan}`),
    el(
      "span",
      {},
      conjunction ? el("b", {}, `${conjunction} `) : "",
      at ? textButton(cause, () => visit({ scan, at }), `Show ${at}`) : cause
    ),
  ];
}
