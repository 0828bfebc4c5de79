// Injected faults: a card for each kind. The server sends the kinds and their fields.

import { button, dialogOf, el, textField } from "./dom.js";
import { allowed, incident } from "./orders.js";
import { run } from "./state.js";

const dialog = dialogOf("Incidents", "Close incidents");

export function incidentsButton() {
  const kinds = run.hello.incidents ?? [];
  return button("Incidents", () => dialog.open(...run.hello.incidents.map(card)), {
    text: "⚡",
    title: "Incidents: inject a fault",
    class: "sign",
    disabled: !kinds.length || !allowed(),
  });
}

function card(kind) {
  const inputs = (kind.fields ?? []).map(input);
  const raise = async event => {
    event.preventDefault();
    const fields = Object.fromEntries(inputs.map(({ name, read }) => [name, read()]));
    if (await incident(kind.name, fields)) dialog.node.close();
  };
  return el("form", { class: "incident", submit: raise },
    el("h3", {}, kind.title ?? kind.name),
    ...inputs.map(({ node }) => node),
    el("button", { "aria-label": `Raise ${kind.title ?? kind.name}` }, "Raise"));
}

function input(field) {
  if (field.kind === "words") return words(field);
  if (field.kind === "text") return text(field);
  const title = field.title ?? field.name;
  const control = field.kind === "choice"
    ? el("select", {}, ...field.choices.map(choice => el("option", { value: choice }, String(choice))))
    : el("input", { type: "number", step: field.kind === "number" ? "any" : 1 });
  if (field.default !== undefined && field.default !== null) control.value = field.default;
  const read = () => field.kind === "choice" ? field.choices[control.selectedIndex] : Number(control.value);
  return { name: field.name, read, node: el("label", {}, el("span", {}, title), control, field.unit ?? "") };
}

// A field of text, with choices.
function text({ name, title, choices }) {
  const offers = el("datalist", { id: `${name}-offers` }, ...choices.map(choice => el("option", { value: choice })));
  const control = textField(null, { list: offers.id, placeholder: choices[0], required: true });
  return { name, read: () => control.value.trim(), node: el("label", {}, el("span", {}, title), control, offers) };
}

// A choice of several words by number.
function words(field) {
  const boxes = field.choices.map(word =>
    el("input", { type: "checkbox", value: word, checked: (field.default ?? []).includes(word) })
  );
  const node = el(
    "fieldset",
    {},
    el("legend", {}, field.title ?? field.name),
    ...boxes.map(box => el("label", {}, box, box.value))
  );
  return { name: field.name, node, read: () => boxes.filter(box => box.checked).map(box => Number(box.value)) };
}
