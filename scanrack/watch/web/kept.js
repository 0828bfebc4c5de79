// What this browser keeps for a rack: in its local storage, or for the tab alone in the storage of its session.

export function kept(key, otherwise, store = () => localStorage) {
  try {
    const found = JSON.parse(store().getItem(key));
    return typeof found === "object" && found && Array.isArray(found) === Array.isArray(otherwise) ? found : otherwise;
  } catch {
    return otherwise; // kept by another version, or the browser keeps nothing
  }
}

export function keep(key, value, store = () => localStorage) {
  try {
    store().setItem(key, JSON.stringify(value));
  } catch { /* the browser keeps nothing: it lasts as long as the page */ }
}
