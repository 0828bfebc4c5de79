// The link: the key, and the scan and rung shown. `#key=HEX&scan=12345&rung=Main.6` opens the same picture elsewhere.

const read = () => new URLSearchParams(location.hash.slice(1));

export const keyOf = () => read().get("key") ?? "";

// Returns what the link requests: a scan (number or null), a rung such as Main.6 or null, and the panel only.
export function requested() {
  const fields = read(), scan = fields.get("scan");
  return {
    scan: scan && /^\d+$/.test(scan) ? Number(scan) : null,
    rung: fields.get("rung"),
    panel: fields.has("panel"),
  };
}

// Changes parts of the link; null removes a part. The page and the history of the browser stay unchanged.
export function link(parts) {
  const fields = read();
  for (const [name, value] of Object.entries(parts)) {
    value === null ? fields.delete(name) : fields.set(name, value);
  }
  const hash = `#${fields}`;
  if (hash !== location.hash) history.replaceState(null, "", hash);
}
