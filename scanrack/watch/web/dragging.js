// Zoom: a drag over the time axis selects the new view.

import { el } from "./dom.js";

const LEAST = 6; // a shorter movement is a click, CSS pixels

// Returns the axis with a layer for the drag. timeAt(x) returns the time at a position; zoomed(from, to) is called
// with the selected times.
export function dragZoom(canvas, timeAt, zoomed) {
  const shade = el("div", { class: "dragged", hidden: true });
  const over = el(
    "div",
    { class: "over dragging", title: "Drag to zoom in; double-click to zoom out" },
    canvas,
    shade
  );
  let begin = null;
  const positionOf = event => event.clientX - over.getBoundingClientRect().left;
  const span = event => [begin, positionOf(event)].sort((a, b) => a - b);
  const end = () => { begin = null; shade.hidden = true; };
  over.addEventListener("pointerdown", event => {
    event.preventDefault();
    over.setPointerCapture(event.pointerId);
    begin = positionOf(event);
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
