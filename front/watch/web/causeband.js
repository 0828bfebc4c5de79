// The band of causes: what was asked about, its scan, the numbered causes; and whether the other rungs are shown.

import { causes, claim, onCauses, takeCauses } from "./causes.js";
import { visit } from "./chain.js";
import { at, button, el, setAttribute, setFlag } from "./dom.js";
import { clock, count } from "./format.js";
import { lookAt } from "./scrub.js";
import { onHello } from "./state.js";

const some = button("Causes only", () => show(true), { text: "Causes" });
const all = button("All rungs", () => show(false));
const choice = el("div", { class: "key", role: "group", "aria-label": "Rungs shown" }, some, all);

// Whether rungs without a cause are hidden.
function show(only) {
  setFlag(at("program"), "data-only", only);
  setAttribute(some, "aria-pressed", String(only));
  setAttribute(all, "aria-pressed", String(!only));
}

const item = cause => el("li", { "data-kind": cause.kind },
  el("button", { type: "button", title: `Look at scan ${count(cause.scan)}`, click: () => visit(cause) },
    el("span", {}, String(cause.number)), el("span", {}, cause.text)));

function paint() {
  const band = at("causes");
  band.hidden = causes.length < 2;
  show(false);
  if (band.hidden) return;
  band.replaceChildren(
    el("div", { class: "row" }, el("strong", {}, claim.text),
      el("button", { type: "button", class: "plain", click: () => lookAt(claim.scan) }, `scan ${count(claim.scan)}, ${clock(claim.t)}`),
      choice, button("Close causes", () => takeCauses(), { text: "✕", title: "Take the causes away", class: "sign" })),
    el("ol", { "aria-label": "Causes by time" }, ...causes.map(item)));
}

onCauses(paint);
onHello(() => takeCauses());
