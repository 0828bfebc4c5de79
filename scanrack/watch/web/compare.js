// Compare with: another recording in the same scan. The band says what differs, and rungs that differ are marked.

import { at, button, dialogOf, el, setAttribute, setFlag, setText } from "./dom.js";
import { count, shown } from "./format.js";
import { tell } from "./notice.js";
import { beginBeside, endBeside } from "./besidelanes.js";
import { lookAt } from "./scrub.js";
import { ask } from "./source.js";
import { onHello, onPaint, run } from "./state.js";

const MOST = 16, SEARCHES = 64; // tags in the band; questions for one difference

const dialog = dialogOf("Compare with", "Close the list");
const title = el("strong", {}), summary = el("span", {}), list = el("ul", { "aria-label": "Tags that differ" });

let name = null;

export const compareButton = () => button("Compare with a recording", choose, { text: "Compare", title: "Compare with a branch or another recording in the folder", hidden: Boolean(run.hello.shared) });

async function choose() {
  try {
    const { recordings } = await ask("recordings");
    dialog.open(recordings.length ? el("ul", { class: "choices" }, ...recordings.map(each => el("li", {}, button(`Compare with ${each}`, () => compare(each), { text: each })))) : el("p", {}, "There is no other recording in the folder."));
  } catch (refused) {
    tell(refused.message);
  }
}

// Compares with a recording of the folder, if it is there.
export async function compareWith(other) {
  const { recordings } = await ask("recordings").catch(() => ({ recordings: [] }));
  if (recordings.includes(other)) await compare(other);
}

async function compare(other) {
  dialog.node.close();
  run.other = null;
  try {
    name = (await ask("compare", { with: other })).with;
  } catch (refused) {
    name = null;
    tell(refused.message);
  }
  name ? beginBeside() : endBeside();
  paint(run.other);
}

// The next scan in which the words differ otherwise than in the scan before.
export async function toDifference(way) {
  if (!name) return tell("Compare with a recording first.");
  try {
    for (let from = run.scan, searches = 0; searches < SEARCHES; searches += 1) {
      const { scan, searched } = await ask("difference", { from, way });
      if (scan !== null) return lookAt(scan);
      if (searched === from) break;
      from = searched;
    }
    tell(`No other difference of the words is known ${way > 0 ? "after" : "before"} scan ${count(run.scan)}.`);
  } catch (refused) {
    tell(refused.message);
  }
}

function build() {
  name = null;
  endBeside();
  at("compared").replaceChildren(
    el("div", { class: "row" }, title, summary,
      el("span", { class: "tools" },
        button("Previous difference", () => toDifference(-1), { text: "◀", title: "The previous difference of the words (D)", class: "sign" }),
        button("Next difference", () => toDifference(1), { text: "▶", title: "The next difference of the words (d)", class: "sign" }),
        button("Compare no longer", () => compare(null), { text: "✕", class: "sign" }))),
    list);
  paint();
}

const some = (number, thing) => `${number} ${thing}${number === 1 ? "" : "s"}`;

function paint(other) {
  at("compared").hidden = !name;
  const power = name ? other?.power ?? {} : {};
  for (const row of at("program").querySelectorAll("[data-at]")) setFlag(row, "data-differs", row.dataset.at in power);
  if (!name || !other) return;
  const tags = Object.entries(other.tags), words = Object.values(other.words).reduce((sum, each) => sum + Object.keys(each).length, 0);
  setText(title, name);
  setAttribute(at("compared"), "data-words", String(words));
  const differing = [[words, "word"], [tags.length, "tag"], [Object.keys(power).length, "rung"]].filter(([number]) => number);
  setText(summary, !other.there ? "does not have this scan" : other.known === false ? "is not known so far yet" :
    differing.length ? `differs here in ${differing.map(([number, thing]) => some(number, thing)).join(", ")}` : "does not differ in this scan");
  list.replaceChildren(...tags.slice(0, MOST).map(([tag, value]) => el("li", { "data-tag": tag }, `${tag} ${shown(run.tags[tag])}, there ${shown(value)}`)),
    ...(tags.length > MOST ? [el("li", {}, `and ${tags.length - MOST} more`)] : []));
}

onHello(build);
onPaint(changes => { if (name && (changes.other || changes.scan !== undefined || changes.tags || changes.power)) paint(run.other); });
