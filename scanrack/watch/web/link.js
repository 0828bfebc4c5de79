// The link: the key, and what is looked at. `#key=HEX&scan=12345&rung=Main.6` opens the same picture elsewhere.

const read = () => new URLSearchParams(location.hash.slice(1));

export const keyOf = () => read().get("key") ?? "";

// What the link asks for: a scan (a number, or null), a rung such as Main.6 (or null), the panel only.
export function requested() {
  const fields = read(), scan = fields.get("scan");
  return {
    scan: scan && /^\d+$/.test(scan) ? Number(scan) : null,
    rung: fields.get("rung"),
    panel: fields.has("panel"),
  };
}

// Changes what the link says; null takes a part away. The page does not move, and Back does not fill up.
export function link(parts) {
  const fields = read();
  for (const [name, value] of Object.entries(parts)) {
    value === null ? fields.delete(name) : fields.set(name, value);
  }
  const hash = `#${fields}`;
  if (hash !== location.hash) history.replaceState(null, "", hash);
}
