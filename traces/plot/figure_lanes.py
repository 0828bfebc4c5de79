"""Draws the ramp, band and bit lanes of a picture, one row each, and the unchanged values below them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from . import colors
from .chart import Chart
from .envelope import Curve
from .labels import listed, shortened
from .lanes import GROUPS, RAMP_STATES, REST, Band, Lane, at_pixels
from .panel import Panel
from .sizes import LABEL_SIZE, LEFT, LETTER, NAME_LETTERS, NAME_SIZE, PIXELS, RIGHT, WIDTH

CROWDED = PIXELS // 3
"""Minimum number of changes for which a bit is drawn with a thin line."""

LABEL_LETTERS = 8
"""A band's label is drawn only if all of it fits, or at least this number of its letters."""


def rows_of(panel: Panel[Curve]) -> int:
    """Return the number of rows of a panel's lanes, at least one for the time axis."""
    return max(1, len(panel.bands) + len(panel.lanes) + (panel.ramp is not None) + bool(panel.unchanged))


def draw_lanes(axes: Any, panel: Panel[Curve], chart: Chart[Curve]) -> None:
    """Draw ramp, bands and bits, the ramp on top, and the unchanged values below them."""
    ramp = [] if panel.ramp is None else [panel.ramp]
    rows = [*ramp, *panel.bands, *panel.lanes]
    axes.set_ylim(rows_of(panel), 0)
    for row, lane in enumerate(rows):
        _DRAW[lane.group](axes, lane, chart, row)
    names = [shortened(lane.name, NAME_LETTERS) for lane in rows]
    name_colors = [_name_color(lane) for lane in rows]
    if panel.unchanged:
        letters = round((WIDTH - LEFT - RIGHT) / LETTER)
        _write(axes, listed(panel.unchanged, letters), chart.start_ns, len(rows))
        names.append("unchanged")
        name_colors.append(colors.INK)
    axes.set_yticks(np.arange(len(names)) + 0.5, labels=names)
    for label, color in zip(axes.get_yticklabels(), name_colors, strict=True):
        label.set_color(color)
        label.set_fontfamily("monospace")
        label.set_fontsize(NAME_SIZE - 0.5)


def _name_color(lane: Lane) -> str:
    return colors.LANES.get("tag" if isinstance(lane, Band) else lane.group, colors.INK)


def _write(axes: Any, text: str, time_ns: int, row: int) -> None:
    point = (time_ns, row + 0.5)
    style = {"size": LABEL_SIZE, "color": colors.INK, "va": "center_baseline"}
    axes.annotate(text, point, xytext=(3, 0), textcoords="offset points", **style)


def _draw_bit(axes: Any, lane: Lane, chart: Chart[Curve], row: int) -> None:
    """Draw a bit as a filled band with a line around it; low is at the bottom of its row."""
    times, values = at_pixels(lane, chart.start_ns, chart.end_ns, PIXELS)
    times, values = np.append(times, chart.end_ns), np.append(values, values[-1])
    levels = row + np.where(values, 0.18, 0.85)
    color = colors.LANES[lane.group]
    axes.fill_between(times, row + 0.85, levels, step="post", color=color, alpha=0.3, linewidth=0)
    width = 0.9 if len(times) < CROWDED else 0.3
    axes.plot(times, levels, drawstyle="steps-post", color=color, linewidth=width, solid_joinstyle="miter")


def _draw_ramp(axes: Any, lane: Lane, chart: Chart[Curve], row: int) -> None:
    """Draw each state of the ramp in its color, except rest."""
    times, values = at_pixels(lane, chart.start_ns, chart.end_ns, PIXELS)
    end_times = np.append(times[1:], chart.end_ns)
    for state in range(REST + 1, len(RAMP_STATES)):
        is_state = values == state
        _paint(axes, times[is_state], end_times[is_state], row, colors.RAMP[state])


def _draw_band(axes: Any, lane: Lane, chart: Chart[Curve], row: int) -> None:
    """Draw a tag's values in the colors of bands, with the text of a value where it fits."""
    assert isinstance(lane, Band)
    times, values = at_pixels(lane, chart.start_ns, chart.end_ns, PIXELS)
    end_times = np.append(times[1:], chart.end_ns)
    letter_ns = LETTER / (WIDTH - LEFT - RIGHT) * max(1, chart.end_ns - chart.start_ns)
    for color_index, value in enumerate(dict.fromkeys(values.tolist())):
        is_value = values == value
        _paint(axes, times[is_value], end_times[is_value], row, colors.BAND[color_index % len(colors.BAND)])
    for start, end, value in zip(times.tolist(), end_times.tolist(), values.tolist(), strict=True):
        text, letters_fit = lane.text(value), int((end - start) / letter_ns) - 1
        if min(len(text), LABEL_LETTERS) <= letters_fit:
            _write(axes, text if len(text) <= letters_fit else f"{text[: letters_fit - 1]}…", start, row)


def _paint(axes: Any, starts: Any, ends: Any, row: int, color: str) -> None:
    spans = list(zip(starts, ends - starts, strict=True))
    axes.broken_barh(spans, (row + 0.15, 0.7), facecolors=color, edgecolors=color, linewidth=0.4)


_DRAW: Mapping[str, Callable[[Any, Lane, Chart[Curve], int], None]] = {
    "ramp": _draw_ramp,
    "band": _draw_band,
    **dict.fromkeys(GROUPS, _draw_bit),
}
"""Functions that draw lanes, by group."""
