// What this browser keeps for a rack, in its local storage.

export function kept(key, otherwise) {
  try {
    const found = JSON.parse(localStorage.getItem(key));
    return typeof found === "object" && found && Array.isArray(found) === Array.isArray(otherwise) ? found : otherwise;
  } catch {
    return otherwise; // kept by another version, or the browser keeps nothing
  }
}

export function keep(key, value) {
  try {
    localStorage.setItem(key, JSON.stringify(value));
  } catch { /* the browser keeps nothing: it lasts as long as the page */ }
}
