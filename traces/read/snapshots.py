"""Reads the snapshots of a recording. They are untrusted text, limited in size and never executed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from ..format.records import TraceError, read_attachment, unpacked
from ..format.snapshots import SNAPSHOTS, SNAPSHOTS_BYTES

if TYPE_CHECKING:
    from .reader import Trace

_DIGITS = 15

_MOST_BYTES = SNAPSHOTS_BYTES + (1 << 20)  # the writer does not count the scan numbers


def snapshots_of(trace: Trace) -> Mapping[int, str]:
    """Return the snapshots of a trace as JSON text, by the number of the scan that follows.

    Damaged snapshots are ignored; an explanation then repeats all scans from the first scan.
    """
    spans = [span for span, name in trace.attachment_names() if name == SNAPSHOTS]
    try:
        return _lines(read_attachment(trace.file, spans[0]).data) if len(spans) == 1 else {}
    except (TraceError, ValueError):
        return {}


def _lines(data: bytes) -> dict[int, str]:
    """Return the snapshots in an attachment by scan number; raise ValueError if a line has no number."""
    lines: dict[int, str] = {}
    for line in unpacked(data, _MOST_BYTES).decode("ascii").splitlines():
        number, _, values = line.partition(" ")
        if not number.isdigit() or len(number) > _DIGITS:
            raise ValueError("a snapshot without a scan number")
        lines[int(number)] = values
    return lines
