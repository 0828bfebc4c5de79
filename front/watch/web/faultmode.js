// Faults of the CPU and error bits of modules: what failed, its rung or line, the chain of causes, and a branch from one
// second before. Live stays live at an error bit, unless the viewer wishes to stop there.

import { button, el, setFlag, setText } from "./dom.js";
import { clock } from "./format.js";
import { keep, kept } from "./kept.js";
import * as orders from "./orders.js";
import { ask } from "./source.js";
import { onHello, onPaint, run } from "./state.js";
import { nameOf } from "./words.js";

const WAY_ON = "To go on: look at an earlier scan (, or the slider), then Branch from here.";

const says = el("p", { class: "fault", role: "alert", hidden: true });
const look = button("Look at it", open, { title: "Look at the scan of the error" });
const why = button("Causes", explain, { title: "Open the chain of causes" });
const before = button("Branch one second before", branchBefore, { title: "Run again from one second before on" });
const leave = button("Dismiss", () => { parts.look("live"); dismiss(); }, { title: "Follow the scans again" });
const buttons = el("div", { class: "line", hidden: true }, look, why, before, leave);
export const faultBar = el("div", { class: "faults", hidden: true }, says, buttons);

const box = el("input", { type: "checkbox", "aria-label": "Stop at errors", change: () => stopAtErrors(box.checked) });
export const stopBox = el("label", { class: "stops", title: "The page stays at the scan of an error bit; the rack goes on" }, box, "Stop at errors");

const parts = { show: () => {}, explain: () => {}, look: () => {} };
let error = null; // what came on: scan, t, slot, bit, tag, text, rule; at: its rung; seen: whether it was looked at
let known = ""; // the fault that was shown

// What other parts of the page do here: show(rung, smoothly), explain(tag, or null for the fault, then(links)), look(scan).
export const onFault = given => { Object.assign(parts, given); };

const key = () => `scanrack stops ${run.hello.path}`;

onHello(hello => {
  known = "";
  box.checked = kept(key(), {}).on === true;
  setFlag(stopBox, "hidden", hello.kind !== "rack");
  if (box.checked) arm();
  dismiss();
});

// Whether the page stops at error bits; this browser keeps it for each rack.
function stopAtErrors(on) {
  box.checked = on;
  keep(key(), { on });
  arm();
}

function arm() {
  if (run.hello.kind === "rack") ask("stop", { at_errors: box.checked ? "stop" : "off" }).catch(() => {});
}

// An error bit has come on. If `stopped`, the page is already at its scan.
export function erred(told) {
  if (told.stopped && !box.checked) return parts.look("live"); // turned off while it came
  error = { ...told, tag: nameOf(told.tag), seen: told.stopped };
  if (told.stopped) explain();
  paint();
}

function open() {
  error.seen = true;
  parts.look(error.scan);
  explain();
}

function dismiss() {
  error = null;
  paint();
}

const fault = () => run.faults[0];

function explain() {
  parts.explain(fault() ? null : error.tag, links => {
    const at = fault()?.at ?? links.find(link => link.at)?.at;
    if (!at) return;
    if (!fault() && error) error.at = at;
    bringIntoView(at);
  });
}

// Shows a rung or line when this bar has its height, which takes it from the program.
function bringIntoView(at) {
  requestAnimationFrame(() => requestAnimationFrame(() => parts.show(at, false)));
}

// The rungs and lines to be marked: of faults, and of the error in its scan.
export const faultPlaces = () => [...run.faults.map(({ at }) => at), ...(error?.at && run.scan === error.scan ? [error.at] : [])];

function sentence() {
  if (fault()) return [...run.faults.map(each => `! ${each.text}`), ...(run.hello.branches ? [WAY_ON] : [])].join("\n");
  const { slot, bit, t, text, rule } = error;
  return `! Slot ${slot}: ${bit} came on at ${clock(t)}${text ? `. ${text}` : ""}${rule ? ` [${rule}]` : ""}`;
}

function paint() {
  const any = Boolean(fault() || error);
  setFlag(faultBar, "hidden", !any);
  setFlag(says, "hidden", !any);
  setFlag(buttons, "hidden", !any);
  if (!any) return;
  setText(says, sentence());
  setFlag(look, "hidden", Boolean(fault()) || run.scan === error.scan);
  setFlag(why, "hidden", fault() ? !fault().tags?.length : run.scan !== error.scan);
  setFlag(leave, "hidden", Boolean(fault()));
  setFlag(before, "hidden", !run.hello.branches);
}

function branchBefore() {
  const scan = fault()?.scan ?? error.scan;
  orders.branch(Math.max(scan - Math.round(1e9 / run.hello.period_ns), run.range?.[0] ?? 0, 1));
}

onPaint(changes => {
  if (error?.seen && changes.state && changes.state !== "past") dismiss(); // by Live
  if (changes.faults || changes.state || changes.scan !== undefined) paint();
  if (changes.faults) newFault();
});

// A fault of the CPU is explained once; later looks at it mark its rung only.
function newFault() {
  const now = fault() ? `${fault().scan} ${fault().at}` : "", first = now && now !== known;
  if (now) known = now;
  if (fault()?.at) bringIntoView(fault().at);
  if (first && fault().tags?.length) explain();
}
