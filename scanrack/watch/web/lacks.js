// Reasons why an action on a tag is not available now; "" if it is.

import * as orders from "./orders.js";
import { run } from "./state.js";
import { addressOf, valueOf } from "./values.js";

const IMAGE = /^(Local:\d+:|[IO]:)/i, INPUT = /^(Local:\d+:I|I:)/i, BIT = /^Local:.*\.\d+$|^[IO]:.*\/\d+$/i;

export const declared = tag => run.hello?.tags?.find(({ name }) => name.toUpperCase() === tag.toUpperCase());
export const isPython = () => run.hello.routines.some(({ kind }) => kind === "python" || kind === "steps");

const isImage = tag => IMAGE.test(addressOf(tag));
const isInput = tag => INPUT.test(addressOf(tag));
const isBool = tag =>
  typeof valueOf(tag) === "boolean" || declared(tag)?.type === "BOOL" || BIT.test(addressOf(tag));

// Returns the first reason of several checks.
export const first = (...checks) => subject => checks.reduce((reason, check) => reason || check(subject), "");

const refused = () => (orders.recorded() ? "not available in a recording" : "this page is read-only");
export const closed = () => (orders.allowed() ? "" : refused());
export const untimed = () => closed() || (orders.timed() ? "" : "a real controller does not wait");
export const past = () => (run.state === "past" ? "this is a past scan: press Live first" : "");
export const python = () => (isPython() ? "the program is in Python and has no rungs" : "");
export const notBool = ({ tag }) => (isBool(tag) ? "" : "not a BOOL");
export const notSingle = ({ tag }) =>
  typeof valueOf(tag) === "object" && valueOf(tag) !== null ? "it has members: select one of them" : "";

export function unwritable({ tag }) {
  if (isInput(tag)) return "an input of a module: press it at the machine, or force it";
  if (isImage(tag)) return "an output image, which every scan writes: force it";
  return (declared(tag)?.writable ?? run.hello.settable) ? "" : "it can't be set";
}

const unforceable = subject => (isImage(subject.tag) ? "" : unwritable(subject));

export const lacksWrite = first(closed, unwritable), lacksForce = first(closed, unforceable);
export const lacksBreak = first(untimed, ({ tag }) => (isImage(tag) && isPython() ? "an image: break at a line" : ""));
