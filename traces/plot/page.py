"""The chart as one HTML page that zooms down to single scans; it needs nothing but a browser.

Every scan is in the page, packed, so that the page shows under the pointer
what was recorded. The page asks nothing of any network.
"""

from __future__ import annotations

import html
import json
from collections.abc import Callable, Sequence
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..newfile import new_file
from ..reader import Trace
from ..signals import ALL, Block, Selection
from . import axis, colours
from .chart import Chart, Panel, groups_of, read_chart
from .lanes import RAMP_STATES, Lane
from .marks import Mark
from .pack import Packer, whole

SCRIPTS = ("data.js", "drawing.js", "readout.js", "pointer.js")
"""The page's script, in the order of its parts."""

SCANS_MAX = 10_000_000
"""Most scans in a page: more and a browser runs short of memory."""


class PackedCurve:
    """Packs the values of all scans."""

    def __init__(self) -> None:
        self._packer = Packer(np.int32)

    def add(self, time_ns: NDArray[np.int64], values: NDArray[np.float64]) -> None:
        """Take the values of a block."""
        self._packer.add(whole(values))

    def curve(self) -> str:
        """Return them packed."""
        return self._packer.text()


class TooLongError(ValueError):
    """There are more scans than a page can hold."""


class Clock:
    """Packs times and numbers of all scans."""

    def __init__(self) -> None:
        self._time, self._scan = Packer(np.float64), Packer(np.int32)
        self._scans = 0

    def add(self, block: Block) -> None:
        """Take a block.

        Raises:
            TooLongError: there are more than SCANS_MAX scans.
        """
        self._scans += len(block)
        if self._scans > SCANS_MAX:
            raise TooLongError(f"a page holds {SCANS_MAX:,} scans at most: choose some, or draw a PNG or SVG")
        self._time.add(block.time_ns)
        self._scan.add(block.scan)

    def packed(self) -> dict[str, str]:
        """Return both columns packed."""
        return {"time": self._time.text(), "scan": self._scan.text()}


def save_page(
    trace: Trace,
    path: Path | str,
    selection: Selection = ALL,
    *,
    slots: Sequence[int] = (),
    title: str | None = None,
    more: Sequence[Mark] = (),
    progress: Callable[[int], None] = lambda scans: None,
) -> None:
    """Write the chart of a trace as an HTML page; the arguments are those of `read_chart`.

    Raises:
        TooLongError: there are more than SCANS_MAX scans.
        EmptySelectionError, NothingToPlotError: as `read_chart`.
    """
    clock = Clock()
    chart = read_chart(
        trace,
        PackedCurve,
        selection,
        slots=slots,
        title=title,
        more=more,
        watch=clock.add,
        progress=progress,
    )
    text = page(chart, clock.packed())
    with new_file(path, encoding="utf-8") as file:
        file.write(text)


def page(chart: Chart[str], clock: dict[str, str]) -> str:
    """Return the page of a chart."""
    data = json.dumps(_data(chart) | clock, separators=(",", ":"), ensure_ascii=False)
    web = files(__package__) / "web"
    return Template(_text(web / "page.html")).substitute(
        title=html.escape(chart.title),
        about=html.escape(axis.about(chart.first, chart.last, chart.start_ns, chart.end_ns)),
        style=_text(web / "page.css"),
        script="\n".join(_text(web / name) for name in SCRIPTS),
        data=data.replace("<", "\\u003c"),  # so that no text in it can end the script or open a comment
    )


def _text(resource: Any) -> str:
    text: str = resource.read_text(encoding="utf-8")
    return text


def _data(chart: Chart[str]) -> dict[str, object]:
    return {
        "start": chart.start_ns,
        "end": chart.end_ns,
        "steps": axis.STEPS_NS,
        "groups": groups_of(chart),
        "ramp": RAMP_STATES,
        "colours": {
            "lanes": colours.LANES,
            "ramp": colours.RAMP,
            "marks": colours.MARKS,
            "curve": colours.CURVE,
            "grid": colours.GRID,
        },
        "panels": [_panel(panel) for panel in chart.panels],
    }


def _panel(panel: Panel[str]) -> dict[str, object]:
    return {
        "slot": panel.slot.number,
        "module": panel.slot.module,
        "curves": [{"name": name, "curve": curve} for name, curve in panel.curves],
        "ramp": panel.ramp and {"rows": panel.ramp.row.tolist(), "values": panel.ramp.value.tolist()},
        "lanes": [_lane(lane) for lane in panel.lanes],
        "steady": [_lane(lane) for lane in panel.steady],
        "marks": [_mark(mark) for mark in panel.marks],
    }


def _lane(lane: Lane) -> dict[str, object]:
    """Return a bit: from each of the rows on it is the other way round than before."""
    return {
        "name": lane.name,
        "group": lane.group,
        "rows": lane.row.tolist(),
        "first": int(lane.value[0]),
    }


def _mark(mark: Mark) -> dict[str, object]:
    return {"time": mark.time_ns, "kind": mark.kind, "label": mark.label, "text": mark.text}
