// The state bar: the key, the transport controls, readings of the scans, and the recording.

import { causeLine } from "./causeband.js";
import { compareButton } from "./compare.js";
import { at, button, el, reading, setAttribute, setFlag, setText } from "./dom.js";
import { findBox } from "./find.js";
import { clock, clocked, count, many, times } from "./format.js";
import { incidentsButton } from "./incidents.js";
import { helpButton } from "./keys.js";
import { lags, late as isLate } from "./lateness.js";
import { hush, tell } from "./notice.js";
import * as orders from "./orders.js";
import { shareButton } from "./share.js";
import { onHello, onPaint, run } from "./state.js";
import { transport } from "./transport.js";

const MODES = { program: "Program", test: "Test", run: "Run" };
const STATES = { live: ["●", "Live"], paused: ["❚❚", "Paused"], past: ["◀", "Past"], lost: ["✕", "Lost"] };

const modes = Object.entries(MODES).map(([name, title]) =>
  button(title, () => orders.mode(name), {
    "data-mode-key": name,
    "aria-pressed": "false",
    title: `Turn the key to ${title}`,
  })
);
const key = el("div", { class: "key", role: "group", "aria-label": "Key" }, ...modes);

const scan = reading("Scan", "long", "Number of the scan that is shown");
const time = reading("Time", "long", "Machine time since power-up, min:s.ms");
const reached = reading("Speed", "middle", "Speed reached over the last second");
const late = reading(
  "Late",
  "short",
  "Scans that began more than 0.1 ms late. Their images are the same; only people and real devices see " +
    "them later. Amber from 5 % on, or when the speed is not reached"
);
const forces = reading("Forces", "", "Nothing is forced");
const stubs = reading("Stubs", "", "No stub stands in for a missing part");
const allButton = button("Remove all forces", () => orders.unforce("all"), { hidden: true });
const record = reading("Recording", "name", "The trace that is being written");

const stateSign = el("span", { class: "sign", "aria-hidden": "true" });
const stateWord = el("span", {});
const state = el("div", { class: "state", role: "status" }, stateSign, stateWord);
const rack = el("h1", { class: "rack" });
// for a phone
const more = button(
  "More controls",
  () => setAttribute(more, "aria-expanded", String(more.getAttribute("aria-expanded") !== "true")),
  { text: "⋯", class: "sign more", "aria-expanded": "false" }
);

function build(hello) {
  const name = hello.rack || hello.path;
  document.title = `${name} – scanrack`;
  setText(rack, name);
  rack.title = hello.path;
  const used = hello.stubs ?? [];
  stubs.node.hidden = !used.length;
  setText(stubs.value, String(used.length));
  stubs.node.title = used.join("\n");
  setText(record.value, fileOf(hello.record) || "off");
  record.node.title = hello.record ? `Recording to ${hello.record}` : "Nothing is recorded";
  setFlag(document.documentElement, "data-read-only", !orders.allowed());
  for (const each of modes) each.disabled = !orders.allowed();
  for (const each of [key, reached.node, late.node]) each.hidden = orders.recorded(); // they concern a running rack
  setFlag(document.documentElement, "data-recorded", orders.recorded());
  at("bar").replaceChildren(
    el("div", { class: "row" }, rack, state, key, transport(), more),
    el(
      "div",
      { class: "row readings" },
      scan.node,
      time.node,
      reached.node,
      late.node,
      forces.node,
      allButton,
      stubs.node,
      record.node,
      causeLine
    ),
    el("div", { class: "row seek" }, findBox(), incidentsButton(), compareButton(), shareButton(), helpButton())
  );
  paintForces([]);
  paintMode();
}

// The height of the bar, for parts that stay beside the program while it scrolls.
new ResizeObserver(() => document.documentElement.style.setProperty("--bar", `${at("bar").offsetHeight}px`)).observe(
  at("bar")
);

const fileOf = path => path ? path.split("/").pop() : "";

function paint(changes) {
  setText(scan.value, count(run.scan ?? 0));
  setText(time.value, clock(run.t ?? 0));
  setText(late.value, count(run.late ?? 0));
  setFlag(late.node, "data-warning", run.late > 0 && run.state === "live" && (isLate || lags()));
  if (changes.forced) paintForces(Object.keys(changes.forced));
  if (changes.speed) paintSpeed(changes.speed);
  if (changes.record !== undefined) setText(record.value, fileOf(changes.record) || "off");
  if (changes.met?.length) tell(clocked(changes.met.join("\n")), "met");
  if (run.state !== "paused") hush("met");
  paintMode();
}

function paintForces(names) {
  setText(forces.value, count(names.length));
  setFlag(forces.node, "data-warning", names.length > 0);
  allButton.hidden = !names.length || !orders.allowed();
  setText(allButton, `Remove ${many(names.length, "force")}`);
  setAttribute(allButton, "aria-label", allButton.textContent);
  forces.node.title = names.length ? `Forced: ${names.join(", ")}` : "Nothing is forced";
}

function paintSpeed({ reached: got }) {
  if (orders.recorded()) setText(reached.value, "–");
  else setText(reached.value, run.paused || got === null ? "0×" : times(got));
}

export function paintMode() {
  const [sign, word] = STATES[run.state] ?? STATES.lost;
  const fault = run.mode === "fault" && ["live", "paused"].includes(run.state);
  setText(stateSign, fault ? "!" : sign);
  setText(stateWord, fault ? "Fault" : word);
  setAttribute(state, "data-fault", fault ? "" : null);
  for (const each of modes) setAttribute(each, "aria-pressed", String(each.dataset.modeKey === run.mode));
}

onHello(build);
onPaint(paint);
