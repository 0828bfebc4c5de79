// What has happened, the latest at the top; a click looks at that scan.

import { at, el, heading } from "./dom.js";
import { clock } from "./format.js";
import { lookAt } from "./scrub.js";
import { onHello, onPaint, run } from "./state.js";

const MOST = 200; // rows that are kept

const list = el("ol", { class: "events", "aria-label": "Events, the latest first", tabindex: "0" });

onHello(() => {
  list.replaceChildren();
  at("events").replaceChildren(heading("Events"), list);
});

onPaint(({ events }) => {
  if (!events?.length) return;
  for (const event of events.slice(-MOST)) {
    if (event.name === "step" && list.firstChild?.dataset.event === "step") list.firstChild.remove(); // one row for many steps
    list.prepend(row(event));
  }
  while (list.children.length > MOST) list.lastChild.remove();
});

function row({ scan, t, slot, text, kind, name }) {
  return el("li", { "data-kind": kind, "data-event": name, "data-scan": scan },
    el("button", { type: "button", title: `Look at scan ${scan}`, click: () => lookAt(scan) },
      el("time", { class: "figure" }, clock(t)), el("span", { class: "what" }, slot && run.hello.slots.length > 1 ? `${slot}: ${text}` : text)));
}
