// The kinds of an event: its own kind, and "error" if it reports an error bit of a module.

export function kindsOf(event, slots) {
  const bits = slots.find(({ number }) => number === event.slot)?.bits ?? [];
  const isError = event.bits?.some(name => bits.some(bit => bit.name === name && bit.error));
  return isError ? [event.kind, "error"] : [event.kind];
}

// Whether all kinds of an event are hidden.
export const isHidden = (event, slots, hide) => kindsOf(event, slots).every(kind => hide.includes(kind));
