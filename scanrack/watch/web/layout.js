// Where the parts are: gutters between them, tabs of the lists. This browser keeps both for each rack.

import { at, el, goTo, setAttribute, setFlag } from "./dom.js";
import { keep, kept } from "./kept.js";
import { onHello, run } from "./state.js";

const PANELS = {
  events: ["Events"],
  watch: ["Watch", "Watch table"],
  words: ["Words", "Words and bits"],
  panel: ["Panel", "Operator panel"],
};
const LEAST = 20, MOST = 80, STEP = 2; // percent of the page

// What a gutter sets: the percentage at first, keys that add to it, and the percentage at a place of the pointer.
const GUTTERS = {
  program: {
    first: 62,
    keys: { ArrowLeft: -STEP, ArrowRight: STEP },
    at: ({ clientX }, { left, width }) => (clientX - left) / width,
  },
  strip: {
    first: 22,
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

const key = () => `scanrack layout ${run.hello.path}`;

at("tabs").replaceChildren(...tabs);
for (const [name, { first, keys, at: shareAt }] of Object.entries(GUTTERS)) {
  const gutter = at(`${name}-gutter`), page = gutter.parentElement;
  gutter.addEventListener("pointerdown", event => {
    event.preventDefault();
    gutter.setPointerCapture(event.pointerId);
  });
  gutter.addEventListener("pointermove", event => {
    if (gutter.hasPointerCapture(event.pointerId)) set(name, 100 * shareAt(event, page.getBoundingClientRect()));
  });
  gutter.addEventListener("dblclick", () => set(name, first));
  gutter.addEventListener("keydown", event => {
    if (!keys[event.key]) return;
    event.preventDefault();
    set(name, (layout[name] ?? first) + keys[event.key]);
  });
}

onHello(() => {
  layout = kept(key(), {});
  apply();
});

function set(name, percent) {
  layout[name] = Math.min(Math.max(Math.round(percent * 10) / 10, LEAST), MOST);
  keep(key(), layout);
  apply();
}

// Brings a list to the front: events, watch or words.
export function showPanel(id) {
  layout.panel = id;
  keep(key(), layout);
  apply();
}

function apply() {
  for (const [name, { first }] of Object.entries(GUTTERS)) {
    const percent = Number.isFinite(layout[name]) ? layout[name] : first;
    document.documentElement.style.setProperty(`--${name}`, percent);
    setAttribute(at(`${name}-gutter`), "aria-valuenow", Math.round(percent));
  }
  // of several ones the sizes differ
  setFlag(
    document.documentElement,
    "data-fits",
    !Number.isFinite(layout.strip) && (run.hello.routines ?? []).length < 2
  );
  const chosen = layout.panel in PANELS ? layout.panel : "events";
  for (const id of Object.keys(PANELS)) {
    const tab = at(`${id}-tab`);
    setFlag(at(id), "hidden", id !== chosen);
    setAttribute(tab, "aria-selected", String(id === chosen));
    tab.tabIndex = id === chosen ? 0 : -1;
  }
}
