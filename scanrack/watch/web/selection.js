// What is selected: a tag, and the element of a rung at which it was selected.

const followers = [];
export const selected = { tag: null, element: null, rung: null, names: [] };

export const onSelect = follow => { followers.push(follow); };

// Selects. What is not given is deselected, except for the rung.
export function select({ tag = null, element = null, rung = selected.rung, names = tag ? [tag] : [] }) {
  Object.assign(selected, { tag, element, rung, names });
  for (const follow of followers) follow(selected);
}
