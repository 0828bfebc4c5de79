// The inputs of a slot, each with a button. The operator presses a button, or holds an input that the machine operates.

import { el, setAttribute } from "./dom.js";
import * as orders from "./orders.js";
import { bindValue } from "./values.js";
import { bitName } from "./words.js";

const HELD_MS = 350; // a button that is pressed longer springs back when it is released

export function inputsOf(slot) {
  if (!slot.inputs?.length) return null;
  const inputs = slot.inputs.map(input => new Input(slot, input));
  const node = el(
    "div",
    { class: "inputs", role: "group", "aria-label": `Inputs of slot ${slot.number}` },
    ...inputs.map(input => input.node)
  );
  return { node, paint: changes => paintInputs(inputs, changes.machine?.[slot.number]?.inputs ?? {}) };
}

function paintInputs(inputs, levels) {
  for (const input of inputs) {
    if (input.name in levels) input.show(levels[input.name]);
  }
}

class Input {
  slot; name; rest; byHand; on; held; timer; springs; // assigned by the constructor

  constructor(slot, { name, title, kind, rest = false, word, bit }) {
    Object.assign(this, {
      slot: slot.number,
      name,
      rest,
      byHand: kind === "button",
      on: false,
      held: false,
      timer: 0,
      springs: false,
    });
    this.node = el(
      "button",
      {
        type: "button",
        class: "input",
        "aria-label": `Press ${title || name}`,
        "aria-pressed": "false",
        "data-kind": kind,
        title: this.byHand
          ? "Click to press or release. Hold to press while you hold it."
          : `Operated by a ${kind}. Click to override the machine, or to return it.`,
        disabled: !orders.allowed(),
        click: () => this.clicked(),
        pointerdown: () => this.down(),
        pointerup: () => this.up(),
        pointerleave: () => this.up(),
      },
      el("span", {}, title || name),
      el("span", { class: "level" })
    );
    if (word === undefined) Object.assign(this.node.dataset, { name: `${slot.number}.input.${name}`, value: "0" });
    else bindValue(this.node, bitName(slot, { name, word, bit }), value => { this.show(value); return null; });
  }

  show(on) {
    this.on = on;
    setAttribute(this.node, "data-value", on === null ? "" : on ? "1" : "0"); // null: unknown
    setAttribute(this.node, "aria-pressed", String(this.byHand ? on !== this.rest : this.held));
  }

  order(on) {
    return orders.press(this.slot, this.name, on);
  }

  async clicked() {
    if (this.springs) this.springs = false;
    else if (this.byHand) this.order(!this.on);
    else if (await this.order(this.held ? null : !this.on)) {
      this.held = !this.held;
      this.show(this.on);
    }
  }

  down() {
    if (!this.byHand) return;
    this.timer = setTimeout(() => { this.springs = true; this.order(!this.rest); }, HELD_MS);
  }

  up() {
    clearTimeout(this.timer);
    this.timer = 0;
    if (this.springs && this.on !== this.rest) this.order(this.rest);
  }
}
