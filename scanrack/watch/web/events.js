// What has happened up to the scan that is shown, the latest at the top; a click looks at that scan.

import { at, el, heading } from "./dom.js";
import { rowsOf } from "./eventrows.js";
import { clock } from "./format.js";
import { stopBox } from "./causeband.js";
import { lookAt } from "./scrub.js";
import { ask } from "./source.js";
import { onHello, onPaint, run } from "./state.js";

const MOST = 200; // rows that are kept

const list = el("ol", { class: "events", "aria-label": "Events, the latest first", tabindex: "0" });

let latest = [], asking = false; // the latest events of all, the earliest first

onHello(() => {
  latest = [];
  list.replaceChildren();
  at("events").replaceChildren(heading("Events", stopBox), list);
});

onPaint(({ events, scan, state }) => {
  if (events) latest = [...latest, ...events].slice(-MOST);
  if (run.state === "past") { if (scan !== undefined || state) lookBack(); } else if (events || state) show(latest);
});

// Asks for the events up to the scan of the past that is shown; while an answer is awaited only the latest wish is kept.
async function lookBack() {
  if (asking) return;
  asking = true;
  for (let end = null; run.state === "past" && end !== run.scan;) {
    end = run.scan;
    try {
      const answer = await ask("events", { to: end });
      if (run.state === "past") show(answer.events);
    } catch { break; } // the next hello asks again
  }
  asking = false;
}

// Shows events; rows that stay are not touched, since one may have the focus.
function show(events) {
  const wanted = rowsOf(events).reverse();
  const known = new Set(wanted.map(keyOf));
  for (const row of [...list.children]) if (!known.has(row.key)) row.remove();
  let next = list.firstChild;
  for (const event of wanted) {
    if (next?.key === keyOf(event)) next = next.nextSibling;
    else list.insertBefore(rowOf(event), next);
  }
}

const keyOf = ({ scan, t, slot, text }) => `${scan} ${t} ${slot} ${text}`;

function rowOf(event) {
  const { scan, t, slot, text, kind, name } = event;
  const row = el("li", { "data-kind": kind, "data-event": name, "data-scan": scan },
    el("button", { type: "button", title: `Look at scan ${scan}`, click: () => lookAt(scan) },
      el("time", { class: "figure" }, clock(t)), el("span", { class: "what" }, slot && run.hello.slots.length > 1 ? `${slot}: ${text}` : text)));
  row.key = keyOf(event);
  return row;
}
