// JSON with integers of any width: one that no double has is a BigInt. An older browser rounds it.

const LONG = /\d{16}/; // digits that an unsafe integer has at least

const whole = (key, value, context) =>
  typeof value === "number" && !Number.isSafeInteger(value) && /^-?\d+$/.test(context?.source ?? "")
    ? BigInt(context.source)
    : value;

const raw = (key, value) =>
  typeof value !== "bigint" ? value : JSON.rawJSON ? JSON.rawJSON(String(value)) : Number(value);

export const read = text => LONG.test(text) ? JSON.parse(text, whole) : JSON.parse(text);

export const written = value => JSON.stringify(value, raw);

// An integer from its digits: a number if it is exact.
export function integer(digits) {
  const value = BigInt(digits);
  return Number.isSafeInteger(Number(value)) ? Number(value) : value;
}
