// The chain of causes in an answer: a list whose links lead to their scans and rungs.

import { numberOf, takeCauses } from "./causes.js";
import { el, textButton } from "./dom.js";
import { clock } from "./format.js";
import { showRung } from "./program.js";
import { lookAt } from "./scrub.js";
import { select, selected } from "./selection.js";

// The list of a chain's links, which are numbered everywhere.
export function chainOf(links = []) {
  takeCauses(links);
  if (links.length < 2) return "";
  return el(
    "div",
    { class: "chain", role: "group", "aria-label": "Chain of causes" },
    el("h3", {}, "Because"),
    el("ol", {}, ...behind(links, 0, new Set([0])))
  );
}

export const clearChain = () => takeCauses();

// The items of what is behind a link; one behind the other while there is one only, else in their own list.
function behind(links, number, seen) {
  return links[number].causes.flatMap((group, place) => group.map((cause, option) => {
    const word = option ? "or" : place ? "and" : "", again = seen.has(cause);
    seen.add(cause);
    const further = again ? [] : behind(links, cause, seen),
      alone = links[number].causes.length === 1 && group.length === 1;
    const item = el(
      "li",
      { "data-kind": links[cause].kind, "data-number": numberOf(cause) },
      ...itemOf(links[cause], word)
    );
    if (alone) return [item, ...further];
    if (further.length) item.append(el("ol", {}, ...further));
    return [item];
  }).flat());
}

// Looks at the scan and the rung of a link; the tag of the question stays selected.
export function visit({ scan, at }) {
  const { tag, names } = selected;
  lookAt(scan);
  if (!at) return;
  showRung(at);
  select({ tag, names });
}

function itemOf({ scan, t, text, at }, word) {
  const cause = text.replace(/ \([\d:.]+(?:, )?/, " (").replace(/ \(\)/, "");
  return [
    textButton(el("time", { class: "figure" }, clock(t)), () => lookAt(scan), `Look at scan ${scan}`),
    el(
      "span",
      {},
      word ? el("b", {}, `${word} `) : "",
      at ? textButton(cause, () => visit({ scan, at }), `Show ${at}`) : cause
    ),
  ];
}
