// The band of a failed test: its message, its scan, and the first difference from the last run that passed.

import { at, el, textButton } from "./dom.js";
import { clock, count } from "./format.js";
import { showRung } from "./program.js";
import { lookAt } from "./scrub.js";
import { select } from "./selection.js";
import { onHello, run } from "./state.js";

const MOST_LINES = 2; // of the message; pytest's report has all of it

const why = el("p", {});

const atScan = scan =>
  textButton(`scan ${count(scan)}, ${clock(scan * run.hello.period_ns)}`, () => lookAt(scan), "Look at this scan");

// Returns buttons with commas between them.
const listed = (names, button) => names.flatMap((name, index) => [index ? ", " : " ", button(name)]);

function against({ scan, before, equal_to, tags = [], rungs = [], others = [] }) {
  if (equal_to !== undefined) return ["Same as the last run that passed, up to its end in ", atScan(equal_to)];
  const look = name => textButton(name, () => { lookAt(scan); select({ tag: name }); }, "Look at this tag");
  const open = name => textButton(name, () => { lookAt(scan); showRung(name); }, "Show this rung");
  return [
    `Differs from the last run that passed ${before ? "at or before" : "since"} `,
    atScan(scan),
    ":",
    ...listed(tags, look),
    ...(rungs.length ? [tags.length ? "; rungs" : " rungs"] : []),
    ...listed(rungs, open),
    others.length ? `; ${others.join(", ")}` : "",
  ];
}

onHello(() => {
  const { failure } = run.hello, band = at("failed");
  band.hidden = !failure;
  why.replaceChildren();
  if (!failure) return;
  const lines = failure.message.split("\n").slice(0, MOST_LINES).join("\n");
  band.replaceChildren(
    el("div", { class: "row" }, el("strong", {}, `${failure.test} failed`), atScan(failure.scan)), el("pre", {}, lines),
    why,
    failure.against ? el("p", {}, ...against(failure.against)) : "");
});

// Opens the rung or line of the first cause. An answer without a chain is shown here, since no other band has it.
export function caused(links, text) {
  const place = links.find(link => link.at)?.at;
  if (place) showRung(place);
  if (links.length < 2) why.replaceChildren(text);
}
