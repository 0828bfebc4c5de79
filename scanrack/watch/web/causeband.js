// A line in the state bar: a failure or the tag of a Why, its first cause, and its time. A click opens the numbered
// causes below the bar. A live page stays live at an error bit of a module, unless it stops at errors.

import { causes, claim, onCauses, ordered, rungOf, setFailed, takeCauses } from "./causes.js";
import { visit } from "./chain.js";
import { at, button, el, setAttribute, setFlag, setText } from "./dom.js";
import { clock, count } from "./format.js";
import { keep, kept } from "./kept.js";
import { isPython } from "./lacks.js";
import { late } from "./lateness.js";
import { tell } from "./notice.js";
import * as orders from "./orders.js";
import { showRung } from "./program.js";
import { lookAt } from "./scrub.js";
import { ask } from "./source.js";
import { onHello, onPaint, run } from "./state.js";
import { askWhy } from "./tag.js";
import { valueOf } from "./values.js";
import { aliasOf, nameOf } from "./words.js";

const CALM_MS = 300; // an error bit is not explained if another one follows within this time
// The scan, the error class and the place at the start of a fault's text, which the page shows elsewhere.
const SHOWN_ELSEWHERE = /^scan [\d,]+ \(.*?\): (the program raised LadderFault: (.*?, rung \d+, )?)?/;
const WAY_ON = "To continue: go to an earlier scan with the key , or the slider, then press Branch from here.";

const sign = el("span", { "aria-hidden": "true" }),
  number = el("span", { class: "cause" }),
  what = el("strong", {}),
  first = el("span", { class: "first" });
const line = el(
  "button",
  { type: "button", class: "open", "aria-controls": "causes", click: toggle },
  sign,
  number,
  what,
  first
);
const when = el("button", { type: "button", class: "plain when", click: look });
const some = button("Causes only", () => showRungs(true), { text: "Causes" }),
  all = button("All rungs", () => showRungs(false));
const choice = el("div", { class: "key", role: "group", "aria-label": "Rungs shown" }, some, all);
const before = button("Branch one second before", () => orders.branch(oneSecondBefore()), {
  title: "Run again from one second earlier",
});
const close = button("Dismiss", dismiss, { text: "✕", class: "sign" });
const rest = el("p", { class: "says" }), list = el("ol", { "aria-label": "Causes by time" });
export const causeLine = el(
  "div",
  { class: "band", hidden: true },
  el("div", { class: "alert", role: "alert" }, line),
  when,
  close
);
at("causes").replaceChildren(el("div", { class: "row" }, choice, before), rest, list);

const box = el("input", {
  type: "checkbox",
  "aria-label": "Stop at errors",
  change: () => { keep("stops", { on: box.checked }); arm(); },
});
export const stopBox = el(
  "label",
  { class: "stops", title: "Stop the page at the scan of an error bit; the rack continues" },
  box,
  "Stop at errors"
);

// The failure: { fault, scan, t, what, cause, tag, place, links, seen }. `cause` is shown without `links`; `seen` says
// whether the operator has looked at its scan.
let failed = null;
let known = null; // the fault that was explained, which earlier scans do not have
let over = false; // whether the error bit of the failure is off again
let quiet = false, reported = null; // whether late scans are not reported; the latest report of them
let open = false, taking = false, own = false; // own: whether the causes are those of the failure

const setFailure = failure => { failed = failure; setFailed(failure); };

const arm = () => {
  if (run.hello.kind === "rack") ask("stop", { at_errors: box.checked ? "stop" : "off" }).catch(() => {});
};

onHello(hello => {
  box.checked = kept("stops", {}).on === true;
  setFlag(stopBox, "hidden", hello.kind !== "rack");
  if (box.checked) arm();
  setFailure(known = null);
  quiet = false;
  takeCauses();
});

// Reports an error bit that has come on. If `stopped`, the page is already at its scan.
export function erred({ scan, t, slot, bit, tag, text, rule, stopped }) {
  if (stopped && !box.checked) return lookAt("live"); // Stop at errors was turned off meanwhile
  if (failed?.fault) return;
  const where = run.hello.slots.length > 1 ? ` of slot ${slot}` : "";
  fail({
    scan,
    t,
    what: `${aliasOf(tag) ?? `${bit}${where}`} came on`,
    bit: `${slot}.${bit}`,
    cause: text && `${text}${rule ? ` [${rule}]` : ""}`,
    tag: nameOf(tag),
    seen: stopped,
  });
}

function fail(failure) {
  setFailure(failure);
  if (own) takeCauses();
  open = Boolean(failure.seen);
  paint();
  const isDue = () => failure === failed && (failure.seen || !isPython());
  setTimeout(() => { if (isDue()) explain(failure); }, failure.seen ? 0 : CALM_MS);
}

// Asks for the causes of a failure. A live page stays live.
async function explain(failure) {
  if (failure.queried || (failure.fault && !failure.tag)) return;
  failure.queried = true;
  const answer = await askWhy(
    failure.fault ? { fault: true } : { tag: failure.tag, scan: failure.scan },
    () => failure === failed
  ).catch(({ message }) => tell(message));
  if (!answer || failure !== failed) return;
  failure.links = answer.chain ?? [];
  failure.place ??= failure.links.find(link => link.at)?.at;
  if (failure.links.length < 2) failure.cause = answer.text;
  if (failure.seen || open) show();
  paint();
}

// Numbers the causes of the failure, and shows its rung.
function show() {
  if (failed.links?.length > 1) taking = true, takeCauses(failed.links), taking = false;
  if (open || run.scan === failed.scan) reveal(failed, ordered(failed.links ?? []));
}

// Shows the rung of a failure or of a Why, after the band has its final height, since the band shrinks the program.
async function reveal(subject, links) {
  const place = subject.place ?? await rungOf(links);
  if (place && (subject === failed || subject === claim))
    requestAnimationFrame(() => requestAnimationFrame(() => showRung(place, false)));
}

function toggle() {
  open = !open;
  if (open && failed && !claim) explain(failed), show();
  else if (open && claim) reveal(claim, causes);
  paint();
}

async function look() {
  const { scan } = subject();
  if (failed && scan === failed.scan) failed.seen = open = true;
  await lookAt(scan);
  if (failed?.seen) explain(failed), show();
}

// Dismisses the answer of a Why, or the failure; a page that was at its scan goes live again.
function dismiss() {
  if (subject() === late) quiet = true;
  if (!claim || own) {
    if (failed?.seen && run.state === "past") lookAt("live");
    setFailure(null);
  }
  open = false;
  takeCauses();
}

const oneSecondBefore = () => Math.max(failed.scan - Math.round(1e9 / run.hello.period_ns), run.range?.[0] ?? 0, 1);

// Shows only rungs with a cause, or all rungs.
function showRungs(only) {
  setFlag(at("program"), "data-only", only);
  setAttribute(some, "aria-pressed", String(only));
  setAttribute(all, "aria-pressed", String(!only));
}

// The subject of the line: the tag of a Why, otherwise the failure, otherwise late scans.
function subject() {
  if (causes.length > 1 && !own)
    return { ...claim, what: claim.text.replace(/ \(.*/s, ""), rest: claim.text, links: causes };
  return failed ?? (quiet ? null : late);
}

// Whether the error bit of a failure is off in the scan shown, in a session only.
const isOver = ({ bit, scan }) => bit && !orders.recorded() && run.scan > scan && !valueOf(bit);

// The text of a cause for the line, without the time and the input, which the line shows elsewhere.
const short = text => text.replace(/ \((?:[\d:.]+, )?(?:slot \d+ input \S+: )?(.*)\)$/s, ": $1");

function paint() {
  const shown = subject();
  setFlag(causeLine, "hidden", !shown);
  setFlag(at("causes"), "hidden", !shown || !open);
  if (!shown) return;
  const failure = shown === failed,
    numbered = failure && !own ? [] : causes,
    [cause] = failure ? ordered(shown.links ?? []) : causes;
  over = failure && isOver(shown);
  setAttribute(causeLine, "data-kind", failure ? (over ? "over" : "failure") : "why");
  setText(sign, failure || shown === late ? "!" : "?");
  setText(number, String(numbered.length ? claim.number : ""));
  setText(what, isOver(shown) ? shown.what.replace(/came on$/, "was on") : shown.what);
  setText(
    first,
    open && (numbered.length || shown === late)
      ? ""
      : cause && cause.link !== 0
        ? short(cause.text)
        : (shown.cause ?? "")
  );
  line.title = `${shown.what}\n${first.textContent}`.trim();
  setAttribute(line, "aria-expanded", String(open));
  setFlag(when, "hidden", shown === late);
  setText(when, clock(shown.t ?? 0));
  when.title = `Look at scan ${count(shown.scan ?? 0)}`;
  setFlag(choice, "hidden", !open || !numbered.some(cause => cause.at));
  setFlag(before, "hidden", !failure || !run.hello.branches);
  setFlag(close, "hidden", failure && Boolean(failed.fault));
  setText(
    rest,
    [
      shown.rest,
      shown === late && late.cause,
      failure && failed.links?.length < 2 && failed.cause,
      failure && failed.fault && run.hello.branches && WAY_ON,
    ]
      .filter(Boolean)
      .join("\n")
  );
  list.replaceChildren(...numbered.filter(cause => cause !== claim).map(item));
}

const item = cause => el("li", { "data-kind": cause.kind },
  el("button", { type: "button", title: `Look at scan ${count(cause.scan)}`, click: () => visit(cause) },
    el("span", { class: "cause" }, String(cause.number)), el("span", {}, cause.text)));

onCauses(hasChanged => {
  if (!hasChanged) return;
  own = taking;
  showRungs(false);
  paint();
});

onPaint(changes => {
  if (failed?.seen && run.state === "past") failed.past = true; // a frame from before the stop may be painted after it
  // the operator pressed Live
  if (failed?.past && !failed.fault && changes.state && changes.state !== "past") dismiss();
  if (late !== reported) reported = late, paint();
  if (changes.faults) faulted();
  else if (changes.words && failed?.bit && !claim && over !== isOver(failed)) paint();
});

// Explains a fault of the CPU once; afterwards only its rung is marked.
function faulted() {
  const [fault] = run.faults, same = fault && known && fault.scan === known.scan && fault.at === known.place;
  if (!fault && !own && failed?.fault) setFailure(null); // the scan shown is before the fault
  if (same && failed !== known) setFailure(known), open = true;
  if (!fault || same) return paint();
  const { scan, at: place, tags } = fault;
  const [what, ...others] = run.faults.map(({ text }) => text.replace(SHOWN_ELSEWHERE, ""));
  known = {
    fault: true,
    scan,
    t: scan * run.hello.period_ns,
    what,
    rest: [what, ...others].join("\n"),
    tag: tags?.[0],
    place,
    seen: true,
  };
  fail(known);
  show();
}
