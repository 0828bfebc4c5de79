// JSON with integers of any width. An integer that a double can't represent is a BigInt; an older browser rounds it.

const LONG = /\d{16}/; // an unsafe integer has at least 16 digits

const whole = (key, value, context) =>
  typeof value === "number" && !Number.isSafeInteger(value) && /^-?\d+$/.test(context?.source ?? "")
    ? BigInt(context.source)
    : value;

const raw = (key, value) =>
  typeof value !== "bigint" ? value : JSON.rawJSON ? JSON.rawJSON(String(value)) : Number(value);

export const read = text => LONG.test(text) ? JSON.parse(text, whole) : JSON.parse(text);

export const written = value => JSON.stringify(value, raw);

// Returns an integer from its digits: a number if that is exact, otherwise a BigInt.
export function integer(digits) {
  const value = BigInt(digits);
  return Number.isSafeInteger(Number(value)) ? Number(value) : value;
}
