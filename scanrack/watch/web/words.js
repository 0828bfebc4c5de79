// The words and bits of each slot by name, with the section of the manual, and the rules that have set error bits.

import { at, el, heading, setFlag, setText } from "./dom.js";
import { inRadix } from "./format.js";
import { select } from "./selection.js";
import { onHello, onPaint, run } from "./state.js";
import { bindLevel, bindValue, eachShown, learn, setValue, valueOf } from "./values.js";

let slots = new Map(); // number -> { bits, words, values }

// The name of a bit for scripts: by its meaning, or else its address.
export const bitName = (slot, bit) =>
  bit.name && !bit.address?.startsWith(bit.name) ? `${slot.number}.${bit.name}` : bit.address;

// The program's alias for an address.
export const aliasOf = address => run.hello.tags?.find(each => each.address === address)?.name;

// The name for an address: the program's alias, or else the bit's meaning. Other names are returned unchanged.
export const nameOf = address => aliasOf(address) ?? bitAt(address)?.meaning ?? address;

// The bit of a module at an address.
export const bitAt = address => run.hello.slots.flatMap(slot => slot.bits).find(bit => bit.address === address);

// Replaces addresses in a text by names.
export const named = text => text.replace(/Local:\d+:[IO]\.Data\[\d+\](\.\d+)?|\b[IO]:\d+\.\d+(\/\d+)?/g, nameOf);

const nameOfWord = (slot, output, word) => `Local:${slot.number}:${output ? "O" : "I"}.Data[${word}]`;

function build(hello) {
  slots = new Map(hello.slots.map(slot => [String(slot.number), slot]));
  learn(Object.fromEntries(hello.slots.flatMap(slot => slot.bits.map(bit => [bitName(slot, bit), bit.address]))));
  learn(Object.fromEntries((hello.tags ?? []).filter(each => each.address).map(each => [each.name, each.address])));
  at("words").replaceChildren(heading("Words and bits"), ...hello.slots.map(slotOf));
}

function slotOf(slot) {
  const bits = output => slot.bits.filter(bit => Boolean(bit.output) === output);
  return el("details", { class: "slot", open: true, "data-slot": slot.number },
    el("summary", {}, `Slot ${slot.number} `, el("span", { class: "soft" }, slot.catalog)),
    group("Inputs", slot, bits(false)), group("Outputs", slot, bits(true)), valuesOf(slot), wordsOf(slot));
}

function group(title, slot, bits) {
  if (!bits.length) return null;
  return el("div", { class: "bits", role: "group", "aria-label": `${title} of slot ${slot.number}` },
    el("h3", {}, title), ...bits.map(bit => bitOf(slot, bit)));
}

function bitOf(slot, bit) {
  const level = el("span", { class: "level" }, "0"), name = bitName(slot, bit);
  const node = el(
    "button",
    {
      type: "button",
      class: "bit",
      "data-kind": bit.error ? "error" : null,
      title: [bit.meaning, bit.section, bit.address].filter(Boolean).join("\n"),
      click: () => select({ tag: bit.address ?? name }),
    },
    el("span", {}, label(bit)),
    level
  );
  bindLevel(node, level, name);
  return node;
}

const label = bit => bit.name || bit.address;

function valuesOf(slot) {
  if (!slot.values?.length) return null;
  return el("dl", { class: "values" }, ...slot.values.flatMap(value => {
    const output = el("dd", { class: "figure" });
    bindValue(output, `${slot.number}.${value.name}`);
    return [el("dt", {}, value.title ?? value.name), output];
  }));
}

function wordsOf(slot) {
  const { in: ins = 0, out: outs = 0 } = slot.words ?? {};
  if (!ins && !outs) return null;
  const row = word =>
    el(
      "tr",
      {},
      el("th", { scope: "row" }, String(word)),
      ...cells(slot, false, word, ins),
      ...cells(slot, true, word, outs)
    );
  const rows = Array.from({ length: Math.max(ins, outs) }, (_, word) => row(word));
  return el(
    "details",
    { class: "raw" },
    el("summary", {}, "Words"),
    el(
      "table",
      {},
      el("thead", {}, el("tr", {}, ...["", "in", "", "out", ""].map(text => el(text ? "th" : "td", {}, text)))),
      el("tbody", {}, ...rows)
    )
  );
}

function cells(slot, output, word, most) {
  if (word >= most) return [el("td"), el("td")];
  const hex = el("td", { class: "figure" }),
    decimal = el("td", { class: "figure" }),
    name = nameOfWord(slot, output, word);
  bindValue(hex, name, value => inRadix(value, "hex", "INT"));
  bindValue(decimal, name, value => String(value));
  return [hex, decimal];
}

function paint(changes) {
  for (const [number, words] of Object.entries(changes.words ?? {})) paintSlot(slots.get(number), words);
  if (changes.words) paintAddressed();
  for (const [number, values] of Object.entries(changes.values ?? {})) {
    for (const [name, value] of Object.entries(values)) setValue(`${number}.${name}`, value);
  }
  if (changes.rules || (changes.words && run.rules?.length)) paintRules();
}

const signed = word => (word & 0x8000 ? word - 0x10000 : word);

function paintSlot(slot, words) {
  if (!slot) return;
  const ins = slot.words.in, wordAt = bit => words[bit.word + (bit.output ? ins : 0)];
  for (const bit of slot.bits) setValue(bitName(slot, bit), Boolean(wordAt(bit) >> bit.bit & 1));
  for (const lamp of slot.lamps ?? [])
    setValue(bitName(slot, lamp), Boolean((wordAt({ output: true, ...lamp }) >> lamp.bit) & 1));
  words.forEach((word, place) =>
    setValue(nameOfWord(slot, place >= ins, place >= ins ? place - ins : place), signed(word))
  );
}

// Shows words and bits in nodes that are bound to other names, as in the watch table. Frames have the program's tags.
export function paintAddressed() {
  eachShown((name, address) => {
    const [, slot, image, word, bit] = /^Local:(\d+):([IO])\.Data\[(\d+)\](?:\.(\d+))?$/.exec(address) ?? [];
    const words = run.words[slot], place = Number(word) + (image === "O" ? slots.get(slot)?.words.in : 0);
    if (words?.[place] === undefined || name in run.tags) return;
    setValue(name, bit === undefined ? signed(words[place]) : Boolean(words[place] >> Number(bit) & 1));
  });
}

// Shows the rules that have set those error bits that are on.
function paintRules() {
  const rules = at("rules"); // drawn over the lists, so that nothing moves
  const fired = (run.rules ?? []).filter(rule => valueOf(`${rule.slot}.${rule.bit}`)),
    many = run.hello.slots.length > 1;
  const sentences = new Set(
    fired.map(
      rule =>
        `⚠ ${many ? `${rule.slot}: ` : ""}${rule.bit}: ${rule.text} ` +
          `[${[rule.rule, rule.section].filter(Boolean).join(", ")}]`
    )
  );
  setFlag(rules, "hidden", !sentences.size);
  setText(rules, [...sentences].join("\n"));
}

onHello(build);
onPaint(paint);
