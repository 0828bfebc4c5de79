"""Names the changes from scan to scan, as the rows of a table.

A row shows one direction of one slot in one scan, in the order of the scan:
the input image, which the logic reads, before the output image, which it writes.
Scans without a change have no row. Scans in which only positions and
counts of 3601s changed are only counted, and one row states their number. Tags
that are numbers, such as the ACC of a timer, are shown with `every` only.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.times import seconds_column

from ..format.layout import SlotInfo, block_layout
from ..format.tagplan import FIELD
from .image_text import Words, module_text, risen_and_fallen
from .number_formats import NumberFormats
from .reader import Scan
from .sections import ScanRows
from .tag_text import TagText

_REPORTS = {"position": "position", "encoder": "encoder count"}
"""Quantities that have a column each, and their names in texts."""

_MODE_CONFIG_HIGH = 0x80
"""Bit 15 of a status word, in its high byte."""


class _Reporting(NamedTuple):
    """The places in the memory block where a module reports position and count."""

    status: int  # place of the high byte of the word with the mode
    spans: Mapping[str, slice]  # by the quantity's name in texts


@dataclass(frozen=True, slots=True)
class Row:
    """One direction of one slot in one scan."""

    scan: int | None  # number of the scan; None for a row of several scans
    now_ns: int | None  # virtual time of the scan; None for a row of several scans
    slot: int | None  # number of the slot; None for the CPU
    direction: str  # "in", "out", "cpu" or "tags"; empty for several scans
    position: int | None  # reported position, steps; None where the image has none
    encoder: int | None  # reported count; None where the image has none
    text: str

    @property
    def cells(self) -> tuple[str, ...]:
        """Its texts under `ROW_TITLES`; empty where it has no value."""
        numbers = ["" if number is None else str(number) for number in (self.scan, self.slot)]
        reports = ["" if number is None else f"{number:,}" for number in (self.position, self.encoder)]
        time = "" if self.now_ns is None else seconds_column(self.now_ns)
        return (numbers[0], time, numbers[1], self.direction, *reports, self.text)


ROW_TITLES = ("scan>", "time s>", "slot>", "", "position>", "encoder>", "what")
"""Titles of the columns of a table of rows; one that ends in ">" is above numbers."""


class ChangeRows:
    """Converts scans to rows.

    Args:
        flag_names: returns the names of the CPU's flags that are set in a scan.
        every: a row for every change, including positions and counts.
        tags: describes tags; None for a trace without any.
        formats: number formats of modules whose configuration selects them.
    """

    def __init__(
        self,
        slots: Sequence[SlotInfo],
        flag_names: Callable[[int], Sequence[str]],
        *,
        every: bool = False,
        tags: TagText | None = None,
        formats: NumberFormats | None = None,
    ) -> None:
        self._formats = NumberFormats() if formats is None else formats
        self._tags = tags
        self._tag_row = b""
        layout = block_layout(slots)
        self._slots = [(slot, layout.places[slot.number]) for slot in slots]
        reporting = (_reporting(slot, slot_place.inputs.start) for slot, slot_place in self._slots)
        self._reporting = [report for report in reporting if report is not None]
        self._flag_names = flag_names
        self._every = every
        self._memory = bytes(layout.size)
        self._flags: int | None = None
        self._folded = 0
        self._folded_what = dict.fromkeys(_REPORTS.values(), False)

    def rows(self, scan: Scan) -> Iterator[Row]:
        """Return the changes since the previous scan; for the first scan, everything that is not 0."""
        tags = "" if self._tags is None else self._tags.changes(self._tag_row, scan.tags)
        if not tags and scan.memory == self._memory and scan.flags == self._flags:
            self._tag_row = scan.tags
            return
        same_flags = scan.flags == self._flags and not tags
        if not self._every and same_flags and self._only_reports_differ(scan.memory):
            self._fold(scan.memory)
        else:
            yield from self.rest()
            yield from self._found(scan)
            if tags:
                yield Row(scan.scan, scan.now_ns, None, "tags", None, None, tags)
        self.skip(scan)

    def rows_of(
        self,
        scans: ScanRows,
        inside: NDArray[np.bool_],
        as_scans: Callable[[ScanRows], Iterator[Scan]],
    ) -> Iterator[Row]:
        """Return the changes in successive scans; like `rows`, but fast if there are few changes.

        Args:
            scans: 1 or more.
            inside: mask of the scans that are shown as rows.
            as_scans: makes scans of an array, `Trace.as_scans`.
        """
        is_changed, is_folded, moved_reports = self._compared(scans)
        kept_places, is_folded = np.flatnonzero(inside & is_changed & ~is_folded), is_folded & inside
        befores = as_scans(scans[np.maximum(kept_places - 1, 0)])
        start = 0
        for row_index, scan_before, scan in zip(
            kept_places.tolist(), befores, as_scans(scans[kept_places]), strict=True
        ):
            self._fold_all(is_folded, moved_reports, slice(start, row_index))
            if row_index:
                self.skip(scan_before)
            yield from self.rows(scan)
            start = row_index
        self._fold_all(is_folded, moved_reports, slice(start, len(scans)))
        self.skip(next(as_scans(scans[-1:])))

    def _compared(
        self, scans: ScanRows
    ) -> tuple[NDArray[np.bool_], NDArray[np.bool_], Mapping[str, NDArray[np.bool_]]]:
        """Compare scans with the previous ones; the first one counts as changed.

        Returns:
            Masks of the changed scans, and of the scans that are only counted; and by name, masks of the
            scans whose position or count differs.
        """
        words = np.ascontiguousarray(scans["images"]).view(np.int16).reshape(len(scans), -1)
        is_different = np.zeros(words.shape, bool)
        is_different[1:] = words[1:] != words[:-1]
        flags = np.ones(len(scans), bool)
        flags[1:] = scans["flags"][1:] != scans["flags"][:-1]
        tags = np.zeros(len(scans), bool) if self._tags is None else self._tags.changed(scans[FIELD])
        is_changed = is_different.any(axis=1) | flags | tags
        report_columns = {name: np.zeros(words.shape[1], bool) for name in self._folded_what}
        configured = np.zeros(len(scans), bool)
        for report in self._reporting:
            configured |= words[:, report.status // 2] < 0  # MODE_CONFIG is bit 15
            for name, span in report.spans.items():
                report_columns[name][span.start // 2 : span.stop // 2] = True
        kept_rows = is_different[:, ~np.logical_or.reduce(list(report_columns.values()))].any(axis=1)
        is_folded = is_changed & ~(kept_rows | flags | configured | tags)
        if self._every:
            is_folded[:] = False
        return (
            is_changed,
            is_folded,
            {name: np.any(is_different[:, columns], axis=1) for name, columns in report_columns.items()},
        )

    def _fold_all(
        self, folded: NDArray[np.bool_], moved: Mapping[str, NDArray[np.bool_]], span: slice
    ) -> None:
        """Count the scans of a stretch that have no row."""
        count = int(np.count_nonzero(folded[span]))
        if count:
            self._folded += count
            for name, is_different in moved.items():
                self._folded_what[name] |= bool((folded[span] & is_different[span]).any())

    def skip(self, scan: Scan) -> None:
        """Remember the values of a scan that is not shown."""
        self._memory, self._flags, self._tag_row = scan.memory, scan.flags, scan.tags

    def rest(self) -> Iterator[Row]:
        """Yield a row with the number of scans folded since the last row, if any, and reset it."""
        if self._folded:
            scans = "scan" if self._folded == 1 else "scans"
            names = " and ".join(name for name, is_moved in self._folded_what.items() if is_moved)
            text = f"... {self._folded:,} {scans} in which only the {names} changed"
            yield Row(None, None, None, "", None, None, text)
            self._folded = 0
            self._folded_what = dict.fromkeys(_REPORTS.values(), False)

    def _only_reports_differ(self, memory: bytes) -> bool:
        """Return whether only words that report a position or count have changed."""
        start = 0
        for report in self._reporting:
            if memory[report.status] & _MODE_CONFIG_HIGH:
                return False  # in configuration mode these words mirror the configuration
            for span in report.spans.values():
                if memory[start : span.start] != self._memory[start : span.start]:
                    return False
                start = span.stop
        return memory[start:] == self._memory[start:]

    def _fold(self, memory: bytes) -> None:
        self._folded += 1
        for report in self._reporting:
            for name, span in report.spans.items():
                if memory[span] != self._memory[span]:
                    self._folded_what[name] = True

    def _found(self, scan: Scan) -> Iterator[Row]:
        if scan.flags != self._flags:
            old_names: Sequence[str] = () if self._flags is None else self._flag_names(self._flags)
            text = risen_and_fallen(old_names, self._flag_names(scan.flags))
            yield Row(scan.scan, scan.now_ns, None, "cpu", None, None, text)
        for slot, slot_places in self._slots:
            for direction, image in (("in", slot_places.inputs), ("out", slot_places.outputs)):
                if scan.memory[image] != self._memory[image]:
                    yield self._row(scan, slot, direction, image)

    def _row(self, scan: Scan, slot: SlotInfo, direction: str, image: slice) -> Row:
        memories = self._memory, scan.memory
        words_before, words_after = (memoryview(memory)[image].cast("h").tolist() for memory in memories)
        position, encoder = self._reported(scan.scan, slot, direction, words_after)
        text = module_text(
            slot, direction, words_before, words_after, self._formats.reader(slot.number, scan.scan)
        )
        return Row(scan.scan, scan.now_ns, slot.number, direction, position, encoder, text)

    def _reported(self, scan: int, slot: SlotInfo, direction: str, words: Words) -> list[int | None]:
        """Return the position and count in an image; None where it has none."""
        if direction != "in" or slot.words.configures("in", words):
            return [None] * len(_REPORTS)
        quantities = map(slot.words.quantity, _REPORTS)
        value = self._formats.reader(slot.number, scan)
        return [None if quantity is None else value(quantity, words) for quantity in quantities]


def _reporting(slot: SlotInfo, start: int) -> _Reporting | None:
    """Return the places of a module's position and count; None if the module reports neither.

    Args:
        start: first byte of its input image in the memory block.
    """
    quantities = {role: slot.words.quantity(name) for name, role in _REPORTS.items()}
    spans = {
        role: slice(start + 2 * quantity.word, start + 2 * (quantity.word + quantity.words))
        for role, quantity in quantities.items()
        if quantity is not None
    }
    modes = slot.words.modes
    return None if modes is None or not spans else _Reporting(start + 2 * modes.input + 1, spans)
