// The layout of the page: gutters between its parts, and tabs of the lists. The browser keeps it for each rack.

import { at, el, goTo, setAttribute, setFlag } from "./dom.js";
import { keep, kept } from "./kept.js";
import { onHello } from "./state.js";

const PANELS = {
  events: ["Events"],
  watch: ["Watch", "Watch table"],
  words: ["Words", "Words and bits"],
  panel: ["Panel", "Operator panel"],
};
const LEAST = 20, MOST = 80, STEP = 2; // percent of the page
const MARGIN = 12; // CSS pixels beside the parts

// Gutters: the CSS unit of a part's size, its present share, keys that change it, and the share at the pointer.
const GUTTERS = {
  program: {
    unit: "%",
    now: node => node.offsetWidth / (innerWidth - 2 * MARGIN),
    keys: { ArrowLeft: -STEP, ArrowRight: STEP },
    at: ({ clientX }) => (clientX - MARGIN) / (innerWidth - 2 * MARGIN),
  },
  strip: {
    unit: "vh",
    now: node => node.offsetHeight / innerHeight,
    keys: { ArrowUp: STEP, ArrowDown: -STEP },
    at: ({ clientY }) => (innerHeight - clientY) / innerHeight,
  },
};

const tabs = Object.entries(PANELS).map(([id, [title, whole = title]]) =>
  el(
    "button",
    {
      type: "button",
      role: "tab",
      id: `${id}-tab`,
      "aria-controls": id,
      "aria-label": whole,
      click: () => showPanel(id),
      keydown: event => goTo(event, tabs, { ArrowLeft: -1, ArrowRight: 1 }),
    },
    title
  )
);
let layout = {};

at("tabs").replaceChildren(...tabs);
for (const [name, { now, keys, at: shareAt }] of Object.entries(GUTTERS)) {
  const gutter = at(`${name}-gutter`), percent = () => 100 * now(at(name));
  gutter.addEventListener("pointerdown", event => {
    event.preventDefault();
    gutter.setPointerCapture(event.pointerId);
  });
  gutter.addEventListener("pointermove", event => {
    if (gutter.hasPointerCapture(event.pointerId)) set(name, 100 * shareAt(event));
  });
  gutter.addEventListener("dblclick", () => set(name));
  gutter.addEventListener("keydown", event => {
    if (!keys[event.key]) return;
    event.preventDefault();
    set(name, percent() + keys[event.key]);
  });
  new ResizeObserver(() => setAttribute(gutter, "aria-valuenow", Math.round(percent()))).observe(at(name));
}

onHello(() => {
  layout = kept("layout", {});
  apply();
});

// Sets the size of a part; without a percentage it has the size in the style sheet.
function set(name, percent) {
  layout[name] = percent && Math.min(Math.max(Math.round(percent * 10) / 10, LEAST), MOST);
  keep("layout", layout);
  apply();
}

// Shows a list: events, watch, words or panel.
export function showPanel(id) {
  layout.panel = id;
  keep("layout", layout);
  apply();
}

function apply() {
  for (const [name, { unit }] of Object.entries(GUTTERS)) {
    const share = Number.isFinite(layout[name]) ? layout[name] + unit : "";
    document.documentElement.style.setProperty(`--${name}`, share);
  }
  const chosen = layout.panel in PANELS ? layout.panel : "events";
  for (const id of Object.keys(PANELS)) {
    const tab = at(`${id}-tab`);
    setFlag(at(id), "hidden", id !== chosen);
    setAttribute(tab, "aria-selected", String(id === chosen));
    tab.tabIndex = id === chosen ? 0 : -1;
  }
}
