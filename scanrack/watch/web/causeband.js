// One line in the state bar: what failed, or the tag of a Why, its first cause, and when. A click opens the numbered
// causes beneath the bar. Live stays live at an error bit of a module, unless the viewer wishes to stop there.

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

const CALM_MS = 300; // an error bit that another one follows sooner is not explained
// of a fault: when and where
const SAID_ELSEWHERE = /^scan [\d,]+ \(.*?\): (the program raised LadderFault: (.*?, rung \d+, )?)?/;
const WAY_ON = "To continue: look at an earlier scan (, or the slider), then Branch from here.";

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
  title: "Run again from one second before on",
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
  { class: "stops", title: "The page stays at the scan of an error bit; the rack continues" },
  box,
  "Stop at errors"
);

// { fault, scan, t, what, cause, tag, place, links }; seen: its scan was looked at; cause stands for links
let failed = null;
let known = null; // the fault that was explained: an earlier scan is looked at without it
let over = false; // whether the bit of what failed is off again
let quiet = false, reported = null; // whether late scans are not to be reported; what was
let open = false, taking = false, own = false; // own: the causes are those of what failed

const fails = found => { failed = found; setFailed(found); };

const arm = () => {
  if (run.hello.kind === "rack") ask("stop", { at_errors: box.checked ? "stop" : "off" }).catch(() => {});
};

onHello(hello => {
  box.checked = kept("stops", {}).on === true;
  setFlag(stopBox, "hidden", hello.kind !== "rack");
  if (box.checked) arm();
  fails(known = null);
  quiet = false;
  takeCauses();
});

// An error bit has come on. If `stopped`, the page is already at its scan.
export function erred({ scan, t, slot, bit, tag, text, rule, stopped }) {
  if (stopped && !box.checked) return lookAt("live"); // turned off while it came
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

function fail(found) {
  fails(found);
  if (own) takeCauses();
  open = Boolean(found.seen);
  paint();
  setTimeout(() => { if (found === failed && (found.seen || !isPython())) explain(found); }, found.seen ? 0 : CALM_MS);
}

// Asks why. A page that is live is not moved.
async function explain(found) {
  if (found.queried || (found.fault && !found.tag)) return;
  found.queried = true;
  const said = await askWhy(
    found.fault ? { fault: true } : { tag: found.tag, scan: found.scan },
    () => found === failed
  ).catch(({ message }) => tell(message));
  if (!said || found !== failed) return;
  found.links = said.chain ?? [];
  found.place ??= found.links.find(link => link.at)?.at;
  if (found.links.length < 2) found.cause = said.text;
  if (found.seen || open) show();
  paint();
}

// Numbers the causes of what failed, and shows its rung.
function show() {
  if (failed.links?.length > 1) taking = true, takeCauses(failed.links), taking = false;
  if (open || run.scan === failed.scan) reveal(failed, ordered(failed.links ?? []));
}

// Shows the rung of a failure or of a Why when the band has its height, which takes it from the program.
async function reveal(of, links) {
  const place = of.place ?? await rungOf(links);
  if (place && (of === failed || of === claim))
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

// Takes the answer of a Why away, or what failed; a page that was at its scan follows the scans again.
function dismiss() {
  if (subject() === late) quiet = true;
  if (!claim || own) {
    if (failed?.seen && run.state === "past") lookAt("live");
    fails(null);
  }
  open = false;
  takeCauses();
}

const oneSecondBefore = () => Math.max(failed.scan - Math.round(1e9 / run.hello.period_ns), run.range?.[0] ?? 0, 1);

// Whether rungs without a cause are hidden.
function showRungs(only) {
  setFlag(at("program"), "data-only", only);
  setAttribute(some, "aria-pressed", String(only));
  setAttribute(all, "aria-pressed", String(!only));
}

// What the line is about: the tag of a Why, or else what failed, or late scans.
function subject() {
  const queried =
    causes.length > 1 && !own
      ? { ...claim, what: claim.text.replace(/ \(.*/s, ""), rest: claim.text, links: causes }
      : null;
  return queried ?? failed ?? (quiet ? null : late);
}

// Whether the error bit that failed is off in the scan shown, of a rack: of a recording all is over.
const isOver = ({ bit, scan }) => bit && !orders.recorded() && run.scan > scan && !valueOf(bit);

// A cause in the line: when it was stands beside the line, the slot and input are those of its name.
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
  setFlag(choice, "hidden", !open || !numbered.some(each => each.at));
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
  list.replaceChildren(...numbered.filter(each => each !== claim).map(item));
}

const item = cause => el("li", { "data-kind": cause.kind },
  el("button", { type: "button", title: `Look at scan ${count(cause.scan)}`, click: () => visit(cause) },
    el("span", { class: "cause" }, String(cause.number)), el("span", {}, cause.text)));

onCauses(others => {
  if (!others) return;
  own = taking;
  showRungs(false);
  paint();
});

onPaint(changes => {
  if (failed?.seen && run.state === "past") failed.past = true; // a frame from before the stop may be painted behind it
  if (failed?.past && !failed.fault && changes.state && changes.state !== "past") dismiss(); // by Live
  if (late !== reported) reported = late, paint();
  if (changes.faults) faulted();
  else if (changes.words && failed?.bit && !claim && over !== isOver(failed)) paint();
});

// A fault of the CPU is explained once; later looks at it mark its rung only.
function faulted() {
  const [fault] = run.faults, same = fault && known && fault.scan === known.scan && fault.at === known.place;
  if (!fault && !own && failed?.fault) fails(null); // nothing had failed yet in the scan shown
  if (same && failed !== known) fails(known), open = true;
  if (!fault || same) return paint();
  const { scan, at: place, tags } = fault;
  const [what, ...others] = run.faults.map(each => each.text.replace(SAID_ELSEWHERE, ""));
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
