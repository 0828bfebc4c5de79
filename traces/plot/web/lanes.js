// Draws the lanes of a panel: ramp, bands, bits, and the unchanged tags in one line.

// Calls paint(x0, x1, value) for each stretch of a lane, changes on one pixel taken together: first and last.
function stretches(lane, paint) {
  const right = LEFT + width();
  let step = stepAt(lane, rowAt(view.start));
  let value = stepValue(lane, step);
  let x = LEFT - 2;
  while (x < right) {
    const row = lane.rows[step + 1];
    const next = row === undefined ? right : Math.min(right, xOf(time[row]));
    paint(x, next, value, row !== undefined && next < right);
    if (row === undefined) return;
    const last = above(lane.rows, rowAt(timeAt(Math.floor(next) + 1))) - 1; // of the changes on this pixel
    step = Math.max(step + 1, last);
    value = stepValue(lane, step);
    x = next;
  }
}

function drawBit(lane, top) {
  const color = shade(data.colors.lanes[lane.group]), high = top + 3, low = top + LANE - 3;
  pen.font = NAME_FONT;
  text(fitted(lane.name, LEFT - 12, true), LEFT - 6, low - 1, color, NAME_FONT, "right");
  inside(top, LANE, () => {
    pen.strokeStyle = color;
    pen.fillStyle = color + "50";
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
  text("ramp", LEFT - 6, top + LANE - 4, ink(), NAME_FONT, "right");
  inside(top, LANE, () => stretches(lane, (x0, x1, value) => {
    pen.fillStyle = data.colors.ramp[value];
    if (value) pen.fillRect(x0, top + 2, Math.max(1, x1 - x0), LANE - 4);
  }));
}

// Steps and texts: a color for each value, and its meaning if there is room.
function drawBand(band, top) {
  pen.font = NAME_FONT;
  text(fitted(band.name, LEFT - 12, true), LEFT - 6, top + LANE - 4, shade(data.colors.lanes.tag), NAME_FONT, "right");
  inside(top, LANE, () => stretches(band, (x0, x1, value) => {
    pen.fillStyle = bandColor(value);
    pen.fillRect(x0, top + 2, Math.max(1, x1 - x0), LANE - 4);
    pen.font = SMALL;
    const left = Math.max(x0, LEFT), room = x1 - left - 7, label = band.texts[value];
    if (room >= Math.min(pen.measureText(label).width, LEAST_LABEL)) {
      text(fitted(label, room, false), left + 4, top + LANE - 5, ink(), SMALL);
    }
  }));
}

// Soft on either paper: letters are written on it.
const bandColor = value => {
  const tints = dark.matches ? data.colors.bandDark : data.colors.band;
  return tints[value % tints.length];
};

// The unchanged values in one line; the readout has all of them.
function drawUnchanged(pairs, top) {
  pen.font = SMALL;
  const line = fitted(pairs.map(pair => pair.join(" ")).join("   "), width() - 6, false);
  text("unchanged", LEFT - 6, top + LANE - 4, soft(), NAME_FONT, "right");
  text(line, LEFT + 3, top + LANE - 4, soft(), SMALL);
}
