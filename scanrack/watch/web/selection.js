// What is selected: a tag, and the element of a rung that it was selected at.

const followers = [];
export const selected = { tag: null, element: null, rung: null, names: [] };

export const onSelect = follow => { followers.push(follow); };

// Selects; what is not said is taken away, the rung apart.
export function select({ tag = null, element = null, rung = selected.rung, names = tag ? [tag] : [] }) {
  Object.assign(selected, { tag, element, rung, names });
  for (const follow of followers) follow(selected);
}
