// Shows the values of the scan under the pointer, and the meaning of the colors.

function showReadout() {
  const row = rowAt(cursor === null ? view.start : cursor);
  const parts = [pairs([["time", `${(time[row] / 1e9).toFixed(6)} s`], ["scan", number(scan[row])]])];
  for (const panel of data.panels) parts.push(...panelReadout(panel, row));
  readout.replaceChildren(...parts);
}

function panelReadout(panel, row) {
  const shown = ({ name, curve, fractional }) => {
    const [title, unit] = name.split(", "), value = curve.values[row];
    if (curve.isMissing(value)) return [title, fractional ? String(value) : "–"];
    if (curve.whole) return [title, curve.whole[row].toLocaleString("en")];
    const digits = fractional ? exact(value, curve.values) : number(value);
    return [title, unit && title !== "position" ? `${digits} ${unit}` : digits];
  };
  const on = group => [...panel.lanes, ...panel.steady].filter(
    lane => lane.group === group && valueAt(lane, row)).map(lane => lane.name).join(" ") || "–";
  const near = Math.abs(timeAt(6) - timeAt(0));
  const marks = panel.marks.filter(mark => Math.abs(mark.time - (cursor === null ? -1e18 : cursor)) <= near);
  return [
    element("h2", panel.name),
    pairs([
      ...panel.curves.map(shown),
      ...(panel.ramp ? [["ramp", data.ramp[valueAt(panel.ramp, row)]]] : []),
      ...panel.bands.map(band => [band.name, band.texts[valueAt(band, row)]]),
      ...panel.unchanged.filter(([name]) => !panel.steady.some(lane => lane.name === name)),
    ]),
    ...data.groups.filter(group => [...panel.lanes, ...panel.steady].some(lane => lane.group === group)).map(group => {
      const bits = element("div", `${group === "tag" ? "on" : group}: ${on(group)}`);
      bits.className = "bits";
      bits.style.color = shade(data.colors.lanes[group]);
      return bits;
    }),
    ...marks.slice(0, 5).map(mark => element("p", mark.text)),
  ];
}

const number = value => Math.abs(value) >= 1e15 || (value && Math.abs(value) < 1e-4)
  ? value.toExponential() : value.toLocaleString("en", { maximumFractionDigits: 9 });

// A value with the digits of its type.
const exact = (value, values) => number(Number(value.toPrecision(values instanceof Float32Array ? 7 : 15)));

function element(kind, label) {
  const made = document.createElement(kind);
  made.textContent = label;
  return made;
}

function pairs(list) {
  const made = document.createElement("dl");
  for (const [name, value] of list) made.append(element("dt", name), element("dd", value));
  return made;
}

function drawLegend() {
  document.getElementById("legend").replaceChildren();
  const entries = data.groups.map(group => [shade(data.colors.lanes[group]), group === "tag" ? "tags" : `${group} bits`]);
  if (data.panels.some(panel => panel.ramp)) data.ramp.forEach((state, place) => { if (place) entries.push([data.colors.ramp[place], state]); });
  for (const [color, label] of entries) {
    const square = document.createElement("i"), entry = document.createElement("span");
    square.style.background = color;
    entry.append(square, label);
    document.getElementById("legend").append(entry);
  }
}
