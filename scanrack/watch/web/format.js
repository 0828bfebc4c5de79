// Values as text: digits of fixed width, groups of three, radixes.

import { integer } from "./exact.js";

export const count = value => Math.trunc(value).toLocaleString("en");

const two = number => String(number).padStart(2, "0");

// Returns a time in ns as min:s.ms, or h:min:s.ms from an hour on.
export function clock(ns) {
  const ms = Math.floor(ns / 1e6), s = Math.floor(ms / 1000), min = Math.floor(s / 60);
  const tail = `${two(s % 60)}.${String(ms % 1000).padStart(3, "0")}`;
  return min < 60 ? `${two(min)}:${tail}` : `${Math.floor(min / 60)}:${two(min % 60)}:${tail}`;
}

// Groups the digits of numbers in a text, except in names and addresses.
export const grouped = text =>
  text.replace(/(?<![\w.:,#])-?\d{4,}(?![\w.]|:\d)/g, number => Number(number).toLocaleString("en"));

// Writes times in a text, such as "since 7.662 s", "scan 3,831, 7.662 s" or "(7.662 s,", as `clock` does.
export const clocked = text =>
  text.replace(
    /(\b(?:since|edited at|scan [\d,]+,) |\((?=[\d.e+-]+ s[,)]))([\d.e+-]+) s\b/g,
    (_, prefix, s) => prefix + clock(Math.round(Number(s) * 1e9))
  );

export const capital = text => text[0].toUpperCase() + text.slice(1);

// Returns a refusal as a sentence.
export const sentence = text => `${capital(text)}${/[.!?]$/.test(text) ? "" : "."}`;

// 1 scan, 2,000 scans
export const many = (number, noun) => `${count(number)} ${noun}${number === 1 ? "" : "s"}`;

// Returns the step of a scale with at most `most` marks: 1, 2 or 5 times a power of ten.
export function stepOf(span, most) {
  const power = 10 ** Math.floor(Math.log10(span / most));
  return power * [1, 2, 5, 10].find(factor => span / (factor * power) <= most);
}

/** @type {[number, string][]} */
const UNITS = [[1e9, "s"], [1e6, "ms"], [1e3, "µs"], [1, "ns"]];

// Returns a time in whole ns as text, like `time_text` of io_images/times.py.
export function timeText(ns) {
  const [unit, name] = UNITS.find(([size]) => ns >= size) ?? UNITS[0];
  const rest = ns % unit ? `.${String(unit + ns % unit).slice(1).replace(/0+$/, "")}` : "";
  return `${Math.floor(ns / unit)}${rest} ${name}`;
}

export function times(factor) {
  if (factor === "max") return "max";
  return `${factor < 10 ? factor.toFixed(2) : factor < 100 ? factor.toFixed(1) : Math.round(factor)}×`;
}

// Returns a value for an attribute that scripts read: BOOL as 1 or 0.
export function plain(value) {
  if (value === true) return "1";
  if (value === false) return "0";
  if (value === null || value === undefined) return "";
  return typeof value === "object" ? JSON.stringify(value) : String(value);
}

const WHOLE = { SINT: 8, INT: 16, DINT: 32, LINT: 64, USINT: 8, UINT: 16, UDINT: 32, ULINT: 64 };

export const RADIXES = ["decimal", "hex", "binary", "octal", "ASCII", "exponential"];

function based(value, bits, base, mark, group) {
  const digits = BigInt.asUintN(bits, BigInt(value)).toString(base);
  const wide = Math.ceil(bits / Math.log2(base));
  const padded = digits.padStart(wide, "0");
  return mark + padded.replace(new RegExp(`(?<=.)(?=(.{${group}})+$)`, "g"), "_");
}

function letters(value, bits) {
  const unsigned = BigInt.asUintN(bits, BigInt(value));
  let text = "";
  for (let shift = bits - 8; shift >= 0; shift -= 8) {
    const code = Number((unsigned >> BigInt(shift)) & 255n);
    text += code >= 32 && code < 127 ? String.fromCharCode(code) : ".";
  }
  return `'${text}'`;
}

const isWhole = value => typeof value === "bigint" || Number.isInteger(value);
export const isNumber = value => typeof value === "bigint" || typeof value === "number";

// Returns a value in a radix, or in decimal if the radix does not fit its type.
export function inRadix(value, radix = "decimal", type = "DINT") {
  if (radix === "exponential" && isNumber(value)) return Number(value).toExponential(6);
  if (isWhole(value) && !type.endsWith("REAL")) {
    const bits = WHOLE[type] || 32;
    if (radix === "hex") return based(value, bits, 16, "16#", 4);
    if (radix === "binary") return based(value, bits, 2, "2#", 4);
    if (radix === "octal") return based(value, bits, 8, "8#", 3);
    if (radix === "ASCII") return letters(value, bits);
  }
  return shown(value);
}

// Returns a value in its default form, short enough for a box of a rung.
export function shown(value) {
  if (value === null || value === undefined) return "–"; // unknown
  if (isWhole(value)) return value.toLocaleString("en");
  if (typeof value !== "number") return plain(value);
  return Math.abs(value) >= 1e7 || Math.abs(value) < 1e-4
    ? value.toExponential(4)
    : String(Number(value.toPrecision(7)));
}

// Returns the value of a typed text, or undefined.
export function parsed(text, type = "") {
  const typed = text.trim().replaceAll("_", "").replace(/^-?\d{1,3}(,\d{3})+$/, whole => whole.replaceAll(",", ""));
  if (type === "BOOL" || /^(true|false)$/i.test(typed)) {
    return { 1: true, 0: false, true: true, false: false }[typed.toLowerCase()];
  }
  if (type === "STRING" || type === "TEXT") return text;
  const based = /^(-?)(?:16#([0-9a-f]+)|8#([0-7]+)|2#([01]+))$/i.exec(typed);
  if (based) {
    const [, sign, hex, octal, binary] = based;
    const value = integer(hex ? `0x${hex}` : octal ? `0o${octal}` : `0b${binary}`);
    return sign ? -value : value;
  }
  if (/^-?\d+$/.test(typed)) return integer(typed);
  return /^-?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/i.test(typed) ? Number(typed) : undefined;
}
