// The kinds of an event: its own, and whether it reports an error bit of a module.

export function kindsOf(event, slots) {
  const bits = slots.find(({ number }) => number === event.slot)?.bits ?? [];
  const errs = event.bits?.some(name => bits.some(bit => bit.name === name && bit.error));
  return errs ? [event.kind, "error"] : [event.kind];
}

// Whether an event is left out: all its kinds are hidden.
export const isHidden = (event, slots, hide) => kindsOf(event, slots).every(kind => hide.includes(kind));
