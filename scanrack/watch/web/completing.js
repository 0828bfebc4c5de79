// Completes what is typed in a field: a list beside it, chosen from by arrows and Tab, or clicked.

import { el, fill, setAttribute, setFlag } from "./dom.js";

const MOST = 8;
let count = 0;

// offer(text before the caret) gives { from, found: [{ text, says }] }; `put` is called after a choice.
export function completing(field, offer, put = () => {}) {
  const list = el("ul", {
    class: "offers",
    role: "listbox",
    id: `offers-${++count}`,
    "aria-label": "Completion",
    hidden: true,
  });
  let from = 0, chosen = -1;
  fill(field, { role: "combobox", "aria-autocomplete": "list", "aria-controls": list.id, "aria-expanded": "false" });

  function show() {
    const now = offer(field.value.slice(0, field.selectionStart)) ?? { found: [] };
    from = now.from;
    list.replaceChildren(
      ...now.found.slice(0, MOST).map(({ text, says }, number) =>
        el(
          "li",
          {
            role: "option",
            id: `${list.id}-${number}`,
            "data-text": text,
            "aria-selected": "false",
            pointerdown: event => {
              event.preventDefault();
              choose(number);
              take();
            },
          },
          el("b", {}, text),
          says ? el("span", { class: "soft" }, says) : null
        )
      )
    );
    choose(-1);
    const open = list.children.length > 0;
    setFlag(list, "hidden", !open);
    field.setAttribute("aria-expanded", String(open));
  }

  function choose(number) {
    chosen = number;
    [...list.children].forEach((each, place) => each.setAttribute("aria-selected", String(place === number)));
    setAttribute(field, "aria-activedescendant", number < 0 ? null : `${list.id}-${number}`);
  }

  function take() {
    const { text } = list.children[Math.max(chosen, 0)].dataset, behind = field.value.slice(field.selectionStart);
    field.value = `${field.value.slice(0, from)}${text}${behind}`;
    field.setSelectionRange(from + text.length, from + text.length);
    close();
    put();
  }

  function close() {
    list.replaceChildren();
    setFlag(list, "hidden", true);
    field.setAttribute("aria-expanded", "false");
    choose(-1);
  }

  // Whether the list has a use for a key.
  function keyed(event) {
    const many = list.children.length;
    if (!many || event.isComposing) return false;
    const move = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (move) choose(((chosen < 0 && move < 0 ? 0 : chosen) + move + many) % many);
    else if (event.key === "Tab" && !event.shiftKey || (event.key === "Enter" && chosen >= 0)) take();
    else if (event.key === "Escape") close();
    else return false;
    event.preventDefault();
    event.stopPropagation();
    return true;
  }

  return { list, show, close, keyed };
}

// Those of some names that begin with a word, then those that contain it.
export function matching(word, names) {
  const requested = word.toUpperCase();
  const begin = [], inside = [];
  for (const each of names) {
    const name = each.text.toUpperCase();
    if (name === requested) continue;
    if (name.startsWith(requested)) begin.push(each);
    else if (requested.length > 1 && name.includes(requested)) inside.push(each);
  }
  return [...begin, ...inside];
}
