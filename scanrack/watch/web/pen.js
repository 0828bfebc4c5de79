// Draws on a canvas: sharp on any screen, in the colors of the style sheet.

const FONT = '11px ui-monospace, "DejaVu Sans Mono", Menlo, Consolas, monospace';
const SMALL_FONT = '10px ui-monospace, "DejaVu Sans Mono", Menlo, Consolas, monospace';

const dark = matchMedia("(prefers-color-scheme: dark)");
export const colors = { onChange(redraw) { dark.addEventListener("change", () => { readColors(); redraw(); }); } };

function readColors() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ["ink", "soft", "grid", "edge", "curve", "bit", "mark", "panel", "fault"])
    colors[name] = style.getPropertyValue(`--${name}`).trim();
}

// Clears a canvas, sets its size in CSS pixels, and returns a pen for it.
export function pen(canvas, wide, high) {
  if (!colors.ink) readColors();
  const scale = devicePixelRatio || 1, context = canvas.getContext("2d");
  if (canvas.width !== Math.round(wide * scale) || canvas.height !== Math.round(high * scale)) {
    canvas.width = Math.round(wide * scale);
    canvas.height = Math.round(high * scale);
    canvas.style.height = `${high}px`;
  }
  context.setTransform(scale, 0, 0, scale, 0, 0);
  context.clearRect(0, 0, wide, high);
  return new Pen(context, wide);
}

class Pen {
  constructor(context, wide) {
    this.context = context;
    this.wide = wide;
  }

  line(x0, y0, x1, y1, color, thick = 1) {
    this.begin(color, thick);
    this.from(x0, y0);
    this.to(x1, y1);
    this.end();
  }

  begin(color, thick) {
    this.context.strokeStyle = color;
    this.context.lineWidth = thick;
    this.context.lineJoin = "round";
    this.context.beginPath();
  }

  from(x, y) { this.context.moveTo(x, y); }
  to(x, y) { this.context.lineTo(x, y); }
  end() { this.context.stroke(); }

  rect(x, y, wide, high, color) {
    this.context.fillStyle = color;
    this.context.fillRect(x, y, wide, high);
  }

  frame(x, y, wide, high, color) {
    this.context.strokeStyle = color;
    this.context.lineWidth = 1;
    this.context.strokeRect(Math.round(x) + 0.5, Math.round(y) + 0.5, wide, high);
  }

  dot(x, y, color) { this.disc(x, y, 2.4, color); }

  disc(x, y, radius, color) {
    this.context.fillStyle = color;
    this.context.beginPath();
    this.context.arc(x, y, radius, 0, 7);
    this.context.fill();
  }

  text(string, x, y, color, align = "left", font = FONT) {
    this.context.fillStyle = color;
    this.context.font = font;
    this.context.textAlign = align;
    this.context.fillText(string, x, y);
  }

  small(string, x, y) { this.text(string, x, y, colors.soft, "right", SMALL_FONT); }

  // The name of a lane, to the left of it; the end of a long name is left out.
  label(string, x, y, color) {
    const most = Math.floor((x - 4) / 6.7);
    this.text(string.length > most ? `${string.slice(0, most - 1)}…` : string, x, y, color, "right");
  }

  // Calls paint() with drawing limited to a lane that ends `right` pixels before the end of the canvas.
  clipped(left, top, paint, right = 0, high = 400) {
    this.context.save();
    this.context.beginPath();
    this.context.rect(left, top - 4, this.wide - left - right, high);
    this.context.clip();
    paint();
    this.context.restore();
  }
}
