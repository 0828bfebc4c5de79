// The places in the text of a rung where an element can be inserted: before each element of a series, and after its
// last one, in the order of the text. The server draws them in the same order.
//
//   XIC(A)[XIC(B),]OTE(C);     places  |XIC(A)|[|XIC(B)|,|]|OTE(C)|;

// Returns { places, elements, legs } of a text, or null if it is not the text of a rung.
export function read(text) {
  const places = [], elements = [], legs = [];
  let at = 0, count = 0;
  const skipBlanks = () => { while (/\s/.test(text[at] ?? "")) at++; };

  function readSeries(branch) {
    const leg = legs.length, from = at;
    legs.push({ from, branch });
    for (;;) {
      skipBlanks();
      if (at >= text.length || ",];".includes(text[at])) break;
      const element = { from: at, before: places.length, leg };
      places.push({ at, leg });
      elements.push(element);
      if (text[at] === "[") readLegs(element);
      else readInstruction(element);
      element.to = at;
    }
    places.push({ at, leg });
    legs[leg].to = at;
  }

  function readLegs(element) {
    do {
      at++;
      readSeries(element);
    } while (text[at] === ",");
    if (text[at] !== "]") throw new SyntaxError("a branch without an end");
    at++;
  }

  function readInstruction(element) {
    const name = /^[A-Za-z_]\w*/.exec(text.slice(at))?.[0];
    if (!name) throw new SyntaxError(`no instruction at ${at}`);
    element.number = count++;
    at += name.length;
    skipBlanks();
    if (text[at] !== "(") return;
    for (let depth = 0; at < text.length; at++) {
      if (text[at] === "'") while (++at < text.length && text[at] !== "'") if (text[at] === "$") at++;
      depth += text[at] === "(" ? 1 : text[at] === ")" ? -1 : 0;
      if (depth === 0) { at++; return; }
    }
    throw new SyntaxError("an instruction without an end");
  }

  try {
    readSeries(null);
  } catch {
    return null;
  }
  if (text.slice(at).replace(";", "").trim()) return null;
  for (const element of elements)
    element.behind = places.findIndex((place, number) => number > element.before && place.leg === element.leg);
  return { places, elements, legs };
}

// Replaces a part of the text by a piece. Returns the new text, and the place after the piece.
export function spliced(text, from, to, piece) {
  const now = withoutLoneLegs(text.slice(0, from) + piece + text.slice(to), from + piece.length);
  const places = read(now.text)?.places ?? [];
  return { text: now.text, place: Math.max(0, places.findIndex(each => each.at >= now.at)) };
}

// Replaces each branch that has only one leg by the leg.
function withoutLoneLegs(text, at) {
  for (;;) {
    const found = read(text);
    const lone = found?.elements.find(
      each => each.number === undefined && found.legs.filter(leg => leg.branch === each).length === 1
    );
    if (!lone) return { text, at };
    text = text.slice(0, lone.from) + text.slice(lone.from + 1, lone.to - 1) + text.slice(lone.to);
    at -= (at > lone.from ? 1 : 0) + (at >= lone.to ? 1 : 0);
  }
}

// The range of the text between two places of one leg; null for places of two legs.
export function between(text, one, other) {
  const { places } = read(text), [first, last] = [places[Math.min(one, other)], places[Math.max(one, other)]];
  return first.leg === last.leg ? { from: first.at, to: last.at } : null;
}

// The range that Backspace or Delete at a place removes: the element before or after it, or an empty leg.
export function taken(text, place, forward) {
  const found = read(text), here = found.places[place];
  const element = found.elements.find(each => (forward ? each.before : each.behind) === place);
  if (element) return { from: element.from, to: element.to };
  const leg = found.legs[here.leg];
  if (!leg.branch || text.slice(leg.from, leg.to).trim()) return null;
  return text[leg.from - 1] === ","
    ? { from: leg.from - 1, to: leg.to }
    : { from: leg.from, to: leg.to + (text[leg.to] === "," ? 1 : 0) };
}

// Rung text for what was typed: `XIC Start`, `ton fill 1000` or a part of a rung. Missing presets become `?`,
// and tags get the capital letters of their declarations.
export function pieceOf(typed, instructions, tags) {
  const trimmed = typed.trim();
  if (/^\[|\(/.test(trimmed)) return trimmed.replace(/;$/, "");
  const [name, ...operands] = trimmed.split(/[\s,]+/).filter(Boolean);
  const known = instructions.find(each => each.name === name.toUpperCase());
  const missing = known?.presets ? Math.max(0, known.operands.length - operands.length) : 0;
  const declared = operands.map(each => tags.find(tag => tag.text.toUpperCase() === each.toUpperCase())?.text ?? each);
  const presets = Array(Math.min(missing, known?.presets ?? 0)).fill("?");
  return `${name.toUpperCase()}(${[...declared, ...presets].join(",")})`;
}

// An instruction in the form in which it is typed: `XIC Start`.
export const typedOf = text =>
  text.replace(/\(([^()]*)\)$/, (_, operands) => ` ${operands.split(",").join(" ")}`).replace(/\s+$/, "");
