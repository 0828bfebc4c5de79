// Draws the part of the chart that is in view.

const width = () => canvas.clientWidth - LEFT - RIGHT;
const xOf = moment => LEFT + (moment - view.start) / (view.end - view.start) * width();
const timeAt = x => view.start + (x - LEFT) / width() * (view.end - view.start);
const curveHeight = (panel, place) => panel.tags ? NUMBER : panel.ramp && place === 0 ? POSITION : SPEED;
const curvesHeight = panel => panel.curves.reduce((sum, _, place) => sum + curveHeight(panel, place) + GAP, 0);
const headHeight = panel => panel.marks.length ? MARKS : HEAD;
const rows = panel => panel.lanes.length + panel.bands.length + (panel.ramp ? 1 : 0) + (panel.unchanged.length ? 1 : 0);
const panelHeight = panel => headHeight(panel) + curvesHeight(panel) + LANE * rows(panel) + AXIS;
const chartHeight = () => TOP + data.panels.reduce((sum, panel) => sum + panelHeight(panel), 0);

// The scheme of colors: as light, or dark with every color of the chart made lighter.
const dark = window.matchMedia("(prefers-color-scheme: dark)");
const style = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const ink = () => style("--ink"), soft = () => style("--soft"), paper = () => style("--paper");
const TOWARDS_WHITE = 0.45;

function shade(color) {
  if (!dark.matches) return color;
  const parts = [1, 3, 5].map(place => parseInt(color.slice(place, place + 2), 16));
  const lighter = parts.map(part => Math.round(part + (255 - part) * TOWARDS_WHITE));
  return "#" + lighter.map(part => part.toString(16).padStart(2, "0")).join("");
}

const gridColor = () => dark.matches ? style("--edge") : data.colors.grid;

// The curves of position share the rest of the window, if the readout is beside the chart.
function fit() {
  POSITION = LEAST_POSITION;
  const needed = chartHeight();
  const room = window.innerHeight - canvas.getBoundingClientRect().top - window.scrollY;
  const beside = canvas.clientWidth < canvas.parentElement.clientWidth;
  const axes = data.panels.filter(panel => panel.ramp).length;
  if (beside && axes) POSITION += Math.max(0, Math.floor((room - needed) / axes));
}

function draw() {
  fit();
  const scale = window.devicePixelRatio || 1;
  const height = chartHeight();
  canvas.style.height = `${height}px`;
  canvas.width = canvas.clientWidth * scale;
  canvas.height = height * scale;
  pen.setTransform(scale, 0, 0, scale, 0, 0);
  pen.clearRect(0, 0, canvas.clientWidth, height);
  let top = TOP;
  for (const panel of data.panels) top = drawPanel(panel, top);
  drawCursor(height);
  canvas.dataset.start = view.start;
  canvas.dataset.end = view.end;
}

function drawPanel(panel, top) {
  const bottom = top + panelHeight(panel) - AXIS, head = headHeight(panel);
  drawTicks(top + head, bottom);
  drawHead(panel, top + 18);
  if (panel.marks.length) drawMarks(panel, top, top + MARKS + Math.max(0, curvesHeight(panel) - GAP), bottom);
  top += head;
  panel.curves.forEach((each, place) => {
    drawCurve(each, top, curveHeight(panel, place), panel.tags);
    top += curveHeight(panel, place) + GAP;
  });
  if (panel.ramp) {
    drawRamp(panel.ramp, top);
    top += LANE;
  }
  for (const band of panel.bands) {
    drawBand(band, top);
    top += LANE;
  }
  panel.lanes.forEach((lane, place) => drawBit(lane, top + place * LANE));
  if (panel.unchanged.length) drawUnchanged(panel.unchanged, bottom - LANE);
  return bottom + AXIS;
}

function drawHead(panel, base) {
  text(panel.name, 8, base, ink(), "bold 14px system-ui");
  if (panel.marks.length) text(panel.about, 8, base + 16, soft(), "12px system-ui");
  else text(panel.about, 18 + pen.measureText(panel.name).width, base, soft(), "12px system-ui");
}

// A text that fits into `room` pixels of the pen's font, without its end or, with `tail`, its beginning.
function fitted(label, room, tail) {
  if (pen.measureText(label).width <= room) return label;
  let low = 0, high = label.length;
  const cut = kept => tail ? `…${label.slice(label.length - kept)}` : `${label.slice(0, kept)}…`;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (pen.measureText(cut(middle)).width <= room) low = middle; else high = middle - 1;
  }
  return cut(low);
}

function text(label, x, y, color, font, align = "left") {
  pen.fillStyle = color;
  pen.font = font;
  pen.textAlign = align;
  pen.fillText(label, x, y);
}

function inside(top, height, paint) {
  pen.save();
  pen.beginPath();
  pen.rect(LEFT - 2, top - 2, width() + 4, height + 4);
  pen.clip();
  paint();
  pen.restore();
}

function line(x0, y0, x1, y1, color, thick = 1) {
  pen.strokeStyle = color;
  pen.lineWidth = thick;
  pen.beginPath();
  pen.moveTo(x0, y0);
  pen.lineTo(x1, y1);
  pen.stroke();
}

function drawTicks(top, bottom) {
  const span = view.end - view.start;
  const step = data.steps.find(step => span / step <= width() / 90) || data.steps[data.steps.length - 1];
  for (let moment = Math.ceil(view.start / step) * step; moment <= view.end; moment += step) {
    line(xOf(moment), top, xOf(moment), bottom, gridColor());
    text(clock(moment, step), xOf(moment), bottom + 15, ink(), "11px system-ui", "center");
  }
  text(`machine time, ${unit()}`, LEFT + width() / 2, bottom + 30, soft(), "11px system-ui", "center");
}

const unit = () => view.end < 12e10 ? "s" : view.end < 36e11 ? "min:s" : "h:min:s";

// A time as on a clock, with the decimals that a step of `step` ns needs.
function clock(moment, step) {
  let decimals = 0;
  while (decimals < 9 && step % 10 ** (9 - decimals)) decimals++;
  const text = (Math.round(moment / 10 ** (9 - decimals)) / 10 ** decimals).toFixed(decimals);
  if (unit() === "s") return text;
  const seconds = Math.floor(Number(text)), fraction = decimals ? text.slice(text.indexOf(".")) : "";
  const two = number => String(number).padStart(2, "0");
  const minutes = Math.floor(seconds / 60);
  if (unit() === "min:s") return `${minutes}:${two(seconds % 60)}${fraction}`;
  return `${Math.floor(minutes / 60)}:${two(minutes % 60)}:${two(seconds % 60)}${fraction}`;
}

function niceStep(span, most, least) {
  const power = 10 ** Math.floor(Math.log10(Math.max(least, span / most)));
  return [1, 2, 5, 10].map(factor => factor * power).find(step => span / step <= most);
}

// The values that are labeled from low to high: at least two, `least` or more apart.
function labeled(low, high, most, least = 1) {
  const multiples = step => {
    const found = [];
    for (let place = Math.ceil(low / step); place * step <= high; place++) found.push(place * step || 0); // no -0
    return found;
  };
  let values = multiples(niceStep(high - low, most, least));
  for (let more = most + 1; values.length < 2 && more < 50; more++) values = multiples(niceStep(high - low, more, least));
  return values;
}

// The range of values that a curve is drawn in: somewhat more than its own.
function rangeOf(least, most, fractional) {
  const usual = (most - least) * 0.08;
  const own = fractional ? usual || Math.abs(most) * 0.08 || 1 : Math.max(1, usual);
  const pad = Math.max(own, Math.abs(most) * 2 ** -40, Math.abs(least) * 2 ** -40); // doubles tell its parts apart
  return [least - pad, most + pad];
}

// A value on an axis: 12 digits at most, so that 0.1 + 0.2 is 0.3; few digits if it is too long for the margin.
const axisNumber = value => Math.abs(value) >= 1e15 ? value.toExponential(3) : number(Number(value.toPrecision(12)));

function drawCurve({ name, curve, fractional }, top, height, isTag) {
  const first = rowAt(view.start), end = Math.min(time.length, rowAt(view.end) + 2);
  const [least, most] = extremes(curve, first, end) || [0, 0];
  const [low, high] = rangeOf(least, most, fractional);
  const yOf = value => top + (high - value) / (high - low) * height;
  let widest = 0;
  for (const value of labeled(low, high, height / 28, fractional ? Number.MIN_VALUE : 1)) {
    line(LEFT, yOf(value), LEFT + width(), yOf(value), gridColor());
    text(axisNumber(value), LEFT - 6, yOf(value) + 4, ink(), SMALL, "right");
    widest = Math.max(widest, pen.measureText(axisNumber(value)).width);
  }
  if (isTag) drawTagName(name, top + height / 2 + 4, LEFT - 14 - widest);
  else text(name, 8, top + height / 2, soft(), SMALL);
  inside(top, height, () => {
    pen.strokeStyle = shade(data.colors.curve);
    pen.lineWidth = 1.4;
    pen.lineJoin = "round"; // a pointed join would show more than there is
    pen.beginPath();
    (end - first <= 2 * width() ? traceScans : traceColumns)(curve, first, end, yOf, isTag);
    pen.stroke();
  });
}

function drawTagName(name, base, right) {
  pen.font = NAME_FONT;
  text(fitted(name, right - 4, true), right, base, shade(data.colors.lanes.tag), NAME_FONT, "right");
}

// A point per scan; a tag keeps its value until the next one.
function traceScans(curve, first, end, yOf, isTag) {
  let down = false, before = 0;
  for (let row = first; row < end; row++) {
    const value = curve.values[row], there = !curve.isMissing(value), x = xOf(time[row]);
    if (there && down && isTag) pen.lineTo(x, before);
    if (there) down ? pen.lineTo(x, yOf(value)) : pen.moveTo(x, yOf(value));
    before = there ? yOf(value) : before;
    down = there;
  }
}

// One stroke per pixel, from the least to the greatest value of its scans: no peak is lost.
function traceColumns(curve, first, end, yOf) {
  let down = false, previous = 0;
  for (let x = LEFT, row = first; row < end; x++) {
    const next = Math.min(end, Math.max(row + 1, rowAt(timeAt(x + 1)) + 1));
    const found = extremes(curve, row, next);
    if (found) {
      if (previous - found[0] > found[1] - previous) found.reverse(); // it falls
      down ? pen.lineTo(x, yOf(found[0])) : pen.moveTo(x, yOf(found[0]));
      pen.lineTo(x, yOf(found[1]));
      previous = found[1];
    }
    down = found !== null;
    row = next;
  }
}

function drawMarks(panel, top, bottom, deepest) {
  const shown = panel.marks.filter(mark => mark.time >= view.start && mark.time <= view.end);
  inside(top, deepest - top, () => {
    const deep = shown.length > INSTANTS ? top + MARKS : bottom; // very many would hide the curves
    let last = -1;
    for (const mark of shown) {
      const x = xOf(mark.time);
      if (x - last >= 0.5) line(x, top + MARKS - 8, x, deep, shade(data.colors.marks[mark.kind]) + "60");
      last = x;
    }
    for (const mark of shown.filter(isBroken)) {
      line(xOf(mark.time), top + MARKS - 8, xOf(mark.time), deepest, shade(data.colors.marks[mark.kind]));
    }
    const labels = placed(shown);
    for (const { at, row, mark } of labels) {
      line(at, top + MARKS - 16 - 14 * row, at, top + MARKS, shade(data.colors.marks[mark.kind]));
    }
    for (const { x, row, mark, wide } of labels) {
      pen.fillStyle = paper();
      pen.fillRect(x + 2, top + MARKS - 17 - 14 * row, wide, 13);
      text(mark.label, x + 3, top + MARKS - 6 - 14 * row, shade(data.colors.marks[mark.kind]), MARK_FONT);
    }
  });
}

const isBroken = mark => mark.kind === "broken";

// Places of the labels of marks that fit into one of the rows; broken invariants have the first row.
// A label is behind its mark (at), or before it where it would be cut at the right edge.
function placed(marks) {
  pen.font = MARK_FONT;
  const label = (mark, row) => {
    const at = xOf(mark.time), wide = pen.measureText(mark.label).width + 2;
    return { at, x: at + wide + 3 > xOf(view.end) ? at - wide - 4 : at, row, mark, wide };
  };
  const kept = marks.filter(isBroken).map(mark => label(mark, 0));
  const ends = new Array(MARK_ROWS).fill(-Infinity), labels = [];
  for (const mark of marks.filter(mark => !isBroken(mark))) {
    const made = label(mark), { x, wide } = made;
    const isKept = row => row === 0 && kept.some(other => x < other.x + other.wide + 10 && x + wide + 10 > other.x);
    made.row = ends.findIndex((end, row) => end < x && !isKept(row));
    if (made.row < 0) continue;
    ends[made.row] = x + wide + 10;
    labels.push(made);
  }
  return [...kept, ...labels];
}

function drawCursor(height) {
  if (band) {
    pen.fillStyle = "#0060a022";
    pen.fillRect(xOf(band[0]), 0, xOf(band[1]) - xOf(band[0]), height);
  }
  if (cursor !== null) line(xOf(cursor), 0, xOf(cursor), height, ink(), 0.7);
}
