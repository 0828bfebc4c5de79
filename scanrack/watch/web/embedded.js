// The source of a shared page: everything is in the page, as lists of changes. It connects to nothing.

import { isHidden } from "./eventkinds.js";
import { read } from "./exact.js";

export class Refused extends Error {}

const PARTS = ["power", "tags"], STATES = ["mode", "forced", "lines", "rules", "pressed", "faults"];
const BACK = 50, EVENTS = 200, HITS = 200; // scans of a speed, as the server has it; rows of an answer

const lists = new Map(); // key -> { scans, values }
let data = null, sizes = {}, heard = null, at = null, number = 0, sent = {}; // sizes: words in and out of each slot

export async function connect(_key, listener) {
  heard = listener;
  const packed = Uint8Array.from(atob(document.getElementById("data").textContent), letter => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  data = read(await new Response(stream).text());
  sizes = Object.fromEntries(data.hello.slots.map(slot => [slot.number, slot.words]));
  for (const [key, { steps, ...packed }] of Object.entries(data.lists))
    lists.set(key, { scans: Int32Array.from(added(steps, data.lead)), values: unpacked(packed) });
  number = programAt(data.scan);
  heard({ hello: { ...data.hello, ...data.programs[number].described } });
  for (const note of data.notes) heard({ note });
  if (at === null) show(data.scan); // the link has requested no other scan
}

function added(differences, from = 0) {
  let sum = from;
  return differences.map(each => sum += each);
}

function unpacked({ values, differences, columns }) {
  if (values) return values;
  if (differences) return added(differences);
  const whole = columns.map(each => added(each));
  return whole[0].map((_, place) => whole.map(column => column[place]));
}

// --- values of a scan

function placeAt(scans, scan) { // the last change up to a scan, or -1
  let low = 0, high = scans.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (scans[middle] <= scan) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

function valueAt(key, scan) {
  const list = lists.get(key), place = list ? placeAt(list.scans, scan) : -1;
  return place < 0 ? undefined : list.values[place];
}

const timeOf = scan => scan * data.hello.period_ns + (valueAt("offset", scan) ?? 0);
const wordsAt = (slot, scan) =>
  Array.from(
    { length: sizes[slot].in + sizes[slot].out },
    (_, place) => valueAt(`words\n${slot}\n${place}`, scan) ?? 0
  );
const programAt = scan => data.programs.findLastIndex(each => each.first <= scan);
const binary = (high, low) => high * 65536 + (low & 0xFFFF);
const JOINED = {
  "thousands": (first, second) => first * 1000 + second,
  "sign and magnitude": (first, second) => (first < 0 ? -1 : 1) * ((first & 0x7FFF) * 1000 + second),
  "binary": binary,
  "binary, low word first": (first, second) => binary(second, first),
};

// The format of a value in a scan; the configuration of some modules selects it.
function formatOf(slot, value, scan) {
  if (value.format) return value.format;
  const image = value.words[0] < sizes[slot.number].in ? "I" : "O";
  return (
    data.formats.findLast(([number, of, since]) => number === slot.number && of === image && since <= scan)?.[3] ??
    "thousands"
  );
}

function valueOf(slot, value, words, scan) {
  const [first, ...rest] = value.words;
  return rest.length ? JOINED[formatOf(slot, value, scan)](words[first], words[rest[0]]) : words[first];
}

const valuesOf = (slot, words, scan) =>
  Object.fromEntries(slot.values.map(value => [value.name, valueOf(slot, value, words, scan)]));

const slotAt = number => data.hello.slots.find(each => each.number === number);

// Whether the words of a slot's image, "in" or "out", are those of configuration mode.
const configures = (slot, words, image) =>
  slot in data.modes && words[data.modes[slot][image] + (image === "out" ? sizes[slot].in : 0)] < 0;

function machineOf(slot, words, values, scan) {
  const says = !configures(slot, words, "in"),
    then = Math.max(data.lead, scan - BACK),
    before = wordsAt(slot, then),
    wide = timeOf(scan) - timeOf(then);
  const position = slotAt(slot).values.find(each => each.name === "position");
  const spoken = says && !configures(slot, before, "in") && wide > 0 && position;
  return {
    position: says ? (values?.position ?? null) : null,
    shaft: null,
    encoder: null,
    target: says && !configures(slot, words, "out") ? (values?.target ?? null) : null,
    speed: spoken
      ? Math.round(((values.position - valueOf(slotAt(slot), position, before, then)) * 1e9) / wide)
      : null,
    inputs: Object.fromEntries(
      Object.entries(data.inputs).map(([name, bit]) => [
        name,
        says && data.steppers.includes(slot) ? Boolean(words[1] & bit) : null,
      ])
    ),
  };
}

// The whole picture of a scan, as the server has it.
export function picture(scan) {
  const known = scan < data.programs[programAt(scan)].known;
  const frame = {
    scan,
    t: timeOf(scan),
    range: data.range,
    record: data.hello.record,
    state: "past",
    speed: { requested: 0, reached: 0 },
    late: 0,
    missed: 0,
    known,
    words: {},
    values: {},
    machine: {},
    power: {},
    tags: {},
  };
  for (const key of STATES) frame[key] = valueAt(key, scan);
  for (const [key, list] of lists) {
    const [part, program, name] = key.split("\n");
    if (!known || !PARTS.includes(part) || Number(program) !== programAt(scan)) continue;
    const place = placeAt(list.scans, scan);
    if (place >= 0) frame[part][name] = list.values[place];
  }
  for (const each of data.hello.slots) {
    const slot = each.number, words = frame.words[slot] = wordsAt(slot, scan);
    if (each.values.length) frame.values[slot] = valuesOf(each, words, scan);
    if (data.machines.includes(slot)) frame.machine[slot] = machineOf(slot, words, frame.values[slot], scan);
  }
  return frame;
}

function show(scan) {
  at = scan;
  const program = programAt(scan);
  if (program !== number) { number = program; sent = {}; heard({ program: data.programs[program].described }); }
  const whole = picture(scan), frame = { ...whole };
  for (const part of ["words", "values", "machine", ...PARTS]) {
    const before = sent[part] ?? {};
    frame[part] = Object.fromEntries(
      Object.entries(whole[part]).filter(
        ([name, value]) => JSON.stringify(value, wide) !== JSON.stringify(before[name], wide)
      )
    );
  }
  sent = whole;
  heard({ frame });
}

const wide = (_key, value) => typeof value === "bigint" ? `${value}n` : value;

// --- changes between scans: the first one as it stood before

function between(key, from, to) {
  const list = lists.get(key), found = [];
  if (!list) return found;
  for (
    let place = Math.max(placeAt(list.scans, from), 0);
    place < list.scans.length && list.scans[place] <= to;
    place += 1
  ) {
    found.push([Math.max(list.scans[place], from), list.values[place]]);
  }
  return found;
}

const clamped = (from, to) => [Math.max(from, data.range[0]), Math.min(to, data.range[1])];

function pointOf([scan, value]) {
  if (typeof value === "boolean") return [timeOf(scan), Number(value)];
  return typeof value === "number" || typeof value === "bigint"
    ? [timeOf(scan), Number(value), Number(value), Number(value)]
    : [timeOf(scan), value];
}

// The edges of a bit; words that configure a stepper have no bits but the one that says so.
function edgesOf(slot, { word, bit, output }, from, to) {
  const start = output ? sizes[slot].in : 0, place = word + start, modes = data.modes[slot];
  const mode = start + (modes?.[output ? "out" : "in"] ?? 0);
  const keys = [place, ...(modes && place !== mode ? [mode] : [])].map(each => `words\n${slot}\n${each}`);
  const scans = new Set(keys.flatMap(key => between(key, from, to).map(([scan]) => scan))), edges = [];
  for (const scan of [...scans].sort((one, other) => one - other)) {
    const configured = modes && (valueAt(`words\n${slot}\n${mode}`, scan) ?? 0) < 0;
    const kept = !configured || (place === mode && bit === 15),
      level = kept ? ((valueAt(keys[0], scan) ?? 0) >> bit) & 1 : 0;
    if (edges.at(-1)?.[1] !== level) edges.push([timeOf(scan), level]);
  }
  return edges;
}

function positionOf(slot, position, from, to) {
  const scans = new Set(
    [data.modes[slot.number].in, ...position.words].flatMap(place =>
      between(`words\n${slot.number}\n${place}`, from, to).map(([scan]) => scan)
    )
  );
  const ordered = [...scans].sort((one, other) => one - other), stretch = Math.ceil(ordered.length / 500);
  return ordered.filter((_, place) => place % stretch === 0 || place === ordered.length - 1).map(scan => {
    const words = wordsAt(slot.number, scan), value = valueOf(slot, position, words, scan);
    return configures(slot.number, words, "in") ? [timeOf(scan), null] : [timeOf(scan), value, value, value];
  });
}

function stripOf(from, to, signals) {
  const bits = {}, positions = {};
  for (const slot of data.hello.slots) {
    const inputs = new Set(slot.bits.filter(bit => !bit.output).map(bit => bit.name));
    for (const bit of slot.bits) {
      const name = `${slot.number}.${bit.name}`;
      if ((bit.output && inputs.has(bit.name)) || (signals && !signals.includes(name))) continue;
      bits[name] = edgesOf(slot.number, bit, from, to);
    }
    const position = slot.values.find(each => each.name === "position");
    if (position) positions[`${slot.number}.position`] = positionOf(slot, position, from, to);
  }
  return { from: timeOf(from), to: timeOf(to) + data.hello.period_ns, bits, positions };
}

// --- questions

const program = () => data.programs[number];
const isTag = tag => lists.has(`tags\n${number}\n${tag}`);
const ADDRESS = /^Local:(\d+):([IO])\.Data\[(\d+)\](?:\.(\d+))?$/;

// The address of a name of a word or bit, else the name.
function addressOf(tag) {
  const bit = data.hello.slots.flatMap(slot => slot.bits).find(({ meaning }) => meaning === tag);
  return (bit ?? program().described.tags.find(({ name }) => name === tag))?.address ?? tag;
}

const isAddress = tag => ADDRESS.test(addressOf(tag));
const unknown = tags => tags.filter(tag => !isTag(tag) && !isAddress(tag));

/**
 * The lists of an address of an image are its word's.
 * @returns {[string, (value: any) => any]}
 */
function listOf(tag) {
  const [, slot, image, word, bit] = ADDRESS.exec(addressOf(tag)) ?? [];
  if (!slot) return [`tags\n${number}\n${tag}`, value => value];
  return [
    `words\n${slot}\n${Number(word) + (image === "O" ? sizes[slot]?.in : 0)}`,
    value => (bit === undefined ? value : Boolean((value >> Number(bit)) & 1)),
  ];
}

// Its points: of a bit those of its word at which it changes.
function pointsOf(tag, first, last) {
  const [key, shown] = listOf(tag), values = between(key, first, last).map(([scan, value]) => [scan, shown(value)]);
  return values.filter(([, value], place) => !place || value !== values[place - 1][1]).map(pointOf);
}

// The scans at which a tag or an address has changed, in order; the first of the page is none.
export function changesOf(tag) {
  const [key, shown] = listOf(tag), list = lists.get(key), found = [];
  for (let place = 1; list && place < list.scans.length; place += 1) {
    const before = shown(list.values[place - 1]);
    if (shown(list.values[place]) !== before) found.push({ scan: list.scans[place], before });
  }
  return found;
}

const hitOf = ({ name, type, description }) => ({
  text: `${name} : ${type}  ${description}`.trim(),
  says: `${type}  ${description}`.trim(),
  rung: null,
  tag: name,
});

// The best hits are first, as the server has them.
function rankOf(name, requested) {
  const lower = name.toLowerCase(), own = lower.startsWith("\\") ? lower.slice(lower.lastIndexOf(".") + 1) : lower;
  const fits = [lower === requested, own === requested, own.startsWith(requested), lower.includes(requested), true];
  return fits.indexOf(true);
}

const QUESTIONS = {
  show({ routine, columns }) {
    const widths = Object.keys(program().shows[routine] ?? {}).map(Number);
    const fits = widths.filter(each => each <= columns).at(-1) ?? widths[0];
    if (fits === undefined) throw new Refused(`There is no routine ${routine} in this page.`);
    sent = { ...sent, power: {}, tags: {} };
    queueMicrotask(() => { if (at !== null) show(at); });
    return program().shows[routine][fits];
  },
  watch({ tags }) {
    sent = { ...sent, tags: {} };
    queueMicrotask(() => { if (at !== null) show(at); });
    return {
      unknown: unknown(tags),
      addresses: Object.fromEntries(tags.filter(isAddress).map(tag => [tag, addressOf(tag)])),
    };
  },
  panel: () => program().panel,
  lanes: ({ tags }) => ({ unknown: unknown(tags) }),
  steps({ from, to, tags }) {
    const [first, last] = clamped(from, to);
    if (first > last) return { lanes: {}, next: null };
    const known = tags.filter(tag => !unknown([tag]).length);
    const found = Object.fromEntries(known.map(tag => [tag, pointsOf(tag, first, last)]));
    return { lanes: { from: timeOf(first), to: timeOf(last) + data.hello.period_ns, tags: found }, next: null };
  },
  look({ scan }) {
    if (scan === "live") throw new Refused("this is a trace; nothing is running");
    const [first, last] = data.range;
    if (scan < first || scan > last || data.holes.some(([from, to]) => from <= scan && scan <= to))
      throw new Refused(`Scan ${scan} is not in this page: it has ${first} to ${last}.`);
    show(scan);
    return { scan };
  },
  window({ from, to, signals }) {
    const [first, last] = clamped(from, to);
    return { strip: first > last ? {} : stripOf(first, last, signals) };
  },
  events({ to, skip = 0, most = EVENTS, hide = [] }) {
    const shown = data.events.filter(each => each.scan <= to && !isHidden(each, data.hello.slots, hide));
    const end = Math.max(shown.length - skip, 0);
    return { events: shown.slice(Math.max(end - most, 0), end), total: shown.length, whole: true };
  },
  marks() {
    const failure = data.hello.failure ? null : data.marks.findLast(({ scan, tag }) => tag && scan <= at) ?? null;
    return {
      marks: data.marks.map(({ scan, kind }) => [scan, kind, 1]),
      total: data.marks.length,
      whole: true,
      failure,
    };
  },
  mark({ from, way }) {
    const next = data.marks.find(({ scan }) => scan > from), before = data.marks.findLast(({ scan }) => scan < from);
    return { mark: (way > 0 ? next : before) ?? null, whole: true };
  },
  since({ tag, from = at }) {
    const found = changesOf(tag).filter(each => each.scan <= Math.min(at, from)).at(-1);
    return { since: found ? { ...found, t: timeOf(found.scan) } : null };
  },
  why({ tag, fault }) {
    const answer = fault ? data.whys[""] : data.whys[tag];
    if (at === data.scan && answer) return answer;
    throw new Refused(
      `This page has no answer for that. Ask: scanrack why ${data.hello.record} ${tag ?? "TAG"} --at ${at}`
    );
  },
  xref({ tag }) { throw new Refused(`This page has no list of uses. Ask: scanrack xref ${data.hello.record} ${tag}`); },
  find({ text }) {
    const requested = text.toLowerCase(), has = said => said.toLowerCase().includes(requested);
    const bits = data.hello.slots.flatMap(slot =>
      slot.bits.map(({ address, meaning }) => ({ name: address, type: "BOOL", description: meaning }))
    );
    const tags = [program().described.tags, bits].map(each =>
      each
        .filter(({ name, description, address = "" }) => has(`${name} ${description} ${address}`))
        .sort((one, other) => rankOf(one.name, requested) - rankOf(other.name, requested))
        .map(hitOf)
    );
    const rungs = Object.entries(program().shows).flatMap(([routine, widths]) =>
      (Object.values(widths)[0].rungs ?? [])
        .filter(rung => has(`${rung.text} ${rung.comment}`))
        .map(rung => ({ text: rung.text, rung: `${routine}.${rung.number}`, tag: null }))
    );
    const hits = [...tags[0], ...rungs, ...tags[1]], isNamed = hit => hit.tag?.toLowerCase() === requested;
    return { hits: [...hits.filter(isNamed), ...hits.filter(hit => !isNamed(hit))].slice(0, HITS) };
  },
};

export async function ask(what, fields = {}) {
  const question = QUESTIONS[what];
  if (!question) throw new Refused("This is a shared recording: it takes no orders.");
  if (!data) throw new Refused("The page is still opening.");
  return question(fields);
}
