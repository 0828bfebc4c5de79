// The text of a rung as places where an element may be inserted: before each element of a series, and after its
// last one, in the order of the text. The server draws them in the same order.
//
//   XIC(A)[XIC(B),]OTE(C);     places  |XIC(A)|[|XIC(B)|,|]|OTE(C)|;

// Returns { places, elements, legs } of a text; null of one that has no such form.
export function read(text) {
  const places = [], elements = [], legs = [];
  let at = 0, count = 0;
  const blank = () => { while (/\s/.test(text[at] ?? "")) at++; };

  function series(branch) {
    const leg = legs.length, from = at;
    legs.push({ from, branch });
    for (;;) {
      blank();
      if (at >= text.length || ",];".includes(text[at])) break;
      const element = { from: at, before: places.length, leg };
      places.push({ at, leg });
      elements.push(element);
      if (text[at] === "[") legsOf(element);
      else instruction(element);
      element.to = at;
    }
    places.push({ at, leg });
    legs[leg].to = at;
  }

  function legsOf(element) {
    do {
      at++;
      series(element);
    } while (text[at] === ",");
    if (text[at] !== "]") throw new SyntaxError("a branch without its end");
    at++;
  }

  function instruction(element) {
    const name = /^[A-Za-z_]\w*/.exec(text.slice(at))?.[0];
    if (!name) throw new SyntaxError(`no instruction at ${at}`);
    element.number = count++;
    at += name.length;
    blank();
    if (text[at] !== "(") return;
    for (let depth = 0; at < text.length; at++) {
      if (text[at] === "'") while (++at < text.length && text[at] !== "'") if (text[at] === "$") at++;
      depth += text[at] === "(" ? 1 : text[at] === ")" ? -1 : 0;
      if (depth === 0) { at++; return; }
    }
    throw new SyntaxError("an instruction without its end");
  }

  try {
    series(null);
  } catch {
    return null;
  }
  if (text.slice(at).replace(";", "").trim()) return null;
  for (const element of elements)
    element.behind = places.findIndex((place, number) => number > element.before && place.leg === element.leg);
  return { places, elements, legs };
}

// The text with a piece in place of a part, and the place behind the piece.
export function spliced(text, from, to, piece) {
  const now = tidied(text.slice(0, from) + piece + text.slice(to), from + piece.length);
  const places = read(now.text)?.places ?? [];
  return { text: now.text, place: Math.max(0, places.findIndex(each => each.at >= now.at)) };
}

// A branch of one leg is its leg.
function tidied(text, at) {
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

// The text between two places of one leg; null of places of two legs.
export function between(text, one, other) {
  const { places } = read(text), [first, last] = [places[Math.min(one, other)], places[Math.max(one, other)]];
  return first.leg === last.leg ? { from: first.at, to: last.at } : null;
}

// What a Backspace before a place, or a Delete behind it, takes away: an element, or an empty leg.
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

// What someone has typed as rung text: `XIC Start` or `ton fill 1000` or a part of a rung. Missing presets are `?`,
// and tags are written as they are declared.
export function pieceOf(typed, instructions, tags) {
  const said = typed.trim();
  if (/^\[|\(/.test(said)) return said.replace(/;$/, "");
  const [name, ...operands] = said.split(/[\s,]+/).filter(Boolean);
  const known = instructions.find(each => each.name === name.toUpperCase());
  const lacks = known?.presets ? Math.max(0, known.operands.length - operands.length) : 0;
  const declared = operands.map(each => tags.find(tag => tag.text.toUpperCase() === each.toUpperCase())?.text ?? each);
  return `${name.toUpperCase()}(${[...declared, ...Array(Math.min(lacks, known?.presets ?? 0)).fill("?")].join(",")})`;
}

// An instruction as it is typed.
export const typedOf = text =>
  text.replace(/\(([^()]*)\)$/, (_, operands) => ` ${operands.split(",").join(" ")}`).replace(/\s+$/, "");
