// What this browser keeps for a rack: in its local storage, or for the tab alone in the storage of its session.

import { run } from "./state.js";

const keyOf = name => `scanrack ${name} ${run.hello.path}`;

export function kept(name, otherwise, store = () => localStorage) {
  try {
    const found = JSON.parse(store().getItem(keyOf(name)));
    return typeof found === "object" && found && Array.isArray(found) === Array.isArray(otherwise) ? found : otherwise;
  } catch {
    return otherwise; // kept by another version, or the browser keeps nothing
  }
}

export function keep(name, value, store = () => localStorage) {
  try {
    store().setItem(keyOf(name), JSON.stringify(value));
  } catch { /* the browser keeps nothing: it lasts as long as the page */ }
}
