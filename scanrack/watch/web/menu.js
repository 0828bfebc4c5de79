// The menu of a contact, a coil, an operand or a rung: by right-click, a long press, or the keys m and Shift+F10.

import { ACTIONS, perform } from "./actions.js";
import { at, el, setAttribute } from "./dom.js";
import { tell } from "./notice.js";
import { subjectOf } from "./subject.js";

const HOLD_MS = 500, STILL = 10, EDGE = 8; // time and maximum movement of a long press; margin; CSS pixels

const menu = el("div", { class: "menu", role: "menu", hidden: true, keydown: keyed });
document.body.append(menu);
let subject = null, back = null, hold = 0, held = null;

const items = () => [...menu.querySelectorAll("[role^=menuitem]")];

// Opens the menu of a subject at a position in the window. Afterwards the focus returns to the subject's node.
export function openMenu(menuSubject, x, y) {
  subject = menuSubject;
  back = subject.node;
  fill();
  menu.hidden = false;
  const { width, height } = menu.getBoundingClientRect();
  menu.style.left = `${Math.max(Math.min(x, innerWidth - width - EDGE), EDGE)}px`;
  menu.style.top = `${Math.max(Math.min(y, innerHeight - height - EDGE), EDGE)}px`;
  items()[0].focus({ preventScroll: true });
}

export function menuAt(node) {
  const found = subjectOf(node), { left, bottom } = (found?.node ?? node).getBoundingClientRect();
  found ? openMenu(found, left, bottom) : tell("Go to a contact, a coil or a rung first.");
}

function fill() {
  const { tag, names, rung } = subject, operands = names.length > 1 && tag ? names : [];
  setAttribute(menu, "aria-label", tag ?? `Rung ${rung}`);
  menu.replaceChildren(
    el("div", { class: "of", "aria-hidden": "true" }, tag ?? rung),
    operands.length ? el("div", { role: "group", "aria-label": "Operand" }, ...operands.map(operand)) : "",
    ...["tag", "rung"]
      .filter(kind => subject[kind])
      .map(kind =>
        el(
          "div",
          { role: "group", "aria-label": kind === "tag" ? "Tag" : "Rung" },
          ...ACTIONS.filter(({ of, fits }) => of === kind && (!fits || fits())).map(itemOf)
        )
      )
  );
}

// An operand of a block. A click shows the menu of this tag.
const operand = name =>
  el(
    "button",
    {
      type: "button",
      role: "menuitemradio",
      tabindex: -1,
      "aria-checked": String(name === subject.tag),
      click: () => {
        subject = { ...subject, tag: name };
        fill();
        items()
          .find(item => item.textContent === name)
          .focus();
      },
    },
    name
  );

function itemOf(action) {
  const obstacle = action.lacks(subject), checked = action.checked?.(subject);
  return el(
    "button",
    {
      type: "button",
      role: checked === undefined ? "menuitem" : "menuitemcheckbox",
      tabindex: -1,
      "aria-checked": checked === undefined ? null : String(checked),
      "aria-disabled": obstacle ? "true" : null,
      "aria-keyshortcuts": action.key,
      "data-key": action.key,
      click: () => {
        if (!obstacle) {
          close();
          perform(action, subject);
        }
      },
    },
    el("span", {}, action.text(subject)),
    obstacle ? el("small", {}, obstacle) : el("kbd", { "aria-hidden": "true" }, action.key)
  );
}

function close(returns = true) {
  if (menu.hidden) return;
  menu.hidden = true;
  const node = back?.isConnected
    ? back
    : back?.dataset?.element && at("program").querySelector(`[data-element="${CSS.escape(back.dataset.element)}"]`);
  if (returns) node?.focus({ preventScroll: true });
}

function keyed(event) {
  const all = items(),
    here = all.indexOf(document.activeElement),
    to = { ArrowDown: here + 1, ArrowUp: here - 1, Home: 0, End: -1 }[event.key];
  event.stopPropagation();
  if (event.key === "Enter" || event.key === " ") return; // the button handles it
  event.preventDefault();
  if (to !== undefined) all.at(to % all.length).focus();
  else if (event.key === "Escape" || event.key === "Tab") close();
  else all.find(item => item.dataset.key === event.key)?.click();
}

document.addEventListener("contextmenu", event => {
  const found = subjectOf(event.target);
  if (!found || event.shiftKey && event.button === 2) return; // with Shift the browser's menu
  event.preventDefault();
  if (menu.hidden)
    event.clientX || event.clientY ? openMenu(found, event.clientX, event.clientY) : menuAt(event.target);
});

document.addEventListener("pointerdown", event => {
  if (!menu.contains(event.target)) close(false);
  held = null;
  clearTimeout(hold);
  const found = event.pointerType === "touch" && event.isPrimary && subjectOf(event.target);
  if (!found) return;
  const { clientX: x, clientY: y } = event;
  held = { x, y };
  hold = setTimeout(() => { held.opened = true; openMenu(found, x, y); }, HOLD_MS);
}, true);
document.addEventListener(
  "pointermove",
  event => {
    if (held && Math.hypot(event.clientX - held.x, event.clientY - held.y) > STILL) clearTimeout(hold);
  },
  true
);
for (const kind of ["pointerup", "pointercancel"]) document.addEventListener(kind, () => clearTimeout(hold), true);
document.addEventListener("click", event => { // the click at the end of a long press
  if (!held?.opened || menu.contains(event.target)) return;
  held = null;
  event.preventDefault();
  event.stopPropagation();
}, true);
addEventListener("blur", () => close(false));
addEventListener("resize", () => close(false));
