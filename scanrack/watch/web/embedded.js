// The source of a shared page: all data is in the page, as lists of changes. It makes no connections.

import { isHidden } from "./eventkinds.js";
import { read } from "./exact.js";

export class Refused extends Error {}

const PARTS = ["power", "tags"], STATES = ["mode", "forced", "lines", "rules", "pressed", "faults"];
// scans over which speed is measured; maximum rows of answers, as in the server
const BACK = 50, EVENTS = 200, HITS = 200;

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
  if (at === null) show(data.scan); // unless the link has requested another scan
}

function added(differences, from = 0) {
  let sum = from;
  return differences.map(difference => sum += difference);
}

function unpacked({ values, differences, columns }) {
  if (values) return values;
  if (differences) return added(differences);
  const valueColumns = columns.map(column => added(column));
  return valueColumns[0].map((_, index) => valueColumns.map(column => column[index]));
}

// --- values of a scan

function indexAt(scans, scan) { // index of the last change up to a scan, or -1
  let low = 0, high = scans.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (scans[middle] <= scan) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

function valueAt(key, scan) {
  const list = lists.get(key), index = list ? indexAt(list.scans, scan) : -1;
  return index < 0 ? undefined : list.values[index];
}

const timeOf = scan => scan * data.hello.period_ns + (valueAt("offset", scan) ?? 0);
const wordsAt = (slot, scan) =>
  Array.from(
    { length: sizes[slot].in + sizes[slot].out },
    (_, index) => valueAt(`words\n${slot}\n${index}`, scan) ?? 0
  );
const programAt = scan => data.programs.findLastIndex(({ first }) => first <= scan);
const binary = (high, low) => high * 65536 + (low & 0xFFFF);
const JOINED = {
  "thousands": (first, second) => first * 1000 + second,
  "sign and magnitude": (first, second) => (first < 0 ? -1 : 1) * ((first & 0x7FFF) * 1000 + second),
  "binary": binary,
  "binary, low word first": (first, second) => binary(second, first),
};

// Returns the format of a value in a scan. The configuration of some modules selects it.
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

const slotAt = number => data.hello.slots.find(slot => slot.number === number);

// Whether a slot's image, "in" or "out", is in configuration mode.
const configures = (slot, words, image) =>
  slot in data.modes && words[data.modes[slot][image] + (image === "out" ? sizes[slot].in : 0)] < 0;

function machineOf(slot, words, values, scan) {
  const hasStatus = !configures(slot, words, "in"),
    earlierScan = Math.max(data.lead, scan - BACK),
    earlierWords = wordsAt(slot, earlierScan),
    duration = timeOf(scan) - timeOf(earlierScan);
  const position = slotAt(slot).values.find(({ name }) => name === "position");
  const hasSpeed = hasStatus && !configures(slot, earlierWords, "in") && duration > 0 && position;
  return {
    position: hasStatus ? (values?.position ?? null) : null,
    shaft: null,
    encoder: null,
    target: hasStatus && !configures(slot, words, "out") ? (values?.target ?? null) : null,
    speed: hasSpeed
      ? Math.round(((values.position - valueOf(slotAt(slot), position, earlierWords, earlierScan)) * 1e9) / duration)
      : null,
    inputs: Object.fromEntries(
      Object.entries(data.inputs).map(([name, bit]) => [
        name,
        hasStatus && data.steppers.includes(slot) ? Boolean(words[1] & bit) : null,
      ])
    ),
  };
}

// The complete picture of a scan, as from the server.
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
    const index = indexAt(list.scans, scan);
    if (index >= 0) frame[part][name] = list.values[index];
  }
  for (const slot of data.hello.slots) {
    const { number } = slot, words = frame.words[number] = wordsAt(number, scan);
    if (slot.values.length) frame.values[number] = valuesOf(slot, words, scan);
    if (data.machines.includes(number)) frame.machine[number] = machineOf(number, words, frame.values[number], scan);
  }
  return frame;
}

function show(scan) {
  at = scan;
  const program = programAt(scan);
  if (program !== number) { number = program; sent = {}; heard({ program: data.programs[program].described }); }
  const whole = picture(scan), frame = { ...whole };
  for (const part of ["words", "values", "machine", ...PARTS]) {
    const sentValues = sent[part] ?? {};
    frame[part] = Object.fromEntries(
      Object.entries(whole[part]).filter(
        ([name, value]) => JSON.stringify(value, wide) !== JSON.stringify(sentValues[name], wide)
      )
    );
  }
  sent = whole;
  heard({ frame });
}

const wide = (_key, value) => typeof value === "bigint" ? `${value}n` : value;

// --- changes between scans, the first one with the value before

function between(key, from, to) {
  const list = lists.get(key), changes = [];
  if (!list) return changes;
  for (
    let index = Math.max(indexAt(list.scans, from), 0);
    index < list.scans.length && list.scans[index] <= to;
    index += 1
  ) {
    changes.push([Math.max(list.scans[index], from), list.values[index]]);
  }
  return changes;
}

const clamped = (from, to) => [Math.max(from, data.range[0]), Math.min(to, data.range[1])];

function pointOf([scan, value]) {
  if (typeof value === "boolean") return [timeOf(scan), Number(value)];
  return typeof value === "number" || typeof value === "bigint"
    ? [timeOf(scan), Number(value), Number(value), Number(value)]
    : [timeOf(scan), value];
}

// The edges of a bit. In configuration mode only the bit of this mode has its meaning.
function edgesOf(slot, { word, bit, output }, from, to) {
  const start = output ? sizes[slot].in : 0, index = word + start, modes = data.modes[slot];
  const modeIndex = start + (modes?.[output ? "out" : "in"] ?? 0);
  const indexes = modes && index !== modeIndex ? [index, modeIndex] : [index];
  const keys = indexes.map(wordIndex => `words\n${slot}\n${wordIndex}`);
  const scans = new Set(keys.flatMap(key => between(key, from, to).map(([scan]) => scan))), edges = [];
  for (const scan of [...scans].sort((a, b) => a - b)) {
    const isConfiguring = modes && (valueAt(`words\n${slot}\n${modeIndex}`, scan) ?? 0) < 0;
    const hasMeaning = !isConfiguring || (index === modeIndex && bit === 15),
      level = hasMeaning ? ((valueAt(keys[0], scan) ?? 0) >> bit) & 1 : 0;
    if (edges.at(-1)?.[1] !== level) edges.push([timeOf(scan), level]);
  }
  return edges;
}

function positionOf(slot, position, from, to) {
  const scans = new Set(
    [data.modes[slot.number].in, ...position.words].flatMap(index =>
      between(`words\n${slot.number}\n${index}`, from, to).map(([scan]) => scan)
    )
  );
  const ordered = [...scans].sort((a, b) => a - b), stretch = Math.ceil(ordered.length / 500);
  return ordered.filter((_, index) => index % stretch === 0 || index === ordered.length - 1).map(scan => {
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
    const position = slot.values.find(({ name }) => name === "position");
    if (position) positions[`${slot.number}.position`] = positionOf(slot, position, from, to);
  }
  return { from: timeOf(from), to: timeOf(to) + data.hello.period_ns, bits, positions };
}

// --- questions

const program = () => data.programs[number];
const isTag = tag => lists.has(`tags\n${number}\n${tag}`);
const ADDRESS = /^Local:(\d+):([IO])\.Data\[(\d+)\](?:\.(\d+))?$/;

// Returns the address of a word or bit by its name, otherwise the name.
function addressOf(tag) {
  const bit = data.hello.slots.flatMap(slot => slot.bits).find(({ meaning }) => meaning === tag);
  return (bit ?? program().described.tags.find(({ name }) => name === tag))?.address ?? tag;
}

const isAddress = tag => ADDRESS.test(addressOf(tag));
const unknown = tags => tags.filter(tag => !isTag(tag) && !isAddress(tag));

/**
 * The key of a tag's list, and a function that returns the tag's value from the list's. A bit has the list of its word.
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

// Returns the points of a tag, for a bit only where it changes.
function pointsOf(tag, first, last) {
  const [key, shown] = listOf(tag), values = between(key, first, last).map(([scan, value]) => [scan, shown(value)]);
  return values.filter(([, value], index) => !index || value !== values[index - 1][1]).map(pointOf);
}

// Returns the changes of a tag or an address, in order; the first value of the page is no change.
export function changesOf(tag) {
  const [key, shown] = listOf(tag), list = lists.get(key), changes = [];
  for (let index = 1; list && index < list.scans.length; index += 1) {
    const before = shown(list.values[index - 1]);
    if (shown(list.values[index]) !== before) changes.push({ scan: list.scans[index], before });
  }
  return changes;
}

const hitOf = ({ name, type, description }) => ({
  text: `${name} : ${type}  ${description}`.trim(),
  says: `${type}  ${description}`.trim(),
  rung: null,
  tag: name,
});

// Ranks hits, the best first, as the server does.
function rankOf(name, requested) {
  const lower = name.toLowerCase(), own = lower.startsWith("\\") ? lower.slice(lower.lastIndexOf(".") + 1) : lower;
  const matches = [lower === requested, own === requested, own.startsWith(requested), lower.includes(requested), true];
  return matches.indexOf(true);
}

const QUESTIONS = {
  show({ routine, columns }) {
    const widths = Object.keys(program().shows[routine] ?? {}).map(Number);
    const width = widths.filter(drawn => drawn <= columns).at(-1) ?? widths[0];
    if (width === undefined) throw new Refused(`This page has no routine ${routine}.`);
    sent = { ...sent, power: {}, tags: {} };
    queueMicrotask(() => { if (at !== null) show(at); });
    return program().shows[routine][width];
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
    const points = Object.fromEntries(known.map(tag => [tag, pointsOf(tag, first, last)]));
    return { lanes: { from: timeOf(first), to: timeOf(last) + data.hello.period_ns, tags: points }, next: null };
  },
  look({ scan }) {
    if (scan === "live") throw new Refused("this is a trace; nothing is running");
    const [first, last] = data.range;
    if (scan < first || scan > last || data.holes.some(([from, to]) => from <= scan && scan <= to))
      throw new Refused(`This page has no scan ${scan}; it has ${first} to ${last}.`);
    show(scan);
    return { scan };
  },
  window({ from, to, signals }) {
    const [first, last] = clamped(from, to);
    return { strip: first > last ? {} : stripOf(first, last, signals) };
  },
  events({ to, skip = 0, most = EVENTS, hide = [] }) {
    const shown = data.events.filter(event => event.scan <= to && !isHidden(event, data.hello.slots, hide));
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
    const next = data.marks.find(({ scan }) => scan > from), previous = data.marks.findLast(({ scan }) => scan < from);
    return { mark: (way > 0 ? next : previous) ?? null, whole: true };
  },
  since({ tag, from = at }) {
    const change = changesOf(tag).filter(({ scan }) => scan <= Math.min(at, from)).at(-1);
    return { since: change ? { ...change, t: timeOf(change.scan) } : null };
  },
  why({ tag, fault }) {
    const answer = fault ? data.whys[""] : data.whys[tag];
    if (at === data.scan && answer) return answer;
    throw new Refused(
      `This page has no answer for that. Use: scanrack why ${data.hello.record} ${tag ?? "TAG"} --at ${at}`
    );
  },
  xref({ tag }) { throw new Refused(`This page has no list of uses. Use: scanrack xref ${data.hello.record} ${tag}`); },
  find({ text }) {
    const requested = text.toLowerCase(), has = searched => searched.toLowerCase().includes(requested);
    const bits = data.hello.slots.flatMap(slot =>
      slot.bits.map(({ address, meaning }) => ({ name: address, type: "BOOL", description: meaning }))
    );
    const [tagHits, bitHits] = [program().described.tags, bits].map(candidates =>
      candidates
        .filter(({ name, description, address = "" }) => has(`${name} ${description} ${address}`))
        .sort((a, b) => rankOf(a.name, requested) - rankOf(b.name, requested))
        .map(hitOf)
    );
    const rungs = Object.entries(program().shows).flatMap(([routine, widths]) =>
      (Object.values(widths)[0].rungs ?? [])
        .filter(rung => has(`${rung.text} ${rung.comment}`))
        .map(rung => ({ text: rung.text, rung: `${routine}.${rung.number}`, tag: null }))
    );
    const hits = [...tagHits, ...rungs, ...bitHits], isNamed = hit => hit.tag?.toLowerCase() === requested;
    return { hits: [...hits.filter(isNamed), ...hits.filter(hit => !isNamed(hit))].slice(0, HITS) };
  },
};

export async function ask(name, fields = {}) {
  const question = QUESTIONS[name];
  if (!question) throw new Refused("This is a shared recording: it accepts no actions.");
  if (!data) throw new Refused("The page is still opening.");
  return question(fields);
}
