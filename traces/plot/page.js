"use strict";
// The chart in the page. Time is in ns since power-up, x and y in CSS pixels.

const data = JSON.parse(document.getElementById("data").textContent);
const canvas = document.getElementById("chart");
const readout = document.getElementById("readout");
const pen = canvas.getContext("2d");
const LEFT = 150, RIGHT = 14, TOP = 6, AXIS = 40;
const MARKS = 50, POSITION = 150, SPEED = 96, LANE = 18, GAP = 14, MARK_ROWS = 3;
const INSTANTS = 120; // most lines through the curves for marks
const MARK_FONT = "11px system-ui";
const GROUP = 64; // rows of which least and greatest are kept at hand
const MISSING = -2147483648;
const LEAST_SPAN = 1e5; // ns across the chart when zoomed in as far as it goes
const ALL = { start: data.start, end: Math.max(data.end, data.start + 1) };
let view = { ...ALL };
let cursor = null; // time under the pointer
let band = null; // [time, time] while an area to zoom into is drawn
let time, scan; // of every scan: Float64Array, Int32Array

// -- the data ---------------------------------------------------------------------------------------

// A packed column: differences from scan to scan, deflated, base64. Int32 sums wrap, as they did when packed.
async function unpack(text, Kind) {
  const bytes = Uint8Array.from(atob(text), letter => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const values = new Kind(await new Response(stream).arrayBuffer());
  for (let i = 1; i < values.length; i++) values[i] += values[i - 1];
  return values;
}

function curve(values) {
  const groups = Math.ceil(values.length / GROUP);
  const low = new Int32Array(groups).fill(2147483647), high = new Int32Array(groups).fill(MISSING);
  let least = Infinity, most = -Infinity;
  for (let i = 0; i < values.length; i++) {
    const value = values[i];
    if (value === MISSING) continue;
    const group = i / GROUP | 0;
    if (value < low[group]) low[group] = value;
    if (value > high[group]) high[group] = value;
    if (value < least) least = value;
    if (value > most) most = value;
  }
  if (least > most) least = most = 0;
  return { values, low, high, least, most };
}

// Least and greatest of the rows first to end - 1, or null where there is no value.
function extremes(curve, first, end) {
  let least = Infinity, most = -Infinity;
  const take = (low, high) => { if (low < least) least = low; if (high > most) most = high; };
  for (let i = first; i < end;) {
    if (i % GROUP === 0 && i + GROUP <= end) {
      if (curve.high[i / GROUP] >= curve.low[i / GROUP]) take(curve.low[i / GROUP], curve.high[i / GROUP]);
      i += GROUP;
    } else {
      if (curve.values[i] !== MISSING) take(curve.values[i], curve.values[i]);
      i++;
    }
  }
  return least > most ? null : [least, most];
}

// Index of the first entry of a sorted list that is greater than a value.
function above(list, value) {
  let low = 0, high = list.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (list[middle] > value) high = middle; else low = middle + 1;
  }
  return low;
}

const rowAt = moment => Math.max(0, above(time, moment) - 1);
const stepAt = (lane, row) => Math.max(0, above(lane.rows, row) - 1);
const valueAt = (lane, row) => lane.values ? lane.values[stepAt(lane, row)] : (stepAt(lane, row) + lane.first) % 2;

// -- drawing ----------------------------------------------------------------------------------------

const width = () => canvas.clientWidth - LEFT - RIGHT;
const xOf = moment => LEFT + (moment - view.start) / (view.end - view.start) * width();
const timeAt = x => view.start + (x - LEFT) / width() * (view.end - view.start);
const panelHeight = panel => MARKS + POSITION + SPEED + LANE * (1 + panel.lanes.length) + 2 * GAP + AXIS;

function draw() {
  const scale = window.devicePixelRatio || 1;
  const height = TOP + data.panels.reduce((sum, panel) => sum + panelHeight(panel), 0);
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
  const bottom = top + panelHeight(panel) - AXIS;
  drawTicks(top + MARKS, bottom);
  text(`slot ${panel.slot}`, 8, top + 18, "#222", "bold 14px system-ui");
  text(panel.module, 8, top + 34, "#555", "12px system-ui");
  drawMarks(panel, top, top + MARKS + POSITION + GAP + SPEED);
  top += MARKS;
  drawCurve(panel.position, "position, steps", top, POSITION);
  top += POSITION + GAP;
  drawCurve(panel.speed, "speed, steps/s", top, SPEED);
  top += SPEED + GAP;
  drawRamp(panel.ramp, top);
  for (const lane of panel.lanes) drawBit(lane, top += LANE);
  return bottom + AXIS;
}

function text(says, x, y, colour, font, align = "left") {
  pen.fillStyle = colour;
  pen.font = font;
  pen.textAlign = align;
  pen.fillText(says, x, y);
}

function inside(top, height, paint) {
  pen.save();
  pen.beginPath();
  pen.rect(LEFT - 2, top - 2, width() + 4, height + 4);
  pen.clip();
  paint();
  pen.restore();
}

function line(x0, y0, x1, y1, colour, thick = 1) {
  pen.strokeStyle = colour;
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
    line(xOf(moment), top, xOf(moment), bottom, data.colours.grid);
    text(clock(moment, step), xOf(moment), bottom + 15, "#222", "11px system-ui", "center");
  }
  text(`machine time, ${unit()}`, LEFT + width() / 2, bottom + 30, "#555", "11px system-ui", "center");
}

const unit = () => view.end < 12e10 ? "s" : view.end < 36e11 ? "min:s" : "h:min:s";

// A time as a clock shows it, with as many decimals as a step of so many ns needs.
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

function niceStep(span, most) {
  const power = 10 ** Math.floor(Math.log10(Math.max(1, span / most)));
  return [1, 2, 5, 10].map(factor => factor * power).find(step => span / step <= most);
}

function drawCurve(curve, name, top, height) {
  const first = rowAt(view.start), end = Math.min(time.length, rowAt(view.end) + 2);
  const [least, most] = extremes(curve, first, end) || [0, 0];
  const pad = Math.max(1, (most - least) * 0.08), low = least - pad, high = most + pad;
  const yOf = value => top + (high - value) / (high - low) * height;
  const step = niceStep(high - low, height / 28);
  for (let place = Math.ceil(low / step); place * step <= high; place++) {
    const value = place * step || 0; // no -0
    line(LEFT, yOf(value), LEFT + width(), yOf(value), data.colours.grid);
    text(value.toLocaleString("en"), LEFT - 6, yOf(value) + 4, "#222", "11px system-ui", "right");
  }
  text(name, 8, top + height / 2, "#555", "11px system-ui");
  inside(top, height, () => {
    pen.strokeStyle = data.colours.curve;
    pen.lineWidth = 1.4;
    pen.beginPath();
    (end - first <= 2 * width() ? traceScans : traceColumns)(curve, first, end, yOf);
    pen.stroke();
  });
}

function traceScans(curve, first, end, yOf) {
  let down = false;
  for (let row = first; row < end; row++) {
    const value = curve.values[row];
    if (value !== MISSING) down ? pen.lineTo(xOf(time[row]), yOf(value)) : pen.moveTo(xOf(time[row]), yOf(value));
    down = value !== MISSING;
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

// Calls paint(x0, x1, value) for each stretch of a lane, changes on one pixel taken together: first and last.
function stretches(lane, paint) {
  const right = LEFT + width();
  let step = stepAt(lane, rowAt(view.start));
  let value = lane.values ? lane.values[step] : (step + lane.first) % 2;
  let x = LEFT - 2;
  while (x < right) {
    const row = lane.rows[step + 1];
    const next = row === undefined ? right : Math.min(right, xOf(time[row]));
    paint(x, next, value, row !== undefined && next < right);
    if (row === undefined) return;
    const last = above(lane.rows, rowAt(timeAt(Math.floor(next) + 1))) - 1; // of the changes on this pixel
    step = Math.max(step + 1, last);
    value = lane.values ? lane.values[step] : (step + lane.first) % 2;
    x = next;
  }
}

function drawBit(lane, top) {
  const colour = data.colours.lanes[lane.group], high = top + 3, low = top + LANE - 3;
  text(lane.name, LEFT - 6, low - 1, colour, "11px ui-monospace, monospace", "right");
  inside(top, LANE, () => {
    pen.strokeStyle = colour;
    pen.fillStyle = colour + "50";
    pen.lineWidth = 1.2;
    pen.beginPath();
    stretches(lane, (x0, x1, value, turns) => {
      if (value) pen.fillRect(x0, high, Math.max(1, x1 - x0), low - high);
      pen.moveTo(x0, value ? high : low);
      pen.lineTo(x1, value ? high : low);
      if (turns) { pen.moveTo(x1, high); pen.lineTo(x1, low); }
    });
    pen.stroke();
  });
}

function drawRamp(lane, top) {
  text("ramp", LEFT - 6, top + LANE - 4, "#222", "11px ui-monospace, monospace", "right");
  inside(top, LANE, () => stretches(lane, (x0, x1, value) => {
    pen.fillStyle = data.colours.ramp[value];
    if (value) pen.fillRect(x0, top + 2, Math.max(1, x1 - x0), LANE - 4);
  }));
}

function drawMarks(panel, top, bottom) {
  const shown = panel.marks.filter(mark => mark.time >= view.start && mark.time <= view.end);
  inside(top, bottom - top, () => {
    const deep = shown.length > INSTANTS ? top + MARKS : bottom; // very many would hide the curves
    let last = -1;
    for (const mark of shown) {
      const x = xOf(mark.time);
      if (x - last >= 0.5) line(x, top + MARKS - 8, x, deep, data.colours.marks[mark.kind] + "60");
      last = x;
    }
    const labels = placed(shown);
    for (const { x, row, mark } of labels) {
      line(x, top + MARKS - 16 - 14 * row, x, top + MARKS, data.colours.marks[mark.kind]);
    }
    for (const { x, row, mark, wide } of labels) {
      pen.fillStyle = "#fff";
      pen.fillRect(x + 2, top + MARKS - 17 - 14 * row, wide, 13);
      text(mark.label, x + 3, top + MARKS - 6 - 14 * row, data.colours.marks[mark.kind], MARK_FONT);
    }
  });
}

// Where the labels of marks stand that find room in one of the rows.
function placed(marks) {
  const ends = new Array(MARK_ROWS).fill(-Infinity), labels = [];
  pen.font = MARK_FONT;
  for (const mark of marks) {
    const x = xOf(mark.time), row = ends.findIndex(end => end < x);
    if (row < 0) continue;
    const wide = pen.measureText(mark.label).width + 2;
    ends[row] = x + wide + 10;
    labels.push({ x, row, mark, wide });
  }
  return labels;
}

function drawCursor(height) {
  if (band) {
    pen.fillStyle = "#0060a022";
    pen.fillRect(xOf(band[0]), 0, xOf(band[1]) - xOf(band[0]), height);
  }
  if (cursor !== null) line(xOf(cursor), 0, xOf(cursor), height, "#222", 0.7);
}

// -- the readout ------------------------------------------------------------------------------------

function tell() {
  const row = rowAt(cursor === null ? view.start : cursor);
  const parts = [pairs([["time", `${(time[row] / 1e9).toFixed(6)} s`], ["scan", number(scan[row])]])];
  for (const panel of data.panels) parts.push(...tellPanel(panel, row));
  readout.replaceChildren(...parts);
}

function tellPanel(panel, row) {
  const position = panel.position.values[row];
  const on = group => [...panel.lanes, ...panel.steady].filter(
    lane => lane.group === group && valueAt(lane, row)).map(lane => lane.name).join(" ") || "–";
  const near = Math.abs(timeAt(6) - timeAt(0));
  const marks = panel.marks.filter(mark => Math.abs(mark.time - (cursor === null ? -1e18 : cursor)) <= near);
  return [
    element("h2", `slot ${panel.slot}`),
    pairs([
      ["position", position === MISSING ? "–" : number(position)],
      ["speed", `${number(panel.speed.values[row])} steps/s`],
      ["ramp", data.ramp[valueAt(panel.ramp, row)]],
    ]),
    ...data.groups.map(group => {
      const bits = element("div", `${group}: ${on(group)}`);
      bits.className = "bits";
      bits.style.color = data.colours.lanes[group];
      return bits;
    }),
    ...marks.slice(0, 5).map(mark => element("p", mark.text)),
  ];
}

const number = value => value.toLocaleString("en");

function element(kind, says) {
  const made = document.createElement(kind);
  made.textContent = says;
  return made;
}

function pairs(list) {
  const made = document.createElement("dl");
  for (const [name, value] of list) made.append(element("dt", name), element("dd", value));
  return made;
}

function drawLegend() {
  const entries = data.groups.map(group => [data.colours.lanes[group], `${group} bits`]);
  data.ramp.forEach((state, place) => { if (place) entries.push([data.colours.ramp[place], state]); });
  for (const [colour, says] of entries) {
    const square = document.createElement("i"), entry = document.createElement("span");
    square.style.background = colour;
    entry.append(square, says);
    document.getElementById("legend").append(entry);
  }
}

// -- the pointer ------------------------------------------------------------------------------------

function show(start, end) {
  const span = Math.min(ALL.end - ALL.start, Math.max(LEAST_SPAN, end - start));
  const from = Math.min(ALL.end - span, Math.max(ALL.start, start));
  view = { start: from, end: from + span };
  history.replaceState(null, "", `#from=${view.start / 1e9}&to=${view.end / 1e9}`);
  refresh();
}

let waiting = false;
function refresh() {
  if (waiting) return;
  waiting = true;
  requestAnimationFrame(() => { waiting = false; draw(); tell(); });
}

function zoom(moment, factor) {
  show(moment - (moment - view.start) * factor, moment + (view.end - moment) * factor);
}

function listen() {
  let grabbed = null;
  const moment = event => timeAt(event.clientX - canvas.getBoundingClientRect().left);
  canvas.addEventListener("wheel", event => {
    event.preventDefault();
    zoom(moment(event), 1.0015 ** event.deltaY);
  }, { passive: false });
  canvas.addEventListener("pointerdown", event => {
    canvas.setPointerCapture(event.pointerId);
    grabbed = { x: event.clientX, view: { ...view }, zooms: event.shiftKey, from: moment(event) };
  });
  canvas.addEventListener("pointermove", event => {
    cursor = Math.min(view.end, Math.max(view.start, moment(event)));
    if (grabbed && grabbed.zooms) band = [grabbed.from, moment(event)];
    else if (grabbed) {
      const by = (event.clientX - grabbed.x) / width() * (grabbed.view.end - grabbed.view.start);
      show(grabbed.view.start - by, grabbed.view.end - by);
    }
    refresh();
  });
  canvas.addEventListener("pointerup", () => {
    if (band) show(Math.min(...band), Math.max(...band));
    grabbed = band = null;
    refresh();
  });
  canvas.addEventListener("pointerleave", () => { cursor = null; refresh(); });
  canvas.addEventListener("dblclick", () => show(ALL.start, ALL.end));
  window.addEventListener("resize", refresh);
  window.addEventListener("keydown", event => {
    const span = view.end - view.start, middle = (view.start + view.end) / 2;
    const moves = { "+": [middle, 0.5], "-": [middle, 2] }, shifts = { ArrowLeft: -0.2, ArrowRight: 0.2 };
    if (event.key in moves) zoom(...moves[event.key]);
    else if (event.key in shifts) show(view.start + shifts[event.key] * span, view.end + shifts[event.key] * span);
    else if (event.key === "Home") show(ALL.start, ALL.end);
  });
}

async function begin() {
  time = await unpack(data.time, Float64Array);
  scan = await unpack(data.scan, Int32Array);
  for (const panel of data.panels) {
    panel.position = curve(await unpack(panel.position, Int32Array));
    panel.speed = curve(await unpack(panel.speed, Int32Array));
  }
  drawLegend();
  listen();
  const asked = new URLSearchParams(location.hash.slice(1));
  if (asked.has("from") && asked.has("to")) show(asked.get("from") * 1e9, asked.get("to") * 1e9);
  draw();
  tell();
  document.body.dataset.ready = "yes";
}

begin().catch(error => { readout.textContent = `The page can't be shown: ${error}`; });
