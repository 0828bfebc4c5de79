"""The chart as a PNG or SVG picture.

inches     left                                                     right
top        title
per slot   marks       |  v CMD-03      ^ capture on                 |
position    |  ~~~~~~~~~                                  |
speed       |  ~~~~~~~~~                                  |
ramp, bits  |  one row each, the name at the left         |
program     the same: numbers, steps and texts as bands, BOOLs
bottom     time axis
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..extras import need
from ..newfile import new_file
from . import axis, colours
from .chart import Chart, Panel, groups_of
from .envelope import Curve
from .labels import listed, placed, shortened
from .lanes import GROUPS, RAMP_STATES, REST, Band, Lane, at_pixels
from .marks import Mark

DPI = 110
WIDTH = 13.0
LEFT, RIGHT = 1.75, 0.25
TOP = 0.72
MARKS, HEAD, POSITION, SPEED, NUMBER, LANE, AXIS, GAP = 0.62, 0.3, 1.5, 0.95, 0.55, 0.2, 0.5, 0.16
"""Sizes in inches; HEAD is that of a panel without marks, NUMBER the height of a tag's curve."""

PIXELS = round((WIDTH - LEFT - RIGHT) * DPI)
"""Pixels across the time axis."""

EDGE = 0.004
"""Room before the first and after the last scan, as a part of the time axis: a pulse there must be seen."""

INSTANTS_MAX = 60
"""Most lines through a curve for marks of one kind."""

CROWDED = PIXELS // 3
"""Changes of a bit beyond which its line is drawn thin."""

TICKS_MAX = 12
SHORT_MAX = 10**7
"""Values from here on are written with an exponent beside a tag's curve."""

LABEL_ROWS = 3
POINTS_PER_INCH = 72
LABEL_SIZE, NAME_SIZE = 7.5, 8.0
NAME_LETTERS = 23
"""Letters of a name that fit to the left of its lane."""

LABEL_LETTERS = 8
"""Letters of a band's label that must fit; a shorter one is not drawn."""

LETTER = 0.58 * LABEL_SIZE / POINTS_PER_INCH
"""Width of a letter of a label, inches."""

FORMATS = (".png", ".svg")

_STYLE = {
    "font.size": 9,
    "svg.hashsalt": "scanrack",  # the same chart gives the same file
    "svg.fonttype": "none",
    "axes.unicode_minus": False,
}


def save_figure(chart: Chart[Curve], path: Path | str) -> None:
    """Draw a chart into a PNG or SVG file, by the path's suffix.

    Raises:
        MissingExtraError: matplotlib is not installed.
        ValueError: another suffix.
    """
    path = Path(path)
    if path.suffix.lower() not in FORMATS:
        raise ValueError(f"{path}: a picture is a .png or .svg file")
    matplotlib = need("matplotlib", "plot")
    figures = need("matplotlib.figure", "plot")
    with matplotlib.rc_context(_STYLE):
        figure = draw(chart, figures.Figure)
        kind = path.suffix.lower()[1:]
        silent = {"Software": None} if kind == "png" else {"Date": None, "Creator": None}
        with new_file(path, "wb") as file:
            figure.savefig(file, format=kind, dpi=DPI, metadata=silent)


def draw(chart: Chart[Curve], figure_class: Any) -> Any:
    """Return the figure of a chart."""
    height = TOP + sum(_panel_height(panel) for panel in chart.panels)
    figure = figure_class(figsize=(WIDTH, height), facecolor="white")
    _title(figure, chart, height)
    top = height - TOP
    for panel in chart.panels:
        top = _draw_panel(_Canvas(figure, chart, height), panel, top)
    return figure


def _panel_height(panel: Panel[Curve]) -> float:
    curves = sum(_curve_height(panel, place) + GAP for place in range(len(panel.curves)))
    return _head_height(panel) + curves + LANE * _rows(panel) + AXIS


def _head_height(panel: Panel[Curve]) -> float:
    return MARKS if panel.marks else HEAD


def _curve_height(panel: Panel[Curve], place: int) -> float:
    if panel.slot is None:
        return NUMBER
    return POSITION if place == 0 and panel.ramp is not None else SPEED


def _rows(panel: Panel[Curve]) -> int:
    """Return how many rows the lanes of a panel take; at least one, which bears the time axis."""
    return max(1, len(panel.bands) + len(panel.lanes) + (panel.ramp is not None) + bool(panel.unchanged))


class _Canvas:
    """Places axes on a figure, from top to bottom, all with the chart's time axis."""

    def __init__(self, figure: Any, chart: Chart[Curve], height: float) -> None:
        self.figure, self.chart, self._height = figure, chart, height

    def axes(self, top: float, height: float) -> Any:
        """Return new axes whose upper edge is so many inches above the lower edge of the figure."""
        box = (
            LEFT / WIDTH,
            (top - height) / self._height,
            (WIDTH - LEFT - RIGHT) / WIDTH,
            height / self._height,
        )
        axes = self.figure.add_axes(box)
        edge = max(1, self.chart.end_ns - self.chart.start_ns) * EDGE
        axes.set_xlim(self.chart.start_ns - edge, self.chart.end_ns + edge)
        axes.set_xticks(axis.ticks(self.chart.start_ns, self.chart.end_ns, TICKS_MAX), labels=[])
        axes.grid(axis="x", color=colours.GRID, linewidth=0.6)
        axes.set_axisbelow(True)
        axes.tick_params(length=0, labelsize=NAME_SIZE, colors=colours.INK)
        for spine in axes.spines.values():
            spine.set_color(colours.GRID)
        return axes


def _title(figure: Any, chart: Chart[Curve], height: float) -> None:
    figure.text(LEFT / WIDTH, 1 - 0.24 / height, chart.title, size=12, weight="bold", va="center")
    about = axis.about(chart.first, chart.last, chart.start_ns, chart.end_ns)
    figure.text(1 - RIGHT / WIDTH, 1 - 0.24 / height, about, size=NAME_SIZE, va="center", ha="right")
    at = LEFT / WIDTH
    for group in groups_of(chart):
        colour = colours.LANES[group]
        text = f"■ {_GROUP_TITLES[group]}"
        figure.text(at, 1 - 0.48 / height, text, size=NAME_SIZE, color=colour, va="center")
        at += (0.2 + 0.07 * len(text)) / WIDTH
    ramps = zip(RAMP_STATES, colours.RAMP, strict=True)
    for state, colour in list(ramps)[1:] if any(panel.ramp for panel in chart.panels) else ():
        figure.text(at, 1 - 0.48 / height, "■", size=NAME_SIZE + 2, color=colour, va="center")
        figure.text(at + 0.16 / WIDTH, 1 - 0.48 / height, state, size=NAME_SIZE, va="center")
        at += (0.36 + 0.07 * len(state)) / WIDTH


_GROUP_TITLES = {
    "command": "command bits",
    "status": "status bits",
    "error": "error bits",
    "input": "inputs",
    "output": "outputs",
    "tag": "tags",
}


def _draw_panel(canvas: _Canvas, panel: Panel[Curve], top: float) -> float:
    """Draw a panel; return where the next one begins."""
    _draw_marks(canvas, panel, top)
    top -= _head_height(panel)
    for place, (name, curve) in enumerate(panel.curves):
        axes = canvas.axes(top, _curve_height(panel, place))
        if panel.slot is None:
            _draw_number(axes, curve, name, fractional=name in panel.fractional)
        else:
            _draw_curve(axes, curve, name)
        if place == 1 and panel.ramp is not None:  # the speed
            axes.axhline(0, color=colours.INK, linewidth=0.4)
        _draw_instants(axes, panel)
        top -= _curve_height(panel, place) + GAP
    height = LANE * _rows(panel)
    lanes = canvas.axes(top, height)
    _draw_lanes(lanes, panel, canvas.chart)
    _draw_time(lanes, canvas.chart)
    return top - height - AXIS


def _draw_curve(axes: Any, curve: Curve, name: str) -> None:
    axes.plot(*curve.line(), color=colours.CURVE, linewidth=1.2, solid_joinstyle="round")
    axes.set_ylabel(name, size=NAME_SIZE)
    axes.yaxis.set_major_formatter("{x:,.0f}")
    axes.locator_params(axis="y", nbins=5, integer=True)
    axes.grid(axis="y", color=colours.GRID, linewidth=0.6)
    axes.margins(y=0.08)


def _draw_number(axes: Any, curve: Curve, name: str, *, fractional: bool) -> None:
    """Draw a tag in stairs: a value holds until the next scan."""
    axes.plot(*curve.line(), color=colours.CURVE, linewidth=1.2, drawstyle="steps-post")
    axes.yaxis.set_major_formatter(lambda value, place: _short(value))
    axes.locator_params(axis="y", nbins=3, integer=not fractional)
    axes.grid(axis="y", color=colours.GRID, linewidth=0.6)
    axes.margins(y=0.1)
    style = {"size": NAME_SIZE - 0.5, "color": colours.LANES["tag"], "family": "monospace", "va": "center"}
    left_of_values = -0.06
    says = shortened(name, NAME_LETTERS - 8)
    axes.text(left_of_values, 0.5, says, transform=axes.transAxes, ha="right", **style)


def _short(value: float) -> str:
    """Return a value for an axis, in nine letters or so."""
    return f"{value:,.7g}" if abs(value) < SHORT_MAX else f"{value:.4g}"


def _draw_instants(axes: Any, panel: Panel[Curve]) -> None:
    """Draw a thin line through a curve where a rule fired or the machine acted, unless they would hide it."""
    for kind in ("stimulus", "rule", "broken"):
        times = [mark.time_ns for mark in panel.marks if mark.kind == kind]
        if len(times) > INSTANTS_MAX:
            continue
        upright = axes.get_xaxis_transform()
        axes.vlines(times, 0, 1, transform=upright, color=colours.MARKS[kind], linewidth=0.5, alpha=0.45)


def _draw_marks(canvas: _Canvas, panel: Panel[Curve], top: float) -> None:
    """Draw what happened: a tick for everything, a label where there is room."""
    axes = canvas.axes(top, _head_height(panel))
    axes.axis("off")
    axes.set_ylim(0, 1)
    for kind, colour in colours.MARKS.items():
        times = [mark.time_ns for mark in panel.marks if mark.kind == kind]
        axes.vlines(times, 0, 0.12, color=colour, linewidth=1.0)
    letter = LETTER / (WIDTH - LEFT - RIGHT)  # as a part of the axis
    labels = placed(panel.marks, canvas.chart.start_ns, canvas.chart.end_ns, letter, LABEL_ROWS)
    for mark, row in labels:
        _draw_label(axes, mark, 0.16 + 0.29 * row)
    name = f"{panel.name}  {panel.about}"
    axes.text(-0.145, 0.62 if panel.marks else 0.5, name, transform=axes.transAxes, size=9.5, weight="bold")
    untold = len(panel.marks) - len(labels)
    if untold:
        more = "more mark" if untold == 1 else "more marks"
        axes.text(-0.145, 0.25, f"{untold:,} {more}", transform=axes.transAxes, size=LABEL_SIZE)


def _draw_label(axes: Any, mark: Mark, height: float) -> None:
    colour = colours.MARKS[mark.kind]
    axes.vlines(mark.time_ns, 0, height + 0.2, color=colour, linewidth=0.5, zorder=1)
    axes.annotate(
        mark.label,
        (mark.time_ns, height),
        xytext=(2, 0),
        textcoords="offset points",
        size=LABEL_SIZE,
        color=colour,
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.3},
        zorder=2,
    )


def _draw_lanes(axes: Any, panel: Panel[Curve], chart: Chart[Curve]) -> None:
    """Draw ramp, bands and bits, the ramp on top, and below them what does not change."""
    ramp = [] if panel.ramp is None else [panel.ramp]
    rows = [*ramp, *panel.bands, *panel.lanes]
    axes.set_ylim(_rows(panel), 0)
    for row, lane in enumerate(rows):
        _DRAW[lane.group](axes, lane, chart, row)
    names = [(shortened(lane.name, NAME_LETTERS), _name_colour(lane)) for lane in rows]
    if panel.unchanged:
        letters = round((WIDTH - LEFT - RIGHT) / LETTER)
        _write(axes, listed(panel.unchanged, letters), chart.start_ns, len(rows))
        names.append(("unchanged", colours.INK))
    axes.set_yticks(np.arange(len(names)) + 0.5, labels=[name for name, _ in names])
    for label, (_, colour) in zip(axes.get_yticklabels(), names, strict=True):
        label.set_color(colour)
        label.set_fontfamily("monospace")
        label.set_fontsize(NAME_SIZE - 0.5)


def _name_colour(lane: Lane) -> str:
    return colours.LANES.get("tag" if isinstance(lane, Band) else lane.group, colours.INK)


def _write(axes: Any, text: str, time_ns: int, row: int) -> None:
    """Write a text into a row, from a time on."""
    at = (time_ns, row + 0.5)
    style = {"size": LABEL_SIZE, "color": colours.INK, "va": "center_baseline"}
    axes.annotate(text, at, xytext=(3, 0), textcoords="offset points", **style)


def _draw_bit(axes: Any, lane: Lane, chart: Chart[Curve], row: int) -> None:
    """Draw a bit as a filled band with a line around it; low is at the bottom of its row."""
    times, values = at_pixels(lane, chart.start_ns, chart.end_ns, PIXELS)
    times, values = np.append(times, chart.end_ns), np.append(values, values[-1])
    levels = row + np.where(values, 0.18, 0.85)
    colour = colours.LANES[lane.group]
    axes.fill_between(times, row + 0.85, levels, step="post", color=colour, alpha=0.3, linewidth=0)
    thick = 0.9 if len(times) < CROWDED else 0.3
    axes.plot(times, levels, drawstyle="steps-post", color=colour, linewidth=thick, solid_joinstyle="miter")


def _draw_ramp(axes: Any, lane: Lane, chart: Chart[Curve], row: int) -> None:
    """Draw the ramp as a band of colours."""
    times, values = at_pixels(lane, chart.start_ns, chart.end_ns, PIXELS)
    ends = np.append(times[1:], chart.end_ns)
    for state in range(REST + 1, len(RAMP_STATES)):
        here = values == state
        _paint(axes, times[here], ends[here], row, colours.RAMP[state])


def _draw_band(axes: Any, lane: Lane, chart: Chart[Curve], row: int) -> None:
    """Draw a colour for each value, and what it stands for where there is room."""
    assert isinstance(lane, Band)
    times, values = at_pixels(lane, chart.start_ns, chart.end_ns, PIXELS)
    ends = np.append(times[1:], chart.end_ns)
    letter_ns = LETTER / (WIDTH - LEFT - RIGHT) * max(1, chart.end_ns - chart.start_ns)
    for place, value in enumerate(dict.fromkeys(values.tolist())):
        here = values == value
        _paint(axes, times[here], ends[here], row, colours.BAND[place % len(colours.BAND)])
    for start, end, value in zip(times.tolist(), ends.tolist(), values.tolist(), strict=True):
        text, room = lane.text(value), int((end - start) / letter_ns) - 1
        if min(len(text), LABEL_LETTERS) <= room:
            _write(axes, text if len(text) <= room else f"{text[: room - 1]}…", start, row)


def _paint(axes: Any, starts: Any, ends: Any, row: int, colour: str) -> None:
    """Fill a row with a colour from each start to its end."""
    spans = list(zip(starts, ends - starts, strict=True))
    axes.broken_barh(spans, (row + 0.15, 0.7), facecolors=colour, edgecolors=colour, linewidth=0.4)


_DRAW: Mapping[str, Callable[[Any, Lane, Chart[Curve], int], None]] = {
    "ramp": _draw_ramp,
    "band": _draw_band,
    **dict.fromkeys(GROUPS, _draw_bit),
}
"""How a lane is drawn, by its group."""


def _draw_time(axes: Any, chart: Chart[Curve]) -> None:
    places: Sequence[int] = axis.ticks(chart.start_ns, chart.end_ns, TICKS_MAX)
    unit = axis.unit(chart.start_ns, chart.end_ns)
    step = axis.tick_step(chart.start_ns, chart.end_ns, TICKS_MAX)
    axes.set_xticks(places, labels=[axis.label(place, step, unit) for place in places])
    axes.set_xlabel(f"machine time, {unit}", size=NAME_SIZE, labelpad=2)
