// Tells the scan under the pointer, and what the colours mean.

function tell() {
  const row = rowAt(cursor === null ? view.start : cursor);
  const parts = [pairs([["time", `${(time[row] / 1e9).toFixed(6)} s`], ["scan", number(scan[row])]])];
  for (const panel of data.panels) parts.push(...tellPanel(panel, row));
  readout.replaceChildren(...parts);
}

function tellPanel(panel, row) {
  const shown = ({ name, curve }) => {
    const [title, unit] = name.split(", "), value = curve.values[row];
    return [title, value === MISSING ? "–" : unit && title !== "position" ? `${number(value)} ${unit}` : number(value)];
  };
  const on = group => [...panel.lanes, ...panel.steady].filter(
    lane => lane.group === group && valueAt(lane, row)).map(lane => lane.name).join(" ") || "–";
  const near = Math.abs(timeAt(6) - timeAt(0));
  const marks = panel.marks.filter(mark => Math.abs(mark.time - (cursor === null ? -1e18 : cursor)) <= near);
  return [
    element("h2", `slot ${panel.slot}`),
    pairs([
      ...panel.curves.map(shown),
      ...(panel.ramp ? [["ramp", data.ramp[valueAt(panel.ramp, row)]]] : []),
    ]),
    ...data.groups.filter(group => [...panel.lanes, ...panel.steady].some(lane => lane.group === group)).map(group => {
      const bits = element("div", `${group}: ${on(group)}`);
      bits.className = "bits";
      bits.style.color = shade(data.colours.lanes[group]);
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
  document.getElementById("legend").replaceChildren();
  const entries = data.groups.map(group => [shade(data.colours.lanes[group]), `${group} bits`]);
  if (data.panels.some(panel => panel.ramp)) data.ramp.forEach((state, place) => { if (place) entries.push([data.colours.ramp[place], state]); });
  for (const [colour, says] of entries) {
    const square = document.createElement("i"), entry = document.createElement("span");
    square.style.background = colour;
    entry.append(square, says);
    document.getElementById("legend").append(entry);
  }
}
