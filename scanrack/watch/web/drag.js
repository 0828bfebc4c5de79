// Drag a contact, an operand or a value to the strip to show its lane there.

import { at, el, setFlag } from "./dom.js";
import { subjectOf } from "./subject.js";
import { hasLane, toggleTag } from "./taglanes.js";

const FAR = 6; // a longer movement is a drag, CSS pixels

const ghost = el("div", { class: "ghost", "aria-hidden": "true", hidden: true });
document.body.append(ghost);
let from = null;

const over = ({ clientX, clientY }) => Boolean(document.elementFromPoint(clientX, clientY)?.closest("#strip"));

document.addEventListener("pointerdown", event => {
  const subject = event.pointerType !== "touch" && event.button === 0 && subjectOf(event.target);
  from = subject?.tag ? { tag: subject.tag, x: event.clientX, y: event.clientY } : null;
}, true);

document.addEventListener("pointermove", event => {
  if (!from || (ghost.hidden && Math.hypot(event.clientX - from.x, event.clientY - from.y) < FAR)) return;
  if (ghost.hidden) { ghost.textContent = from.tag; ghost.hidden = false; getSelection().removeAllRanges(); }
  event.preventDefault();
  Object.assign(ghost.style, { left: `${event.clientX}px`, top: `${event.clientY}px` });
  setFlag(at("strip"), "data-drop", over(event));
}, true);

function end(event) {
  const dropped = !ghost.hidden && event.type === "pointerup" && over(event) ? from.tag : null;
  from = null;
  ghost.hidden = true;
  setFlag(at("strip"), "data-drop", false);
  if (dropped && !hasLane(dropped)) toggleTag(dropped);
}

for (const kind of ["pointerup", "pointercancel"]) document.addEventListener(kind, end, true);
document.addEventListener("keydown", event => { if (event.key === "Escape" && from) end(event); }, true);
document.addEventListener("selectstart", event => { if (!ghost.hidden) event.preventDefault(); });
