// Completion in a field: a list of texts, to choose with arrows and Tab, or with a click.

import { el, fill, setAttribute, setFlag } from "./dom.js";

const MOST = 8;
let count = 0;

// offer(text before the caret) returns { from, found: [{ text, says }] }; `onChoice` is called after a choice.
export function completing(field, offer, onChoice = () => {}) {
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
    const offered = offer(field.value.slice(0, field.selectionStart)) ?? { found: [] };
    from = offered.from;
    list.replaceChildren(
      ...offered.found.slice(0, MOST).map(({ text, says }, number) =>
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
    [...list.children].forEach((option, index) => option.setAttribute("aria-selected", String(index === number)));
    setAttribute(field, "aria-activedescendant", number < 0 ? null : `${list.id}-${number}`);
  }

  function take() {
    const { text } = list.children[Math.max(chosen, 0)].dataset, rest = field.value.slice(field.selectionStart);
    field.value = `${field.value.slice(0, from)}${text}${rest}`;
    field.setSelectionRange(from + text.length, from + text.length);
    close();
    onChoice();
  }

  function close() {
    list.replaceChildren();
    setFlag(list, "hidden", true);
    field.setAttribute("aria-expanded", "false");
    choose(-1);
  }

  // Handles a key; returns whether the list uses it.
  function keyed(event) {
    const length = list.children.length;
    if (!length || event.isComposing) return false;
    const move = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (move) choose(((chosen < 0 && move < 0 ? 0 : chosen) + move + length) % length);
    else if (event.key === "Tab" && !event.shiftKey || (event.key === "Enter" && chosen >= 0)) take();
    else if (event.key === "Escape") close();
    else return false;
    event.preventDefault();
    event.stopPropagation();
    return true;
  }

  return { list, show, close, keyed };
}

// Returns the names that begin with a word, then the names that contain it.
export function matching(word, names) {
  const requested = word.toUpperCase();
  const begin = [], inside = [];
  for (const candidate of names) {
    const name = candidate.text.toUpperCase();
    if (name === requested) continue;
    if (name.startsWith(requested)) begin.push(candidate);
    else if (requested.length > 1 && name.includes(requested)) inside.push(candidate);
  }
  return [...begin, ...inside];
}
