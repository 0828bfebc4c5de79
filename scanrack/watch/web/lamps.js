// The lamps of a card, which are its output points by name.

import { el } from "./dom.js";
import { bindLevel } from "./values.js";
import { bitName } from "./words.js";

export function lampsOf(slot) {
  if (!slot.lamps?.length) return null;
  const lamps = slot.lamps.map(lamp => {
    const level = el("span", { class: "level" }, "0");
    const node = el(
      "span",
      { class: "lamp", title: lamp.address ?? "" },
      el("span", {}, lamp.title || lamp.name),
      level
    );
    bindLevel(node, level, bitName(slot, lamp));
    return node;
  });
  return {
    node: el("div", { class: "lamps", role: "group", "aria-label": `Lamps of slot ${slot.number}` }, ...lamps),
    paint: () => {},
  };
}
