// Data that the browser keeps for a rack: in its local storage, or only for the tab in its session storage.

import { run } from "./state.js";

const keyOf = name => `scanrack ${name} ${run.hello.path}`;

export function kept(name, otherwise, store = () => localStorage) {
  try {
    const value = JSON.parse(store().getItem(keyOf(name)));
    return typeof value === "object" && value && Array.isArray(value) === Array.isArray(otherwise) ? value : otherwise;
  } catch {
    return otherwise; // data of another version, or no storage
  }
}

export function keep(name, value, store = () => localStorage) {
  try {
    store().setItem(keyOf(name), JSON.stringify(value));
  } catch { /* without storage the data lasts as long as the page */ }
}
