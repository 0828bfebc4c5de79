// The comparison with another trace in the same scan. The band lists differences, and rungs that differ are marked.

import { at, button, dialogOf, el, setAttribute, setFlag, setText } from "./dom.js";
import { clock, count, many, shown } from "./format.js";
import { tell } from "./notice.js";
import { order } from "./orders.js";
import { beginBeside, endBeside } from "./besidelanes.js";
import { lookAt } from "./scrub.js";
import { ask } from "./source.js";
import { onHello, onPaint, run } from "./state.js";
import { bitName } from "./words.js";

const MOST = 16, SEARCHES = 1000, NAMED = 3; // tags in the band; questions for a difference; names in its line

const dialog = dialogOf("Compare with", "Close the list");
const title = el("strong", {}), summary = el("span", {}), list = el("ul", { "aria-label": "Tags that differ" });

const sinceLine = button("First difference", () => { if (typeof first === "number") lookAt(first); },
  { class: "plain", title: "Look at the first difference" });

let name = null;
let first; // the scan of the first difference; null without one, undefined during the search
let differs = ""; // the names that differ in this scan

export const compareButton = () =>
  button("Compare with a recording", choose, {
    text: "Compare",
    title: "Compare with a branch or another recording in the folder",
    hidden: Boolean(run.hello.shared),
  });

async function choose() {
  const { recordings } = await order("recordings") ?? {};
  const none = el("p", {}, "The folder has no other recording of this rack.");
  if (recordings) dialog.open(recordings.length ? el("ul", { class: "choices" }, ...recordings.map(choiceOf)) : none);
}

const RELATIONS = { parent: () => "the parent of this branch", branch: scan => `a branch from scan ${count(scan)}` };

const choiceOf = ({ name: other, date, relation, scan }) => el("li", {},
  button(`Compare with ${other}`, () => compare(other, true), { text: other }),
  el("span", { class: "soft" }, ` ${date.slice(0, 16).replace("T", " ")} `),
  relation && el("strong", {}, RELATIONS[relation](scan)));

// Compares with a trace in the folder, if it exists. The page stays at its scan.
export async function compareWith(other) {
  const { recordings } = await ask("recordings").catch(() => ({ recordings: [] }));
  if (recordings.some(recording => recording.name === other)) await compare(other);
}

// Compares with another trace, or ends the comparison for null; `goes` opens the first difference.
async function compare(other, opensFirst = false) {
  dialog.node.close();
  run.other = null;
  name = (await order("compare", { with: other }))?.with ?? null;
  name ? beginBeside() : endBeside();
  first = undefined;
  paint(run.other);
  if (name) await toFirst(opensFirst);
}

// Finds the first difference of the words for the title line.
async function toFirst(opensFirst) {
  const mine = name;
  try {
    const scan = await search(-1, 1);
    if (mine !== name) return;
    first = scan;
    if (scan !== null && opensFirst) await lookAt(scan);
    paint(run.other);
  } catch { /* the line then does not have it */ }
}

// `direction` is 1 forwards, -1 backwards.
async function search(from, direction) {
  for (let searches = 0; searches < SEARCHES; searches += 1) {
    const { scan, searched } = await ask("difference", { from, way: direction });
    if (scan !== null || searched === from) return scan;
    from = searched;
  }
  return null;
}

// Shows the next scan in which other words differ than in the scan before.
export async function toDifference(direction) {
  if (!name) return tell("Compare with a recording first.");
  try {
    const scan = await search(run.scan, direction);
    if (scan !== null) return lookAt(scan);
    tell(`No other known difference ${direction > 0 ? "after" : "before"} scan ${count(run.scan)}.`);
  } catch (refused) {
    tell(refused.message);
  }
}

function build() {
  name = null;
  endBeside();
  at("compared").replaceChildren(
    el(
      "div",
      { class: "row" },
      title,
      sinceLine,
      summary,
      el(
        "span",
        { class: "tools" },
        button("Previous difference", () => toDifference(-1), {
          text: "◀",
          title: "Previous difference (D)",
          class: "sign",
        }),
        button("Next difference", () => toDifference(1), {
          text: "▶",
          title: "Next difference (d)",
          class: "sign",
        }),
        button("Compare no longer", () => compare(null), { text: "✕", class: "sign" })
      )
    ),
    list
  );
  paint();
}

function paint(other) {
  at("compared").hidden = !name;
  const power = name ? other?.power ?? {} : {};
  for (const row of at("program").querySelectorAll("[data-at]")) setFlag(row, "data-differs", row.dataset.at in power);
  if (!name || !other) return;
  const tags = Object.entries(other.tags),
    words = Object.values(other.words).reduce((sum, differing) => sum + Object.keys(differing).length, 0);
  setText(title, name);
  if (run.scan === first) differs = namesOf(other).join(", ");
  setText(sinceLine, sinceText());
  sinceLine.disabled = typeof first !== "number";
  setAttribute(at("compared"), "data-words", String(words));
  const differing = [
    [words, "word"],
    [tags.length, "tag"],
    [Object.keys(power).length, "rung"],
  ].filter(([number]) => number);
  setText(
    summary,
    !other.there
      ? "It does not have this scan."
      : other.known === false
        ? "Its values in this scan are being computed."
        : differing.length
          ? `It differs here in ${differing.map(([number, noun]) => many(number, noun)).join(", ")}.`
          : "No differences in this scan."
  );
  list.replaceChildren(
    ...tags
      .slice(0, MOST)
      .map(([tag, value]) => el("li", { "data-tag": tag }, `${tag} ${shown(run.tags[tag])}, there ${shown(value)}`)),
    ...(tags.length > MOST ? [el("li", {}, `and ${tags.length - MOST} more`)] : [])
  );
}

function sinceText() {
  if (first === undefined) return "is being searched for the first difference …";
  if (first === null) return "has the same words in all common scans.";
  const when = `scan ${count(first)}, ${clock(first * run.hello.period_ns)}`;
  return `differs since ${when}${differs ? `: ${differs}` : ""}.`;
}

// The names that differ in a scan: tags, otherwise bits and words.
function namesOf({ tags, words }) {
  const bits = run.hello.slots.flatMap(slot => Object.entries(words[slot.number] ?? {}).flatMap(([place, there]) => {
    const here = run.words[slot.number]?.[place], inputs = slot.words.in, output = Number(place) >= inputs;
    const word = Number(place) - (output ? inputs : 0),
      own = slot.bits.filter(bit => bit.word === word && bit.output === output);
    const named = own.filter(({ bit }) => (here ^ there) >> bit & 1).map(bit => bitName(slot, bit));
    return named.length ? named : [`Local:${slot.number}:${output ? "O" : "I"}.Data[${word}]`];
  }));
  return [...new Set([...Object.keys(tags), ...bits])].slice(0, NAMED);
}

onHello(build);
onPaint(changes => {
  if (name && (changes.other || changes.scan !== undefined || changes.tags || changes.power)) paint(run.other);
});
