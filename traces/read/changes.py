"""Lists the changes from scan to scan, as the rows of a table.

A row shows one image of one slot in one scan. Rows are in the order of the scan: the input image, which the
logic reads, before the output image, which it writes. Scans without a change have no row. Scans in which only
positions and counts changed are folded into one row that shows their number. Changes in numeric tags, such as
the ACC of a timer, are shown only with `every`.
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
from .image_text import ValueReader, Words, module_text, risen_and_fallen
from .number_formats import NumberFormats
from .reader import Scan
from .sections import ScanRows
from .tag_text import TagText

_REPORTS = {"position": "position", "encoder": "encoder count"}
"""Quantities that have their own columns, and their names in texts."""

_MODE_CONFIG_HIGH = 0x80
"""Bit 15 of a status word, in its high byte."""

Mask = NDArray[np.bool_]
"""A mask of scans."""


class _Reporting(NamedTuple):
    """The bytes of the memory block in which a module reports its mode, position and count."""

    status: int  # offset of the high byte of the word with the mode
    spans: Mapping[str, slice]  # position and count, by their names in texts


class _ScanChanges(NamedTuple):
    """Scans compared with the previous ones."""

    changed: Mask
    folded: Mask  # only positions or counts changed
    moved: Mapping[str, Mask]  # scans whose position or count changed, by its name in texts


@dataclass(frozen=True, slots=True)
class Row:
    """A row of the table: one image of one slot in one scan."""

    scan: int | None  # number of the scan; None for a row of several scans
    now_ns: int | None  # virtual time of the scan; None for a row of several scans
    slot: int | None  # number of the slot; None for the CPU
    direction: str  # "in", "out", "cpu" or "tags"; empty for several scans
    position: int | None  # reported position, steps; None where the image has none
    encoder: int | None  # reported count; None where the image has none
    text: str

    @property
    def cells(self) -> tuple[str, ...]:
        """The row's texts under `ROW_TITLES`; empty if the row has no value."""
        scan, slot = ("" if number is None else str(number) for number in (self.scan, self.slot))
        reports = ["" if number is None else f"{number:,}" for number in (self.position, self.encoder)]
        time = "" if self.now_ns is None else seconds_column(self.now_ns)
        return (scan, time, slot, self.direction, *reports, self.text)


ROW_TITLES = ("scan>", "time s>", "slot>", "", "position>", "encoder>", "what")
"""Titles of the columns of a table of rows; a title that ends in ">" is above numbers."""


class ChangeRows:
    """Converts scans to rows.

    Args:
        flag_names: returns the names of the controller's flags that are set in a scan.
        every: whether each change has a row, including changes in positions and counts.
        tags: describes changes in tags; None for a trace without tags.
        formats: formats of the modules' numbers; None = thousands, unless the module has another fixed
            format.
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
        # each slot with the places of its images
        self._slots = [(slot, layout.places[slot.number]) for slot in slots]
        reporting = (_reporting(slot, slot_place.inputs.start) for slot, slot_place in self._slots)
        self._reporting = [report for report in reporting if report is not None]
        self._flag_names = flag_names
        self._every = every
        self._memory = bytes(layout.size)
        self._flags: int | None = None  # of the previous scan, like `_memory` and `_tag_row`
        self._folded = 0  # number of folded scans since the last row
        self._folded_moved = dict.fromkeys(_REPORTS.values(), False)  # whether each changed in these scans

    def rows(self, scan: Scan) -> Iterator[Row]:
        """Yield the changes since the previous scan; for the first scan, yield everything that is not 0."""
        tags = "" if self._tags is None else self._tags.changes(self._tag_row, scan.tags)
        if not tags and scan.memory == self._memory and scan.flags == self._flags:
            self._tag_row = scan.tags
            return
        same_flags = scan.flags == self._flags and not tags
        if not self._every and same_flags and self._only_reports_differ(scan.memory):
            self._fold(scan.memory)
        else:
            yield from self.rest()
            yield from self._changes(scan)
            if tags:
                yield Row(scan.scan, scan.now_ns, None, "tags", position=None, encoder=None, text=tags)
        self.skip(scan)

    def rows_of(
        self,
        scans: ScanRows,
        inside: Mask,
        as_scans: Callable[[ScanRows], Iterator[Scan]],
    ) -> Iterator[Row]:
        """Yield the changes in successive scans, like `rows` but faster if there are few changes.

        Args:
            scans: one or more scans.
            inside: the scans to show as rows.
            as_scans: converts an array to scans, `Trace.as_scans`.
        """
        changed, folded, moved = self._compared(scans)
        shown = np.flatnonzero(inside & changed & ~folded)
        folded = folded & inside
        previous_scans = as_scans(scans[np.maximum(shown - 1, 0)])
        start = 0
        for index, previous_scan, scan in zip(
            shown.tolist(), previous_scans, as_scans(scans[shown]), strict=True
        ):
            self._fold_all(folded, moved, slice(start, index))
            if index:
                self.skip(previous_scan)
            yield from self.rows(scan)
            start = index
        self._fold_all(folded, moved, slice(start, len(scans)))
        self.skip(next(as_scans(scans[-1:])))

    def _compared(self, scans: ScanRows) -> _ScanChanges:
        """Compare each scan with the previous one; the first scan counts as changed."""
        words = np.ascontiguousarray(scans["images"]).view(np.int16).reshape(len(scans), -1)
        is_different = np.zeros(words.shape, bool)
        is_different[1:] = words[1:] != words[:-1]
        flags = np.ones(len(scans), bool)
        flags[1:] = scans["flags"][1:] != scans["flags"][:-1]
        tags = np.zeros(len(scans), bool) if self._tags is None else self._tags.changed(scans[FIELD])
        is_changed = is_different.any(axis=1) | flags | tags
        report_columns = {name: np.zeros(words.shape[1], bool) for name in self._folded_moved}
        configured = np.zeros(len(scans), bool)
        for report in self._reporting:
            configured |= words[:, report.status // 2] < 0  # MODE_CONFIG is bit 15
            for name, span in report.spans.items():
                report_columns[name][span.start // 2 : span.stop // 2] = True
        other_columns = ~np.logical_or.reduce(list(report_columns.values()))
        other_words = is_different[:, other_columns].any(axis=1)
        is_folded = is_changed & ~(other_words | flags | configured | tags)
        if self._every:
            is_folded[:] = False
        moved = {name: np.any(is_different[:, columns], axis=1) for name, columns in report_columns.items()}
        return _ScanChanges(is_changed, is_folded, moved)

    def _fold_all(self, folded: Mask, moved: Mapping[str, Mask], span: slice) -> None:
        """Count the folded scans in a span of rows."""
        count = int(np.count_nonzero(folded[span]))
        if count:
            self._folded += count
            for name, has_moved in moved.items():
                self._folded_moved[name] |= bool((folded[span] & has_moved[span]).any())

    def skip(self, scan: Scan) -> None:
        """Remember the values of a scan that is not shown."""
        self._memory, self._flags, self._tag_row = scan.memory, scan.flags, scan.tags

    def rest(self) -> Iterator[Row]:
        """Yield a row with the number of scans folded since the last row, if any, and reset the number."""
        if self._folded:
            scans = "scan" if self._folded == 1 else "scans"
            names = " and ".join(name for name, has_moved in self._folded_moved.items() if has_moved)
            text = f"... {self._folded:,} {scans} in which only the {names} changed"
            yield Row(scan=None, now_ns=None, slot=None, direction="", position=None, encoder=None, text=text)
            self._folded = 0
            self._folded_moved = dict.fromkeys(_REPORTS.values(), False)

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
        """Count a folded scan."""
        self._folded += 1
        for report in self._reporting:
            for name, span in report.spans.items():
                if memory[span] != self._memory[span]:
                    self._folded_moved[name] = True

    def _changes(self, scan: Scan) -> Iterator[Row]:
        """Yield a row if the controller's flags changed, and a row for each changed image."""
        if scan.flags != self._flags:
            old_names: Sequence[str] = () if self._flags is None else self._flag_names(self._flags)
            text = risen_and_fallen(old_names, self._flag_names(scan.flags))
            yield Row(scan.scan, scan.now_ns, None, "cpu", position=None, encoder=None, text=text)
        for slot, slot_places in self._slots:
            for direction, image in (("in", slot_places.inputs), ("out", slot_places.outputs)):
                if scan.memory[image] != self._memory[image]:
                    yield self._row(scan, slot, direction, image)

    def _row(self, scan: Scan, slot: SlotInfo, direction: str, image: slice) -> Row:
        """Return the row of an image that differs from the previous scan, with its position and count."""
        old_words, new_words = (
            memoryview(memory)[image].cast("h").tolist() for memory in (self._memory, scan.memory)
        )
        value = self._formats.reader(slot.number, scan.scan)
        position, encoder = _reported(slot, direction, new_words, value)
        text = module_text(slot, direction, old_words, new_words, value)
        return Row(
            scan.scan, scan.now_ns, slot.number, direction, position=position, encoder=encoder, text=text
        )


def _reported(slot: SlotInfo, direction: str, words: Words, value: ValueReader) -> list[int | None]:
    """Return the position and count in an image; None for a missing value."""
    if direction != "in" or slot.words.configures("in", words):
        return [None] * len(_REPORTS)
    quantities = map(slot.words.quantity, _REPORTS)
    return [None if quantity is None else value(quantity, words) for quantity in quantities]


def _reporting(slot: SlotInfo, start: int) -> _Reporting | None:
    """Return the bytes in which a module reports mode, position and count; None without position and count.

    Args:
        start: offset of the module's input image in the memory block.
    """
    quantities = {text_name: slot.words.quantity(name) for name, text_name in _REPORTS.items()}
    spans = {
        text_name: slice(start + 2 * quantity.word, start + 2 * (quantity.word + quantity.words))
        for text_name, quantity in quantities.items()
        if quantity is not None
    }
    modes = slot.words.modes
    return None if modes is None or not spans else _Reporting(start + 2 * modes.input + 1, spans)
