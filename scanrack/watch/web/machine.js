// The machines and cards of the rack: each slot with its inputs and its lamps.

import { at, el, heading } from "./dom.js";
import { inputsOf } from "./inputs.js";
import { lampsOf } from "./lamps.js";
import { railOf } from "./rail.js";
import { onHello, onPaint } from "./state.js";

let parts = []; // functions that paint a part of a slot

function build(hello) {
  parts = [];
  at("machine").replaceChildren(...hello.slots.map(slotOf));
}

function slotOf(slot) {
  const title = heading(`Slot ${slot.number}`, el("span", { class: "soft" }, slot.title || slot.catalog));
  const box = el(
    "article",
    {
      class: slot.machine ? "slot axis" : "slot card",
      "aria-label": `Slot ${slot.number}`,
      "data-slot": slot.number,
    },
    title
  );
  for (const make of [railOf, inputsOf, lampsOf]) {
    const part = make(slot);
    if (!part) continue;
    box.append(part.node);
    parts.push(part.paint);
  }
  return box;
}

onHello(build);
onPaint(changes => { for (const paint of parts) paint(changes); });
