// Changes the view by wheel, mouse and keys; starts the page.

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
  requestAnimationFrame(() => { waiting = false; draw(); showReadout(); });
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
  window.addEventListener("hashchange", () => { showAddress(); refresh(); });
  dark.addEventListener("change", () => { drawLegend(); refresh(); });
  window.addEventListener("keydown", event => {
    const span = view.end - view.start, middle = (view.start + view.end) / 2;
    const moves = { "+": [middle, 0.5], "-": [middle, 2] }, shifts = { ArrowLeft: -0.2, ArrowRight: 0.2 };
    if (event.key in moves) zoom(...moves[event.key]);
    else if (event.key in shifts) show(view.start + shifts[event.key] * span, view.end + shifts[event.key] * span);
    else if (event.key === "Home") show(ALL.start, ALL.end);
  });
}

// Shows the times in the address; shows everything if they are not times.
function showAddress() {
  const asked = new URLSearchParams(location.hash.slice(1));
  const [from, to] = ["from", "to"].map(name => asked.has(name) ? Number(asked.get(name) || NaN) * 1e9 : NaN);
  if (from < to) show(from, to);
  else view = { ...ALL };
}

async function begin() {
  time = await unpack(data.time, Float64Array);
  scan = await unpack(data.scan, Int32Array);
  for (const panel of data.panels) {
    for (const each of panel.curves) each.curve = await unpackCurve(each);
  }
  drawLegend();
  listen();
  showAddress();
  draw();
  showReadout();
  document.body.dataset.ready = "yes";
}

begin().catch(error => { readout.textContent = `The page can't be shown: ${error}`; });
