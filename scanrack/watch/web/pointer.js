// The button that was clicked last: it has the focus, but the space bar is not meant for it.

let clicked = null;

export const isClicked = node => node === clicked;

// An element of a drawing becomes a button of its title's name.
export function pressable(group, press) {
  group.setAttribute("role", "button");
  group.setAttribute("tabindex", "0");
  group.setAttribute("aria-label", group.querySelector("title").textContent);
  group.addEventListener("click", press);
  group.addEventListener("keydown", event => {
    if (event.key !== "Enter" && (event.key !== " " || isClicked(group))) return;
    event.preventDefault();
    press();
  });
}

addEventListener("pointerdown", event => { clicked = event.target.closest("button, summary, [role=button]"); }, true);
addEventListener("keydown", event => { if (event.key === "Tab") clicked = null; }, true); // from now on by keyboard
// some browsers click then
addEventListener("keyup", event => { if (event.key === " " && isClicked(event.target)) event.preventDefault(); }, true);
