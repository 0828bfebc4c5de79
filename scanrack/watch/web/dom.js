// Builds and changes elements. Text from a rack is inserted as text, never as markup.

const SVG = "http://www.w3.org/2000/svg";

/**
 * Sets attributes, listeners and children of an element. A property that is a function listens to its event.
 * @template {Element} T
 * @param {T} node
 * @param {Record<string, any>} properties
 * @param {any[]} children
 */
export function fill(node, properties, children = []) {
  for (const [name, value] of Object.entries(properties)) {
    if (typeof value === "function") node.addEventListener(name, value);
    else if (value === true) node.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) node.setAttribute(name, value);
  }
  node.append(...children.filter(child => child !== null && child !== undefined));
  return node;
}

/**
 * An HTML element, see `fill`.
 * An output is a live region by default, but values that change 30 times per second must not be read aloud.
 * @param {string} name
 * @param {Record<string, any>} properties
 * @param {...any} children
 * @returns {any}
 */
export const el = (name, properties = {}, ...children) =>
  fill(document.createElement(name), name === "output" ? { "aria-live": "off", ...properties } : properties, children);

/**
 * An SVG element.
 * @param {string} name
 * @param {Record<string, any>} properties
 * @param {...any} children
 * @returns {any}
 */
export const svg = (name, properties = {}, ...children) =>
  fill(document.createElementNS(SVG, name), properties, children);

/** @returns {any} */
export const at = id => document.getElementById(id);

export function setText(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

// Sets an attribute; null removes it.
export function setAttribute(node, name, value) {
  if (value === null) { if (node.hasAttribute(name)) node.removeAttribute(name); }
  else if (node.getAttribute(name) !== String(value)) node.setAttribute(name, value);
}

export const setFlag = (node, name, on) => setAttribute(node, name, on ? "" : null);

/**
 * A button with an icon or a word on it; `name` is its accessible name.
 * @param {string} name
 * @param {(event: any) => any} press
 * @param {Record<string, any>} properties
 */
export function button(name, press, { text = name, title = name, ...more } = {}) {
  return el("button", { type: "button", "aria-label": name, title, click: press, ...more }, text);
}

// A button that looks like its text.
export const textButton = (text, press, title = null) =>
  el("button", { type: "button", class: "plain", title, click: press }, text);

// A field for a line of text, without completion and correction by the browser.
export const textField = (name, properties) =>
  el("input", { type: "text", "aria-label": name, autocomplete: "off", spellcheck: "false", ...properties });

export const optionsOf = (names, chosen) =>
  names.map(name => el("option", { value: name, selected: name === chosen }, name));

// A figure under its title; returns the node, and the output in it.
export function reading(title, kind, hint = title) {
  const value = el("output", { class: "figure" }, "–");
  const node = el("div", { class: `reading ${kind}`, title: hint }, el("span", { class: "title" }, title), value);
  return { node, value };
}

// A dialog with a heading; open(...parts) shows it with these parts and a button that closes it.
export function dialogOf(name, closes) {
  const node = el("dialog", { "aria-label": name });
  document.body.append(node);
  return { node, open(...parts) {
    node.replaceChildren(
      el("h2", {}, name),
      ...parts,
      el("form", { method: "dialog" }, el("button", { "aria-label": closes }, "Close"))
    );
    node.showModal();
  } };
}

// Moves the focus from a tab or choice to the one of an arrow key, and clicks it.
export function goTo(event, all, moves) {
  const move = moves[event.key];
  if (!move) return;
  event.preventDefault();
  const next = all[(all.indexOf(event.target) + move + all.length) % all.length];
  next.focus();
  next.click();
}

// Returns the drawing of an SVG text from the server.
export function drawing(text) {
  const read = new DOMParser().parseFromString(text, "image/svg+xml");
  return document.importNode(read.documentElement, true);
}

export const heading = (text, ...beside) => el("h2", { "aria-label": text }, el("span", {}, text), ...beside);
