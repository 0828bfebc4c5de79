// Zoom by dragging on the axis of times: what was dragged over becomes the view.

import { el } from "./dom.js";

const LEAST = 6; // CSS pixels: less is a click

// Returns what lies over an axis. timeAt(x) is the time at a place; zoomed(from, to) gets the times that were dragged
// over.
export function dragZoom(canvas, timeAt, zoomed) {
  const shade = el("div", { class: "dragged", hidden: true });
  const over = el(
    "div",
    { class: "over dragging", title: "Drag to zoom; a double click shows more again" },
    canvas,
    shade
  );
  let begin = null;
  const place = event => event.clientX - over.getBoundingClientRect().left;
  const span = event => [begin, place(event)].sort((one, other) => one - other);
  const end = () => { begin = null; shade.hidden = true; };
  over.addEventListener("pointerdown", event => {
    event.preventDefault();
    over.setPointerCapture(event.pointerId);
    begin = place(event);
  });
  over.addEventListener("pointermove", event => {
    if (begin === null) return;
    const [from, to] = span(event);
    Object.assign(shade.style, { left: `${from}px`, width: `${to - from}px` });
    shade.hidden = to - from < LEAST;
  });
  over.addEventListener("pointerup", event => {
    if (begin === null) return;
    const [from, to] = span(event);
    end();
    if (to - from >= LEAST) zoomed(timeAt(from), timeAt(to));
  });
  over.addEventListener("pointercancel", end);
  return over;
}
