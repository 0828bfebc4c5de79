"""Draws the chart as a PNG or SVG picture.

inches     left                                                     right
top        title
per slot   marks       |  v CMD-03      ^ capture on                 |
           position    |  ~~~~~~~~~                                  |
           speed       |  ~~~~~~~~~                                  |
           ramp, bits  |  one row each, the name at the left         |
program    marks, numbers, steps and texts as bands, BOOLs
bottom     time axis
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..extras import need
from ..files.guard import PNG, SVG
from ..files.newfile import new_file
from . import colors, time_axis
from .chart import Chart, groups_of
from .envelope import Curve
from .figure_lanes import draw_lanes, rows_of
from .labels import Label, placed, shortened
from .lanes import RAMP_STATES
from .panel import Panel
from .sizes import (
    AXIS,
    DPI,
    EDGE,
    GAP,
    HEAD,
    LABEL_SIZE,
    LANE,
    LEFT,
    LETTER,
    MARKS,
    NAME_LETTERS,
    NAME_SIZE,
    NUMBER,
    POSITION,
    RIGHT,
    SPEED,
    TOP,
    WIDTH,
)

TICKS_MAX = 12
LABEL_ROWS = 3

INSTANTS_MAX = 60
"""Maximum number of lines through a curve for one kind of mark; with more marks, no lines are drawn."""

SHORT_MAX = 10**7
"""Smallest value that is written with an exponent next to a tag's curve."""

FORMATS = (".png", ".svg")

_STYLE = {
    "font.size": 9,
    "svg.hashsalt": "scanrack",  # equal charts make equal files
    "svg.fonttype": "none",
    "axes.unicode_minus": False,
}


def save_figure(chart: Chart[Curve], path: Path | str) -> None:
    """Draw a chart to a PNG or SVG file, depending on the path's suffix.

    Raises:
        MissingExtraError: matplotlib is not installed.
        ValueError: the path has another suffix.
    """
    path = Path(path)
    if path.suffix.lower() not in FORMATS:
        raise ValueError(f"{path}: the name must end in .png or .svg")
    matplotlib = need("matplotlib", "plot")
    figures = need("matplotlib.figure", "plot")
    with matplotlib.rc_context(_STYLE):
        figure = draw(chart, figures.Figure)
        kind = path.suffix.lower()[1:]
        # without the metadata that depend on the time or on the version of matplotlib
        metadata = {"Software": None} if kind == "png" else {"Date": None, "Creator": None}
        with new_file(path, PNG if kind == "png" else SVG, "wb") as file:
            figure.savefig(file, format=kind, dpi=DPI, metadata=metadata)


def draw(chart: Chart[Curve], figure_class: Any) -> Any:
    """Return the figure of a chart."""
    height = TOP + sum(_panel_height(panel) for panel in chart.panels)
    figure = figure_class(figsize=(WIDTH, height), facecolor="white")
    _title(figure, chart, height)
    panel_top = height - TOP
    for panel in chart.panels:
        panel_top = _draw_panel(_Canvas(figure, chart, height), panel, panel_top)
    return figure


def _panel_height(panel: Panel[Curve]) -> float:
    curves = sum(_curve_height(panel, index) + GAP for index in range(len(panel.curves)))
    return _head_height(panel) + curves + LANE * rows_of(panel) + AXIS


def _head_height(panel: Panel[Curve]) -> float:
    return MARKS if panel.marks else HEAD


def _curve_height(panel: Panel[Curve], curve_index: int) -> float:
    if panel.slot is None:
        return NUMBER
    return POSITION if curve_index == 0 and panel.ramp is not None else SPEED


class _Canvas:
    """Adds axes, with the chart's time axis, to a figure whose height is in inches."""

    def __init__(self, figure: Any, chart: Chart[Curve], height: float) -> None:
        self.figure, self.chart, self._height = figure, chart, height

    def axes(self, top: float, height: float) -> Any:
        """Return new axes with their upper edge at `top` inches above the lower edge of the figure."""
        box = (
            LEFT / WIDTH,
            (top - height) / self._height,
            (WIDTH - LEFT - RIGHT) / WIDTH,
            height / self._height,
        )
        axes = self.figure.add_axes(box)
        margin_ns = max(1, self.chart.end_ns - self.chart.start_ns) * EDGE
        axes.set_xlim(self.chart.start_ns - margin_ns, self.chart.end_ns + margin_ns)
        axes.set_xticks(time_axis.ticks(self.chart.start_ns, self.chart.end_ns, TICKS_MAX), labels=[])
        axes.grid(axis="x", color=colors.GRID, linewidth=0.6)
        axes.set_axisbelow(True)
        axes.tick_params(length=0, labelsize=NAME_SIZE, colors=colors.INK)
        for spine in axes.spines.values():
            spine.set_color(colors.GRID)
        return axes


def _title(figure: Any, chart: Chart[Curve], height: float) -> None:
    """Write the title, the scans and times, and the colors of bits and of the ramp."""
    # a place is a fraction of the figure; the numbers are inches, and a letter is about 0.07 wide
    figure.text(LEFT / WIDTH, 1 - 0.24 / height, chart.title, size=12, weight="bold", va="center")
    about = time_axis.about(chart.first, chart.last, chart.start_ns, chart.end_ns)
    figure.text(1 - RIGHT / WIDTH, 1 - 0.24 / height, about, size=NAME_SIZE, va="center", ha="right")
    left = LEFT / WIDTH
    for group in groups_of(chart):
        color = colors.LANES[group]
        text = f"■ {_GROUP_TITLES[group]}"
        figure.text(left, 1 - 0.48 / height, text, size=NAME_SIZE, color=color, va="center")
        left += (0.2 + 0.07 * len(text)) / WIDTH
    if not any(panel.ramp for panel in chart.panels):
        return
    for state, color in zip(RAMP_STATES[1:], colors.RAMP[1:], strict=True):
        figure.text(left, 1 - 0.48 / height, "■", size=NAME_SIZE + 2, color=color, va="center")
        figure.text(left + 0.16 / WIDTH, 1 - 0.48 / height, state, size=NAME_SIZE, va="center")
        left += (0.36 + 0.07 * len(state)) / WIDTH


_GROUP_TITLES = {
    "command": "command bits",
    "status": "status bits",
    "error": "error bits",
    "input": "inputs",
    "output": "outputs",
    "tag": "tags",
}


def _draw_panel(canvas: _Canvas, panel: Panel[Curve], top: float) -> float:
    """Draw a panel; return the top of the next panel, inches above the lower edge of the figure."""
    _draw_marks(canvas, panel, top)
    top -= _head_height(panel)
    for curve_index, (name, curve) in enumerate(panel.curves):
        axes = canvas.axes(top, _curve_height(panel, curve_index))
        if panel.slot is None:
            _draw_number(axes, curve, name, fractional=name in panel.fractional)
        else:
            _draw_curve(axes, curve, name)
        if curve_index == 1 and panel.ramp is not None:  # the speed
            axes.axhline(0, color=colors.INK, linewidth=0.4)
        _draw_instants(axes, panel)
        top -= _curve_height(panel, curve_index) + GAP
    height = LANE * rows_of(panel)
    lanes = canvas.axes(top, height)
    draw_lanes(lanes, panel, canvas.chart)
    _draw_time(lanes, canvas.chart)
    return top - height - AXIS


def _draw_curve(axes: Any, curve: Curve, name: str) -> None:
    """Draw a curve of a module next to an axis of integers."""
    axes.plot(*curve.line(), color=colors.CURVE, linewidth=1.2, solid_joinstyle="round")
    axes.set_ylabel(name, size=NAME_SIZE)
    axes.yaxis.set_major_formatter("{x:,.0f}")
    axes.locator_params(axis="y", nbins=5, integer=True)
    axes.grid(axis="y", color=colors.GRID, linewidth=0.6)
    axes.margins(y=0.08)
    bottom_value, top_value = axes.get_ylim()
    if top_value - bottom_value < 1:  # the value never changes, but an axis of whole numbers needs a range
        axes.set_ylim(round(bottom_value) - 1, round(top_value) + 1)


def _draw_number(axes: Any, curve: Curve, name: str, *, fractional: bool) -> None:
    """Draw a tag as steps, because a value is in force until the next scan."""
    axes.plot(*curve.line(), color=colors.CURVE, linewidth=1.2, drawstyle="steps-post")
    axes.yaxis.set_major_formatter(lambda value, _tick: _number_text(value))
    axes.locator_params(axis="y", nbins=3, integer=not fractional)
    axes.grid(axis="y", color=colors.GRID, linewidth=0.6)
    axes.margins(y=0.1)
    style = {"size": NAME_SIZE - 0.5, "color": colors.LANES["tag"], "family": "monospace", "va": "center"}
    left_of_values = -0.06
    label = shortened(name, NAME_LETTERS - 8)
    axes.text(left_of_values, 0.5, label, transform=axes.transAxes, ha="right", **style)


def _number_text(value: float) -> str:
    """Return a value as text for an axis, in about nine characters."""
    return f"{value:,.7g}" if abs(value) < SHORT_MAX else f"{value:.4g}"


def _draw_instants(axes: Any, panel: Panel[Curve]) -> None:
    """Draw a thin line through a curve at each rule and stimulus, unless the lines would hide the curve."""
    for kind in ("stimulus", "rule", "broken"):
        times = [mark.time_ns for mark in panel.marks if mark.kind == kind]
        if len(times) > INSTANTS_MAX:
            continue
        upright = axes.get_xaxis_transform()
        axes.vlines(times, 0, 1, transform=upright, color=colors.MARKS[kind], linewidth=0.5, alpha=0.45)


def _draw_marks(canvas: _Canvas, panel: Panel[Curve], top: float) -> None:
    """Draw the marks, with a tick for each event and a label if it fits."""
    axes = canvas.axes(top, _head_height(panel))
    axes.axis("off")
    axes.set_ylim(0, 1)
    for kind, color in colors.MARKS.items():
        times = [mark.time_ns for mark in panel.marks if mark.kind == kind]
        axes.vlines(times, 0, 0.12, color=color, linewidth=1.0)
    letter_width = LETTER / (WIDTH - LEFT - RIGHT)  # as a fraction of the axis
    labels = placed(panel.marks, canvas.chart.start_ns, canvas.chart.end_ns, letter_width, LABEL_ROWS)
    for label in labels:
        _draw_label(axes, label, 0.16 + 0.29 * label.row)
    name = f"{panel.name}  {panel.about}"
    axes.text(-0.145, 0.62 if panel.marks else 0.5, name, transform=axes.transAxes, size=9.5, weight="bold")
    unlabeled = len(panel.marks) - len(labels)
    if unlabeled:
        noun = "more mark" if unlabeled == 1 else "more marks"
        axes.text(-0.145, 0.25, f"{unlabeled:,} {noun}", transform=axes.transAxes, size=LABEL_SIZE)


def _draw_label(axes: Any, label: Label, height: float) -> None:
    """Draw a mark's label at a height, 0 to 1, next to a line at the mark's time."""
    mark = label.mark
    color = colors.MARKS[mark.kind]
    axes.vlines(mark.time_ns, 0, height + 0.2, color=color, linewidth=0.5, zorder=1)
    axes.annotate(
        mark.label,
        (mark.time_ns, height),
        xytext=(-2 if label.before else 2, 0),
        textcoords="offset points",
        ha="right" if label.before else "left",
        size=LABEL_SIZE,
        color=color,
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.3},
        zorder=2,
    )


def _draw_time(axes: Any, chart: Chart[Curve]) -> None:
    """Write times at the ticks of a panel's lowest axis, and its unit."""
    ticks = time_axis.ticks(chart.start_ns, chart.end_ns, TICKS_MAX)
    unit = time_axis.unit(chart.start_ns, chart.end_ns)
    step = time_axis.tick_step(chart.start_ns, chart.end_ns, TICKS_MAX)
    axes.set_xticks(ticks, labels=[time_axis.label(tick, step, unit) for tick in ticks])
    axes.set_xlabel(f"machine time, {unit}", size=NAME_SIZE, labelpad=2)
