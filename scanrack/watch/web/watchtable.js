// The watch table: tags chosen by the user, each with its radix. The browser keeps the table of each rack.

import { at, button, el, heading, optionsOf, setFlag, textButton, textField } from "./dom.js";
import { RADIXES, inRadix } from "./format.js";
import { keep, kept } from "./kept.js";
import { ask } from "./source.js";
import { select, selected } from "./selection.js";
import { onProgram, run } from "./state.js";
import { brief, treeOf } from "./tree.js";
import { bindValue, isSame, learn, rewrite, unbindIn } from "./values.js";
import { nameOf, paintAddressed } from "./words.js";

let rows = []; // { tag, radix }

const field = textField("Tag to watch", { list: "tags", placeholder: "Add a tag", keydown: keyed });
const knownTags = el("datalist", { id: "tags" });
const body = el("tbody");
const table = el(
  "table",
  { class: "watch" },
  el("colgroup", {}, ...Array.from({ length: 4 }, () => el("col"))),
  el(
    "thead",
    { class: "hidden" },
    el("tr", {}, ...["Tag", "Value", "Radix", "Remove"].map(text => el("th", {}, text)))
  ),
  body
);
const empty = el("p", { class: "soft" }, "Add tags to see their values here.");

onProgram(hello => {
  rows = storedRows();
  knownTags.replaceChildren(...(hello.tags ?? []).map(tag => el("option", { value: tag.name })));
  at("watch").replaceChildren(heading("Watch"),
    el("div", { class: "line" }, field, knownTags, button("Add to watch table", add, { text: "Add" })), table, empty);
  show();
});

export const alsoWatched = []; // names that other parts of the page show

export const watchedTags = () => rows.map(row => row.tag);
export const isWatched = tag => rows.some(row => isSame(row.tag, tag));

const storedRows = () => kept("watch", []).filter(row => typeof row?.tag === "string")
  .map(({ tag, radix }) => ({ tag, radix: RADIXES.includes(radix) ? radix : "decimal" }));

const typeOf = tag => run.hello.tags?.find(each => each.name === tag)?.type ?? "DINT";

function show() {
  unbindIn(body);
  body.replaceChildren(...rows.flatMap(rowOf));
  setFlag(empty, "hidden", rows.length > 0);
  sendWatched();
}

function rowOf(row) {
  const toText = value => inRadix(value, row.radix, typeOf(row.tag)),
    value = el("output", { class: "figure" }, "–"),
    tree = treeOf(row.tag, toText, true);
  bindValue(value, row.tag, brief(toText));
  const radix = el(
    "select",
    {
      "aria-label": `Radix of ${row.tag}`,
      change: () => {
        row.radix = radix.value;
        keep("watch", rows);
        rewrite(row.tag, value, tree);
      },
    },
    ...optionsOf(RADIXES, row.radix)
  );
  return [
    el(
      "tr",
      { class: "tag" },
      el(
        "th",
        { scope: "row" },
        textButton(nameOf(row.tag), () => select({ tag: row.tag }), "Write, force, why")
      ),
      el("td", { class: "value" }, value),
      el("td", {}, radix),
      el(
        "td",
        {},
        button(
          `Remove ${row.tag}`,
          () => {
            rows = rows.filter(each => each !== row);
            keep("watch", rows);
            show();
          },
          { text: "✕", title: "Remove from the table", class: "sign" }
        )
      )
    ),
    el("tr", { class: "members" }, el("td", { colspan: 4 }, tree)),
  ];
}

export function addToWatch(tag) {
  if (!tag || isWatched(tag)) return;
  rows.push({ tag, radix: "decimal" });
  keep("watch", rows);
  show();
}

function add() {
  addToWatch(field.value.trim());
  field.value = "";
}

function keyed(event) {
  if (event.key === "Enter") add();
}

// Tells the server which tags are shown besides those of the routine: the tags of the table, and the selected ones.
export async function sendWatched(more = selected.names) {
  try {
    const { unknown, addresses } = await ask("watch", {
      tags: [...new Set([...rows.map(row => row.tag), ...alsoWatched, ...more])],
    });
    learn(addresses);
    paintAddressed();
    for (const [place, row] of rows.entries())
      body.querySelectorAll("tr.tag")[place]?.toggleAttribute("data-unknown", unknown.includes(row.tag));
  } catch { /* repeated after the next hello */ }
}
