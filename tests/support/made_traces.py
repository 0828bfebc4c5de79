"""Traces made of arrays: what every word is in every scan, and what happened beside."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scanrack.traces import ScanRecorder, SlotInfo
from scanrack.traces.format.layout import block_layout
from scanrack.traces.read.columns import Columns
from scanrack.traces.signals import stream

PERIOD_NS = 2_000_000
A3601 = SlotInfo(1, "amci3601", "4.1")

Event = tuple[str, Mapping[str, Any]]


def record(
    path: Path,
    words: np.ndarray,
    slots: Sequence[SlotInfo] = (A3601,),
    *,
    events: Mapping[int, Event] | None = None,
    period_ns: int = PERIOD_NS,
    chunk_scans: int = 50,
    metadata: Mapping[str, str] | None = None,
    sequences: bool = False,
) -> Path:
    """Record scans of which `words` gives the words, int16: per slot those of output, then of input."""
    memory = bytearray(block_layout(slots).size)
    recorder = ScanRecorder(
        path,
        memory,
        slots,
        scan_period_ns=period_ns,
        chunk_scans=chunk_scans,
        metadata=metadata,
        sequences=sequences,
    )
    for scan, row in enumerate(np.asarray(words, np.int16)):
        memory[:] = row.tobytes()
        if events and scan in events:
            topic, fields = events[scan]
            recorder.event(scan, scan * period_ns, topic, fields)
        recorder.scan(scan, scan * period_ns, 1)
    recorder.close()
    return path


def idle(scans: int, slots: int = 1) -> np.ndarray:
    """Return the words of so many scans in which nothing happens: MODULE_OK in every slot."""
    words = np.zeros((scans, 16 * slots), np.int16)
    words[:, 8::16] = 0x4000
    return words


def cut_blocks(patch: pytest.MonkeyPatch, size: int) -> None:
    """Let every trace be read in blocks of so many scans."""
    whole = stream.column_chunks

    def cut(*arguments: object, **options: object) -> Iterator[Columns]:
        for columns in whole(*arguments, **options):  # type: ignore[arg-type]
            for start in range(0, len(columns.scan), size):
                yield columns.rows(start, start + size)

    patch.setattr(stream, "column_chunks", cut)
