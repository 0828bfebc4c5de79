// The operator panel: the items of a file beside the rack file, on a grid. Presses are recorded like other actions.

import { at, button, el, heading, setAttribute, setFlag, setText } from "./dom.js";
import { link, requested } from "./link.js";
import { tell } from "./notice.js";
import * as orders from "./orders.js";
import { itemOf, lay } from "./panelitems.js";
import { editing, editor } from "./paneledit.js";
import { ask } from "./source.js";
import { onHello, onPaint, onProgram, run } from "./state.js";
import { bindValue, unbindIn } from "./values.js";
import { alsoWatched, sendWatched } from "./watchtable.js";

const CONFIRM_MS = 500; // the server releases presses that are not confirmed for four times as long

const grid = el("div", { class: "grid" });
const reason = el("p", { id: "panel-reason", class: "soft" });
const empty = el("p", {}), tools = el("div");
const onlyButton = button(
  "Panel only",
  () => {
    link({ panel: requested().panel ? null : "" });
    only(requested().panel);
  },
  { title: "Show only the panel, as on a tablet" }
);
const editButton = button("Edit panel", () => edit(true), { text: "Edit" });
const held = new Map(); // presses of this page: binding -> { scan, over }
let reported = null, parts = [], confirming = 0, said = null;

at("panel").append(
  heading("Operator panel", el("span", { class: "tools" }, editButton, onlyButton)),
  reason,
  empty,
  tools,
  grid
);

// The server has released all presses after a lost connection, or for a branch.
onHello(() => { if (held.size) held.clear(), confirm(); });

onProgram(() => {
  only(requested().panel);
  load();
});

export async function load() {
  try { take(await ask("panel")); } catch { /* the next hello asks again */ }
}

// Shows a panel from the server, perhaps with changes of another page. During an edit it only reports another version;
// the message about a file that this page has written may arrive during its next edit.
export function take(panel) {
  if (editing())
    return (
      panel.base !== reported.base && tell(`${panel.file} was changed meanwhile: discard your changes, then edit again`)
    );
  reported = panel;
  show(panel.items, panel.bound);
}

export function edit(on) {
  editor(on ? reported : null, { show, edit, take });
  only(requested().panel);
  if (!on) load();
}

// Shows items with their bindings. During an edit they press nothing.
export function show(items, bound) {
  unbindIn(grid);
  release();
  parts = bound.map((binding, index) => partOf(items[index], binding));
  const inOrder = [...parts].sort((a, b) => a.item.at[1] - b.item.at[1] || a.item.at[0] - b.item.at[0]);
  grid.replaceChildren(...inOrder.map(part => part.cell));
  setText(
    empty,
    reported.mistake ||
      (items.length || editing()
        ? ""
        : reported.lacks
          ? `The rack has no ${reported.file}.`
          : `No items yet. Press Edit to build a panel, which is kept as ${reported.file} beside the rack.`)
  );
  setAttribute(empty, "class", reported.mistake ? "wrong" : "soft");
  editButton.disabled = Boolean(reported.lacks);
  editButton.title = reported.lacks || "Build the panel";
  for (const toolButton of [editButton, onlyButton]) setFlag(toolButton, "hidden", Boolean(editing()));
  // the same editor stays, so that it keeps the focus
  if (tools.firstChild !== editing()) tools.replaceChildren(...(editing() ? [editing()] : []));
  const readTags = bound.filter(binding => binding.read && !isLevel(binding)).map(({ read }) => read);
  alsoWatched.splice(0, Infinity, ...new Set(readTags));
  sendWatched();
  said = null;
  for (const part of parts)
    if (isLevel(part.bound)) part.show(run.machine[part.bound.press[0]]?.inputs?.[part.bound.press[1]] ?? null);
  paint({});
}

// Whether an item is an input of an axis, whose level comes with its machine.
const isLevel = ({ press, read }) => Boolean(press) && !read.startsWith("Local:");

function partOf(item, bound) {
  const set = value => { const why = whyNot(); why ? tell(why) : operate(bound, value); };
  const made = itemOf(item, bound, { press: () => press(bound), release: () => release(bound), set, refuse: tell });
  const cell = el("div", { class: "item", "data-item": item.name, "data-kind": item.kind }, made.node);
  lay(cell, item);
  const part = {
    item,
    bound,
    cell,
    value: null,
    node: made.node,
    show(value) {
      part.value = value;
      made.show(levelOf(part));
    },
  };
  made.show(null);
  if (bound.read && !isLevel(bound)) bindValue(cell, bound.read, value => { part.show(value); return null; });
  else if (!bound.broken) cell.dataset.name = bound.read;
  return part;
}

// The value that an item shows. A button shows whether it is pressed, from its input or from the last action.
function levelOf({ item, bound, value }) {
  if (value === null || value === undefined) return null;
  if (item.kind === "momentary" && bound.write) return run.pressed?.[bound.write]?.[0] === true;
  if (bound.press && ["momentary", "maintained"].includes(item.kind)) return value !== (bound.press[2] ?? false);
  return bound.type === "BOOL" && item.kind !== "selector" ? Boolean(value) : value;
}

// --- presses

export function whyNot() {
  if (editing()) return "The panel is being edited and presses nothing.";
  if (run.state === "lost") return "The connection is lost: nothing can be pressed.";
  if (orders.recorded()) return "This is a recording: it shows what was pressed.";
  if (run.hello.read_only)
    return `This page is read-only: it shows what is pressed, and can't press${
      run.hello.live_ports ? " without --allow-writes" : ""
    }.`;
  return run.state === "past" ? "This is a past scan: press Live to operate the panel." : "";
}

const orderOf = ({ press, write, type }, value) => press
  ? { do: "press", slot: press[0], name: press[1], on: value ? !press[2] : press[2], by: "panel" }
  : { do: "write", tag: write, value: type === "BOOL" ? Boolean(value) : value, by: "panel" };

const operate = (bound, value) => orders.operate(orderOf(bound, value));

async function press(bound) {
  const why = whyNot();
  if (why) return tell(why);
  if (held.has(bound)) return;
  const mine = { scan: Infinity, over: false };
  held.set(bound, mine);
  confirm();
  const answer = await operate(bound, true);
  if (held.get(bound) !== mine) { if (answer) operate(bound, false); } // a hello came first
  else if (answer) mine.scan = answer.scan;
  else held.delete(bound), confirm();
  settle();
}

// Releases a button, or all buttons. A press lasts at least one scan, however short the touch.
function release(bound) {
  for (const [binding, press] of held) if (!bound || binding === bound) press.over = true;
  settle();
}

function settle() {
  for (const [bound, { scan, over }] of [...held]) {
    if (!over || !(run.scan >= scan || (run.state === "past" && scan < Infinity))) continue;
    held.delete(bound);
    operate(bound, false);
    confirm();
  }
}

// Confirms the presses. The server releases them when this page closes, is lost, or no longer confirms them.
function confirm() {
  clearTimeout(confirming);
  ask("hold", { give: [...held.keys()].map(bound => orderOf(bound, false)) }).catch(() => {});
  if (held.size) confirming = setTimeout(confirm, CONFIRM_MS);
}

/** @type {[EventTarget, string][]} */
const LEAVINGS = [[window, "blur"], [window, "pagehide"], [document, "visibilitychange"]];
for (const [target, event] of LEAVINGS) {
  target.addEventListener(event, () => { if (event !== "visibilitychange" || document.hidden) release(); });
}

// --- only the panel

addEventListener("hashchange", () => only(requested().panel));

function only(on) {
  setFlag(document.documentElement, "data-panel-only", on || Boolean(editing()));
  setText(onlyButton, on ? "Whole page" : "Panel only");
  onlyButton.setAttribute("aria-label", onlyButton.textContent);
}

function paint(changes) {
  const why = whyNot();
  setText(reason, why);
  setFlag(reason, "hidden", !why);
  for (const part of parts) {
    const [slot, name] = part.bound.press ?? [], level = changes.machine?.[slot]?.inputs?.[name];
    if (level !== undefined && isLevel(part.bound))
      (setAttribute(part.cell, "data-value", level === null ? "" : level ? "1" : "0"), part.show(level));
    else if (changes.pressed) part.show(part.value);
    if ((why === said && !changes.pressed) || (!part.bound.press && !part.bound.write)) continue;
    const [, by] = run.pressed?.[slot ? `${slot}.input.${name}` : part.bound.write] ?? [];
    setAttribute(part.cell, "title", by ? `Last set by ${by}` : null);
    for (const control of part.node.matches("button") ? [part.node] : part.node.querySelectorAll("button, input")) {
      setAttribute(control, "aria-disabled", why ? "true" : null);
      setAttribute(control, "aria-describedby", why ? "panel-reason" : null);
    }
  }
  said = why;
  settle();
}

onPaint(paint);
