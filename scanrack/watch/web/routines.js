// How the routines of a program are listed: one after another, or as the tree of their calls.

const MANY = 8; // routines

// Whether to show a tree: there are many routines, or the first one does nothing but call the others.
export const isTree = ([first, ...others]) =>
  others.length + 1 >= MANY || (others.length > 1 && first.calls?.length >= first.lines);

// The routines in the order of the tree, each once, with its depth and its callers.
export function treeOf(routines) {
  const byName = new Map(routines.map(each => [each.name, each])),
    callers = new Map(routines.map(each => [each.name, []]));
  for (const { name, calls = [] } of routines) for (const called of calls) callers.get(called)?.push(name);
  const found = [], seen = new Set();
  const add = (name, depth) => {
    if (seen.has(name)) return;
    seen.add(name);
    found.push({ ...byName.get(name), depth, callers: callers.get(name) });
    for (const called of byName.get(name).calls ?? []) if (byName.has(called)) add(called, depth + 1);
  };
  for (const { name } of routines) if (!callers.get(name).length) add(name, 0);
  for (const { name } of routines) add(name, 0); // left over: they only call one another
  return found;
}
