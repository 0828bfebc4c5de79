// The last button that was clicked: it has the focus, but the space bar pauses the rack and must not press it again.

let clicked = null;

export const isClicked = node => node === clicked;

// Makes an element of a drawing a button that is named by its title.
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
// the keyboard is used from now on
addEventListener("keydown", event => { if (event.key === "Tab") clicked = null; }, true);
// some browsers click when the space bar is released
addEventListener("keyup", event => { if (event.key === " " && isClicked(event.target)) event.preventDefault(); }, true);
