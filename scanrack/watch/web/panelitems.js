// The items of an operator panel by kind. Each is { node, show }: show(value) shows the value of its tag in the node.

import { el, goTo, setAttribute, setText, svg } from "./dom.js";
import { count, isNumber, shown } from "./format.js";

const ARC = "M 8 46 A 38 38 0 0 1 84 46";
const LEVELS = { true: "on", false: "off" };
const MOVES = { ArrowLeft: -1, ArrowUp: -1, ArrowRight: 1, ArrowDown: 1 };
const STEPS = { ArrowUp: 1, ArrowDown: -1, PageUp: 10, PageDown: -10 };

const NARROW = 4; // columns of the grid on a narrow page

// Places a cell on the grid.
/**
 * @param {HTMLElement | SVGElement} cell
 * @param {{ at: number[], size: number[] }} item
 */
export function lay(cell, { at: [column, row], size: [width, height] }) {
  cell.style.gridArea = `${row + 1} / ${column + 1} / span ${height} / span ${width}`;
  cell.style.setProperty("--narrow", String(width < NARROW ? NARROW / 2 : NARROW));
}

const caption = item => el("span", { class: "caption" }, item.name);

/**
 * @param {any} value
 * @param {{ decimals?: number, unit?: string }} item
 */
export function figure(value, { decimals, unit }) {
  if (value === null || value === undefined) return "–";
  const text =
    decimals !== undefined && isNumber(value)
      ? Number(value).toFixed(decimals)
      : Number.isInteger(value)
        ? count(value)
        : shown(value);
  return unit ? `${text} ${unit}` : text;
}

// A lamp; a word says what its color says.
function lamp(item) {
  const word = el("span", { class: "word" }),
    node = el("div", { class: "lamp-item", role: "img" }, el("i", { class: "bulb" }), caption(item), word);
  return { node, show(on) {
    const level = LEVELS[on] ?? "–";
    setText(word, level);
    setAttribute(node, "data-lit", on === true ? "1" : "0");
    setAttribute(node, "aria-label", `${item.name}: ${level === "–" ? "not known" : level}`);
  } };
}

// A pushbutton, on while the pointer or the key is held down. A click by a screen reader is a short press.
function momentary(item, { press, release }) {
  const letGo = () => release(), isKey = event => [" ", "Enter"].includes(event.key);
  const node = el("button", {
    type: "button", class: "push", "aria-pressed": "false",
    pointerdown: event => { if (event.button === 0) { node.setPointerCapture(event.pointerId); press(); } },
    pointerup: letGo, pointercancel: letGo, lostpointercapture: letGo, blur: letGo,
    contextmenu: event => event.preventDefault(),
    keydown: event => { if (isKey(event)) { event.preventDefault(); if (!event.repeat) press(); } },
    keyup: event => { if (isKey(event)) { event.preventDefault(); letGo(); } },
    click: event => { if (!event.detail) { press(); letGo(); } },
  }, caption(item));
  return { node, show: on => setAttribute(node, "aria-pressed", String(on === true)) };
}

function maintained(item, { set }) {
  const word = el("span", { class: "word" });
  let level = null;
  const node = el(
    "button",
    {
      type: "button",
      class: "push",
      role: "switch",
      "aria-checked": "false",
      "aria-label": item.name,
      click: () => set(level !== true),
    },
    caption(item),
    word
  );
  return {
    node,
    show(on) {
      level = on;
      setText(word, LEVELS[on] ?? "–");
      setAttribute(node, "aria-checked", String(on === true));
    },
  };
}

function selector(item, { set }) {
  const values = item.values ?? item.positions.map((_, position) => position);
  const choices = item.positions.map((text, position) =>
    el(
      "button",
      {
        type: "button",
        role: "radio",
        "aria-checked": "false",
        tabindex: position ? -1 : 0,
        click: () => set(values[position]),
        keydown: event => goTo(event, choices, MOVES),
      },
      text
    )
  );
  const node = el(
    "div",
    { class: "selector", role: "radiogroup", "aria-label": item.name },
    caption(item),
    el("div", { class: "choices-of" }, ...choices)
  );
  return { node, show(value) {
    const position = values.indexOf(Number(value));
    choices.forEach((each, own) => {
      setAttribute(each, "aria-checked", String(own === position && value !== null));
      each.tabIndex = own === Math.max(position, 0) ? 0 : -1;
    });
  } };
}

function display(item) {
  const value = el("output", { class: "figure", "aria-label": item.name });
  return {
    node: el("div", { class: "readout" }, caption(item), value),
    show: latest => setText(value, figure(latest, item)),
  };
}

// A field for a number within limits, typed or changed with arrow keys and buttons. It shows the tag's value until
// something is typed.
function entry(item, { set, refuse }) {
  const step = 10 ** -(item.decimals ?? 0), limits = `${figure(item.least, item)} to ${figure(item.most, item)}`;
  let value = null, touched = false;
  const paint = () => {
    if (!touched) field.value = figure(value, { decimals: item.decimals }).replaceAll(",", "");
    setAttribute(field, "aria-valuenow", isNumber(value) ? Number(value) : null);
    setAttribute(field, "aria-valuetext", figure(value, item));
  };
  const submit = number => {
    const wrong = !Number.isFinite(number) || number < item.least || number > item.most;
    setAttribute(field, "aria-invalid", wrong ? "true" : null);
    touched = false;
    if (wrong) return refuse(`${item.name}: ${field.value || "nothing"} is not allowed: ${limits}`);
    set(number);
  };
  const submitTyped = () => submit(field.value.trim() === "" ? NaN : Number(field.value.replaceAll(",", "")));
  const move = by => {
    const next = Number(value ?? item.least) + by * step;
    touched = false;
    submit(Number(Math.min(Math.max(next, item.least), item.most).toFixed(item.decimals ?? 6)));
  };
  const field = el("input", {
    type: "text",
    inputmode: "decimal",
    role: "spinbutton",
    autocomplete: "off",
    "aria-label": item.name,
    "aria-valuemin": item.least,
    "aria-valuemax": item.most,
    title: limits,
    enterkeyhint: "done",
    input: () => {
      touched = true;
    },
    change: submitTyped,
    focus: () => field.select(),
    keydown: event => {
      if (event.key === "Escape") ((touched = false), paint());
      else if (STEPS[event.key]) (event.preventDefault(), move(STEPS[event.key]));
    },
  });
  const stepButton = (text, name, press) =>
    el(
      "button",
      {
        type: "button",
        "aria-label": `${name} ${item.name}`,
        pointerdown: event => event.preventDefault(),
        click: press,
      },
      text
    );
  const node = el(
    "div",
    { class: "readout entry" },
    el("span", { class: "caption" }, item.name, el("span", { class: "soft" }, item.unit ? ` ${item.unit}` : "")),
    el(
      "div",
      { class: "line" },
      stepButton("−", "Less", () => move(-1)),
      field,
      stepButton("+", "More", () => move(1))
    )
  );
  return { node, show(latest) { value = latest; paint(); } };
}

function gauge(item) {
  const fill = svg("path", { d: ARC, class: "fill", pathLength: 100 }), value = el("span", { class: "figure" });
  const node = el(
    "div",
    {
      class: "gauge",
      role: "meter",
      "aria-label": item.name,
      "aria-valuemin": item.least,
      "aria-valuemax": item.most,
    },
    caption(item),
    svg("svg", { viewBox: "0 0 92 52", "aria-hidden": "true" }, svg("path", { d: ARC }), fill),
    value,
    el(
      "span",
      { class: "ends", "aria-hidden": "true" },
      el("span", {}, figure(item.least, {})),
      el("span", {}, figure(item.most, {}))
    )
  );
  return { node, show(latest) {
    const share = isNumber(latest)
      ? Math.min(Math.max((Number(latest) - item.least) / (item.most - item.least), 0), 1)
      : 0;
    fill.style.strokeDasharray = `${100 * share} 200`;
    setText(value, figure(latest, item));
    setAttribute(
      node,
      "aria-valuenow",
      isNumber(latest) ? Math.min(Math.max(Number(latest), item.least), item.most) : null
    );
    setAttribute(node, "aria-valuetext", figure(latest, item));
  } };
}

const KINDS = { momentary, maintained, selector, lamp, display, entry, gauge };

// Makes an item, or shows why it is broken. `actions` has the functions press, release, set and refuse.
export function itemOf(item, { broken }, actions) {
  if (broken || !KINDS[item.kind])
    return {
      node: el(
        "div",
        { class: "broken", title: broken },
        el("b", {}, `⚠ ${item.name || item.kind}`),
        el("span", {}, broken)
      ),
      show: () => {},
    };
  const made = KINDS[item.kind](item, actions);
  setAttribute(made.node, "data-color", item.color ?? null);
  return made;
}
