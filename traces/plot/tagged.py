"""The program's recorded tags on a chart: curves of numbers, bands of steps and texts, and BOOL lanes.

If all tags fit on the chart, all are shown. Otherwise, only tags that change are shown, as many as fit. A
user can choose other tags by name.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..format.flags import FLAGS
from ..read.reader import Trace
from ..signals import Block, Catalog, Selection, Signal, SignalKind, blocks
from ..signals.names import RECORDED, first_titles
from ..signals.sequences import FIELD as SEQUENCES
from .changes import ChangeFinder, Changes
from .curves import CurveMaker
from .lanes import Band, Lane
from .marks import Mark
from .panel import Panel

CURVES_MAX, ROWS_MAX = 8, 24
"""Maximum number of curves, and of bands and lanes, unless the user chooses the tags."""

FROM_OUTSIDE = f"cpu.flags.{next(bit for bit, name in FLAGS.items() if name == 'TAGS_FROM_OUTSIDE')}"
"""The signal of scans with forced tags, or with tags set since the previous scan."""

CHOSEN_MAX = 200
"""Maximum number of tags on a chart."""

C = TypeVar("C")
L = TypeVar("L", bound=Lane)


@dataclass(frozen=True, slots=True)
class Choice:
    """The tags to draw on a chart."""

    signals: Sequence[Signal]
    left_out: int  # number of recorded values that are not drawn

    def __str__(self) -> str:
        """Return the numbers of sequences and tags as text for the panel's heading."""
        sequences = sum(signal.name.startswith(f"{SEQUENCES}.") for signal in self.signals)
        tags = len(self.signals) - sequences
        texts = [f"{sequences} sequence{'s' if sequences > 1 else ''}"] if sequences else []
        if self.left_out:
            texts.append(f"{tags} of {tags + self.left_out:,} tags")
        elif tags:
            texts.append(f"{tags} tag{'s' if tags > 1 else ''}")
        return ", ".join(texts)


def choose(trace: Trace, catalog: Catalog, selection: Selection, patterns: Sequence[str]) -> Choice:
    """Return the tags to draw.

    Args:
        selection: scans in which a tag must change to be drawn, if there are many tags.
        patterns: names as in a query, with wildcards; empty = as many tags as fit on the chart.

    Raises:
        UnknownSignalError: a pattern matches nothing.
        ValueError: a pattern matches a signal that is not a tag, or the patterns match more than CHOSEN_MAX
            tags.
    """
    tag_signals = catalog.tags
    if patterns:
        return _matching(catalog, tag_signals, patterns)
    signals = _fitting(tag_signals)
    if len(signals) < len(tag_signals):
        signals = _fitting(_changing(trace, tag_signals, selection))
    return Choice(signals, len(tag_signals) - len(signals))


def _matching(catalog: Catalog, recorded: Sequence[Signal], patterns: Sequence[str]) -> Choice:
    """Return the recorded tags that match patterns; raise ValueError for other signals or too many tags."""
    signals: dict[str, Signal] = {}
    for pattern in patterns:
        matches = catalog.tags_named(pattern) or [catalog[pattern]]
        if not matches[0].name.startswith(RECORDED):
            tags = ", ".join(first_titles([signal.title for signal in recorded], 6))
            raise ValueError(f"{matches[0].name} is not a recorded tag; recorded tags: {tags or 'none'}")
        signals |= {signal.name: signal for signal in matches}
    if len(signals) > CHOSEN_MAX:
        raise ValueError(f"{', '.join(patterns)}: {len(signals):,} tags; a chart shows {CHOSEN_MAX} at most")
    return Choice(list(signals.values()), sum(signal.name not in signals for signal in recorded))


def _fitting(signals: Sequence[Signal]) -> list[Signal]:
    """Return, in order, the first CURVES_MAX signals with curves and the first ROWS_MAX other signals."""
    counts: Counter[bool] = Counter()
    fitting = []
    for signal in signals:
        is_curve = signal.kind is SignalKind.NUMBER
        counts[is_curve] += 1
        if counts[is_curve] <= (CURVES_MAX if is_curve else ROWS_MAX):
            fitting.append(signal)
    return fitting


def _changing(trace: Trace, signals: Sequence[Signal], selection: Selection) -> list[Signal]:
    """Return the signals that have more than one value, in the same order."""
    checks = [SteadyCheck(signal) for signal in signals]
    for block in blocks(trace, selection):
        for check in checks:
            if check.is_steady:
                check.add(check.signal.read(block))
    return [check.signal for check in checks if not check.is_steady]


class SteadyCheck:
    """Checks whether a signal keeps its first value; NaN is equal to NaN."""

    def __init__(self, signal: Signal) -> None:
        self.signal = signal
        self.is_steady = True  # whether all added values are equal
        self.first: Any = None  # the first value; None before the first block

    def add(self, values: NDArray[Any]) -> None:
        """Add the values of a block."""
        if self.first is None:
            self.first = values[0]
        is_equal = values == self.first
        if values.dtype.kind == "f":
            is_equal |= np.isnan(values) & np.isnan(self.first)
        self.is_steady = self.is_steady and bool(is_equal.all())


class TagReader(Generic[C]):
    """Collects the contents of the tags' panel, block by block.

    Args:
        outside: the signal `FROM_OUTSIDE`; it gets a lane if it is ever true.
        maker: returns a new maker of curves for values of the tags' own types.
    """

    def __init__(self, choice: Choice, outside: Signal, maker: Callable[[], CurveMaker[C]]) -> None:
        self._choice = choice
        self._outside = ChangeFinder(outside.read)
        number_signals = [signal for signal in choice.signals if signal.kind is SignalKind.NUMBER]
        other_signals = [signal for signal in choice.signals if signal.kind is not SignalKind.NUMBER]
        self._curves = [(SteadyCheck(signal), maker()) for signal in number_signals]
        self._finders = [(signal, ChangeFinder(signal.read)) for signal in other_signals]

    def add(self, block: Block) -> None:
        """Add a block."""
        for check, curve in self._curves:
            values = check.signal.read(block)
            curve.add(block.time_ns, values)
            if check.is_steady:
                check.add(values)
        self._outside.add(block)
        for _, finder in self._finders:
            finder.add(block)

    def panel(self, tag_marks: Sequence[Mark]) -> Panel[C]:
        """Return the panel of the tags, with their marks; tags that do not change are listed as text."""
        changing_curves = [(check.signal, curve) for check, curve in self._curves if not check.is_steady]
        rows = [_lane(signal, finder.changes()) for signal, finder in self._finders]
        bands, steady_bands = _split_by_change(row for row in rows if isinstance(row, Band))
        lanes, steady_lanes = _split_by_change(row for row in rows if not isinstance(row, Band))
        outside = _bit("from outside", self._outside.changes())
        return Panel(
            slot=None,
            curves=[(_title(signal), curve.curve()) for signal, curve in changing_curves],
            ramp=None,
            lanes=[outside, *lanes] if outside.value.any() else lanes,
            steady=steady_lanes,
            marks=tag_marks,
            about=str(self._choice),
            bands=bands,
            unchanged=self._unchanged(steady_bands, steady_lanes),
            fractional=[_title(signal) for signal, _ in changing_curves if not signal.bits],
        )

    def _unchanged(self, bands: Iterable[Band], lanes: Iterable[Lane]) -> list[tuple[str, str]]:
        """Return the tags whose value never changes, with the value as text."""
        steady_checks = (check for check, _ in self._curves if check.is_steady)
        return [
            *((band.name, band.text(int(band.value[0]))) for band in bands),
            *((lane.name, "on" if lane.value[0] else "off") for lane in lanes),
            *((_title(check.signal), _number_text(check)) for check in steady_checks),
        ]


def _split_by_change(rows: Iterable[L]) -> tuple[list[L], list[L]]:
    """Return the lanes that change, and the lanes that do not."""
    changing_rows: list[L] = []
    steady_rows: list[L] = []
    for row in rows:
        (steady_rows if row.steady else changing_rows).append(row)
    return changing_rows, steady_rows


def _number_text(check: SteadyCheck) -> str:
    """Return the value of an unchanged number as text; integers keep all digits."""
    return str(check.first) if check.signal.bits else f"{check.first:.9g}"


def _lane(signal: Signal, changes: Changes) -> Lane:
    """Return the lane of a BOOL, or the band of a tag whose values have names or are texts."""
    if signal.kind is SignalKind.CODE:
        codes = changes.values.astype(np.int32)
        return Band(_title(signal), "band", changes.row, changes.time_ns, codes, signal.names)
    return _bit(_title(signal), changes)


def _bit(name: str, changes: Changes) -> Lane:
    return Lane(name, "tag", changes.row, changes.time_ns, changes.values.astype(np.int8))


def _title(signal: Signal) -> str:
    """Return a tag's full name; if it has none, return the signal's name in the trace without a prefix."""
    return signal.title or signal.name.partition(".")[2]
