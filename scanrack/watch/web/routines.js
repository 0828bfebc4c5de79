// The routines of a program: tabs, or of many the tree of their calls; and where a JSR leads.

const MANY = 8; // routines

// Whether a tree shows them better: there are many, or the first one does nothing but call the others.
export const isTree = ([first, ...others]) =>
  others.length + 1 >= MANY || (others.length > 1 && first.calls?.length >= first.lines);

// The routines in the order of the tree, each once, with how deep it is and who calls it.
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
  for (const { name } of routines) add(name, 0); // those that call one another only
  return found;
}
