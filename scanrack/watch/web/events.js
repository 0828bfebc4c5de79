// The events up to the scan shown, the latest at the top. A click shows the scan of an event. Scrolling requests
// earlier events. Kinds of events can be hidden.

import { at, button, el, heading, setAttribute, setText } from "./dom.js";
import { rowsOf } from "./eventrows.js";
import { clock, count } from "./format.js";
import { stopBox } from "./causeband.js";
import { isHidden, kindsOf } from "./eventkinds.js";
import { keep, kept } from "./kept.js";
import { lookAt } from "./scrub.js";
import { ask } from "./source.js";
import { onHello, onPaint, run } from "./state.js";

const MOST = 200, PIECE = 100; // rows that are kept of a running rack; events per question
const AGAIN_MS = 300; // delay of another question while events are read in the background
const GROUPS = {
  Errors: ["error", "fault", "faults"], Rules: ["rule"], Buttons: ["stimulus", "order"], Moves: ["move", "step"],
  Lights: ["indicator"],
};
const FIRST = ["Lights"]; // groups that are hidden by default

const list = el("ol", { class: "events", "aria-label": "Events, the latest first", tabindex: "0" });
const end = el("p", { class: "soft end" });
const filters = Object.keys(GROUPS).map(name => button(name, () => toggle(name), { "aria-pressed": "true" }));
const bar = el("div", { class: "filters", role: "group", "aria-label": "Listed events" }, ...filters);

let latest = [], listed = [], total = 0, whole = true; // latest events of a running rack; listed events, in order
let hidden = FIRST, asking = false, more = false;

const hide = () => hidden.flatMap(name => GROUPS[name]);

onHello(() => {
  latest = [];
  hidden = kept("events", FIRST).filter(name => name in GROUPS);
  paintFilters();
  show([]);
  at("events").replaceChildren(heading("Events", stopBox), bar, list, end);
});

onPaint(({ events, scan, state }) => {
  if (events) latest = [...latest, ...events].slice(-MOST);
  if (run.state === "past") { if (scan !== undefined || state) lookBack(); } else if (events || state) showLatest();
});

function toggle(name) {
  hidden = hidden.includes(name) ? hidden.filter(group => group !== name) : [...hidden, name];
  keep("events", hidden);
  paintFilters();
  list.replaceChildren();
  if (run.state === "past") lookBack(true); else showLatest();
}

function paintFilters() {
  for (const filter of filters) setAttribute(filter, "aria-pressed", String(!hidden.includes(filter.textContent)));
}

function showLatest() {
  const kinds = hide();
  more = true;
  show(latest.filter(event => !isHidden(event, run.hello.slots, kinds)));
  say(listed.length < PIECE ? "" : "Scroll for earlier events.");
  if (listed.length < PIECE) loadEarlier();
}

// Requests the events up to the past scan shown. While a request is pending, only the latest scan counts.
async function lookBack(again = false) {
  if (asking) return;
  asking = true;
  for (let to = null; run.state === "past" && (again || to !== run.scan);) {
    again = false;
    to = run.scan;
    try {
      const answer = await ask("events", { to, hide: hide(), most: PIECE });
      if (run.state === "past") take(answer);
    } catch { break; } // the next hello asks again
  }
  asking = false;
}

function take(answer) {
  ({ total, whole } = answer);
  more = total > answer.events.length;
  show(answer.events);
  sayEnd();
  if (!whole) setTimeout(() => { if (!whole && run.state === "past") lookBack(true); }, AGAIN_MS);
}

// Requests events before the first listed one.
async function loadEarlier() {
  if (asking || !more) return;
  asking = true;
  const known = new Set(listed.map(keyOf)), [first] = listed, to = first?.scan ?? run.scan ?? 0;
  try {
    for (let skip = 0, earlier = []; more && !earlier.length; skip += PIECE) {
      const answer = await ask("events", { to, skip, hide: hide(), most: PIECE });
      earlier = answer.events.filter(event => !known.has(keyOf(event)));
      more = answer.total > skip + answer.events.length;
      ({ whole } = answer);
      if (run.state !== "past") total = listed.length + answer.total;
      if (earlier.length) show([...earlier, ...listed]);
    }
    sayEnd();
  } catch { more = false; }
  asking = false;
}

function sayEnd() {
  if (more) return say(`${count(list.children.length)} of ${count(total)} events: scroll for earlier ones.`);
  say(whole ? `All ${count(list.children.length)} events up to here.` : "Earlier events are being read.");
}

const say = text => setText(end, text);

new IntersectionObserver(([{ isIntersecting }]) => {
  if (isIntersecting && listed.length) loadEarlier();
}).observe(end);

// Shows events. Rows that stay are not replaced, since one may have the focus.
function show(events) {
  listed = events;
  const requested = rowsOf(events).reverse();
  const known = new Set(requested.map(keyOf));
  for (const row of [...list.children]) if (!known.has(row.key)) row.remove();
  let next = list.firstChild;
  for (const event of requested) {
    if (next?.key === keyOf(event)) next = next.nextSibling;
    else list.insertBefore(rowOf(event), next);
  }
}

const keyOf = ({ scan, t, slot, text }) => `${scan} ${t} ${slot} ${text}`;

function rowOf(event) {
  const { scan, t, slot, text, kind, name } = event;
  const slotText = slot && run.hello.slots.length > 1 ? `${slot}: ${text}` : text;
  const row = el(
    "li",
    {
      "data-kind": kind,
      "data-event": name,
      "data-scan": scan,
      "data-error": kindsOf(event, run.hello.slots).includes("error"),
    },
    el(
      "button",
      { type: "button", title: `Look at scan ${scan}`, click: () => lookAt(scan) },
      el("time", { class: "figure" }, clock(t)),
      el("span", { class: "what" }, slotText)
    )
  );
  row.key = keyOf(event);
  return row;
}
