"""Writes the chart as one HTML page that zooms to single scans.

The page contains every scan, packed, and shows the recorded values at the pointer. It needs only a
browser and makes no network requests.
"""

from __future__ import annotations

import html
import json
from collections.abc import Callable, Sequence
from importlib.resources import files
from pathlib import Path
from string import Template
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..files.guard import PAGE
from ..files.newfile import new_file
from ..read.reader import Trace
from ..signals import ALL, Block, Selection
from . import colors, time_axis
from .chart import Chart, groups_of, read_chart
from .lanes import RAMP_STATES, Band, Lane
from .marks import Mark
from .pack import Packer, whole
from .panel import Panel

SCRIPTS = ("data.js", "drawing.js", "lanes.js", "readout.js", "pointer.js")
"""The parts of the page's script, in order."""

SCANS_MAX = 10_000_000
"""Maximum number of scans in a page; with more, a browser runs out of memory."""


class PackedValues(NamedTuple):
    """The values of all scans, packed."""

    kind: str  # type of a value in the page: "Int32", "Float32", "Float64", "BigInt64" or "BigUint64"
    differences: bool  # whether they are packed as differences from scan to scan
    curve: str  # the packed values, see `Packer`


class PackedCurve:
    """Packs the values of all scans, rounded to integers."""

    def __init__(self) -> None:
        self._packer = Packer(np.int32)

    def add(self, time_ns: NDArray[np.int64], values: NDArray[np.float64]) -> None:
        """Add the values of a block."""
        self._packer.add(whole(values))

    def curve(self) -> PackedValues:
        """Return the packed values."""
        return PackedValues("Int32", True, self._packer.text())


class PackedNumbers:
    """Packs the exact values of all scans."""

    def __init__(self) -> None:
        self._kind, self._differences = "Float64", True
        self._packer: Packer | None = None

    def add(self, time_ns: NDArray[np.int64], values: NDArray[Any]) -> None:
        """Add the values of a block, which must have the same type in all blocks."""
        if self._packer is None:
            self._kind, self._differences = _packed_as(values.dtype)
            self._packer = Packer(self._kind.lower().removeprefix("big"), differences=self._differences)
        self._packer.add(values)

    def curve(self) -> PackedValues:
        """Return the packed values; at least one block must have been added."""
        assert self._packer is not None
        return PackedValues(self._kind, self._differences, self._packer.text())


def _packed_as(dtype: np.dtype[Any]) -> tuple[str, bool]:
    """Return the type of values in the page, and whether the sum of their differences is exact."""
    if dtype.kind not in "iu":
        return ("Float32" if dtype == np.float32 else "Float64"), False
    if dtype.itemsize == 8:
        return ("BigInt64" if dtype.kind == "i" else "BigUint64"), True
    return "Float64", True


class TooLongError(ValueError):
    """The trace has more than SCANS_MAX scans."""


class ScanTimes:
    """Packs times and numbers of all scans."""

    def __init__(self) -> None:
        self._time, self._scan = Packer(np.float64), Packer(np.int32)
        self._scans = 0

    def add(self, block: Block) -> None:
        """Add a block; raise a TooLongError if there are more than SCANS_MAX scans."""
        self._scans += len(block)
        if self._scans > SCANS_MAX:
            problem = f"a page can have {SCANS_MAX:,} scans at most: select fewer, or draw a PNG or SVG"
            raise TooLongError(problem)
        self._time.add(block.time_ns)
        self._scan.add(block.scan)

    def packed(self) -> dict[str, str]:
        """Return both packed columns."""
        return {"time": self._time.text(), "scan": self._scan.text()}


def save_page(
    trace: Trace,
    path: Path | str,
    selection: Selection = ALL,
    *,
    slots: Sequence[int] = (),
    tags: Sequence[str] = (),
    title: str | None = None,
    more_marks: Sequence[Mark] = (),
    progress: Callable[[int], None] = lambda scans: None,
) -> Chart[PackedValues]:
    """Write the chart of a trace as an HTML page, and return the chart. For the arguments, see `read_chart`.

    Raises:
        TooLongError: there are more than SCANS_MAX scans.
        EmptySelectionError, NothingToPlotError, ValueError: see `read_chart`.
    """
    scan_times = ScanTimes()
    chart = read_chart(
        trace,
        PackedCurve,
        selection,
        slots=slots,
        tags=tags,
        exact=PackedNumbers,
        title=title,
        more_marks=more_marks,
        on_block=scan_times.add,
        progress=progress,
    )
    text = page(chart, scan_times.packed())
    with new_file(path, PAGE) as file:
        file.write(text)
    return chart


def page(chart: Chart[PackedValues], scan_times: dict[str, str]) -> str:
    """Return the page of a chart; `scan_times` are the columns of `ScanTimes`."""
    data = json.dumps(_data(chart) | scan_times, separators=(",", ":"), ensure_ascii=False)
    web = files(__package__) / "web"
    return Template(_text(web / "page.html")).substitute(
        title=html.escape(chart.title),
        about=html.escape(time_axis.about(chart.first, chart.last, chart.start_ns, chart.end_ns)),
        style=_text(web / "page.css"),
        script="\n".join(_text(web / name) for name in SCRIPTS),
        data=data.replace("<", "\\u003c"),  # a "<" in a text could end the script or begin a comment
    )


def _text(resource: Any) -> str:
    text: str = resource.read_text(encoding="utf-8")
    return text


def _data(chart: Chart[PackedValues]) -> dict[str, object]:
    """Return a chart as data for the page's script, without times and scan numbers."""
    return {
        "start": chart.start_ns,
        "end": chart.end_ns,
        "steps": time_axis.STEPS_NS,
        "groups": groups_of(chart),
        "ramp": RAMP_STATES,
        "colors": {
            "lanes": colors.LANES,
            "ramp": colors.RAMP,
            "band": colors.BAND,
            "bandDark": colors.BAND_DARK,
            "marks": colors.MARKS,
            "curve": colors.CURVE,
            "grid": colors.GRID,
        },
        "panels": [_panel(panel) for panel in chart.panels],
    }


def _panel(panel: Panel[PackedValues]) -> dict[str, object]:
    """Return a panel as data for the page."""
    return {
        "name": panel.name,
        "about": panel.about,
        "tags": panel.slot is None,
        "curves": [
            {"name": name, "fractional": name in panel.fractional, **packed._asdict()}
            for name, packed in panel.curves
        ],
        "ramp": panel.ramp and {"rows": panel.ramp.row.tolist(), "values": panel.ramp.value.tolist()},
        "lanes": [_lane(lane) for lane in panel.lanes],
        "steady": [_lane(lane) for lane in panel.steady],
        "marks": [_mark(mark) for mark in panel.marks],
        "bands": [_band(band) for band in panel.bands],
        "unchanged": panel.unchanged,
    }


def _lane(lane: Lane) -> dict[str, object]:
    """Return a bit as data for the page, with the rows in which it changes and its first value."""
    return {
        "name": lane.name,
        "group": lane.group,
        "rows": lane.row.tolist(),
        "first": int(lane.value[0]),
    }


def _band(band: Band) -> dict[str, object]:
    """Return a band as data for the page: the rows in which it changes, and its text indexes."""
    text_indexes: dict[int, int] = {}  # by code
    values = [text_indexes.setdefault(code, len(text_indexes)) for code in band.value.tolist()]
    return {
        "name": band.name,
        "rows": band.row.tolist(),
        "values": values,
        "texts": [band.text(code) for code in text_indexes],
    }


def _mark(mark: Mark) -> dict[str, object]:
    return {"time": mark.time_ns, "kind": mark.kind, "label": mark.label, "text": mark.text}
