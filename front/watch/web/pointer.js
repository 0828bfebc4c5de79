// The button that was clicked last: it has the focus, but the space bar is not meant for it.

let clicked = null;

export const isClicked = node => node === clicked;

addEventListener("pointerdown", event => { clicked = event.target.closest("button, summary, [role=button]"); }, true);
addEventListener("keydown", event => { if (event.key === "Tab") clicked = null; }, true); // from now on by keyboard
addEventListener("keyup", event => { if (event.key === " " && isClicked(event.target)) event.preventDefault(); }, true); // some browsers click then
