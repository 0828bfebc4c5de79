"""The processor's access to the status file before and after a scan [1747-RM001, "System status file"].

| word | content |
|---|---|
| S:1, bits 0 to 4 | mode: 6, remote run |
| S:1/13 | major error halted |
| S:1/15 | first pass: on in the first scan |
| S:4 | free running clock, 10 ms |
| S:5/0 | overflow trap: set at the end of a scan, major error 0020 |
| S:6 | major error code |
| S:37 to S:42 | year, month, day, hour, minute, second of the virtual time, which starts in 1970 |
"""

from __future__ import annotations

import datetime
from typing import Any

from scanrack.io_images.site import Site

from ...model.errors import LadderFault
from .status import MINOR, STATUS, Status

MODE, CLOCK, ERROR, CALENDAR = 1, 4, 6, 37
"""Numbers of words in the status file."""

REMOTE_RUN = 6
FIRST_PASS, HALTED = 15, 13
"""Bits of S:1."""

MINOR_AT_END = 0x0020
"""Code of the major error that occurs if a minor error bit is set at the end of the scan."""

_POWER_UP = datetime.datetime(1970, 1, 1)


def has_status(engine: Any) -> bool:
    """Return whether a program has a status file."""
    return engine.lowered.layout.find(STATUS) is not None


def before_scan(engine: Any, first: bool) -> None:
    """Set first pass, mode, clock and date in the status file."""
    if not has_status(engine):
        return
    status = Status(engine.interpreter)
    now_ns = engine.now_ns
    status.set_bit(MODE, FIRST_PASS, first)
    if first:
        status[MODE] = status[MODE] & ~0x1F | REMOTE_RUN
    status[CLOCK] = now_ns // 10_000_000
    now = _POWER_UP + datetime.timedelta(microseconds=now_ns // 1_000)
    for word, value in enumerate(now.timetuple()[:6], CALENDAR):
        status[word] = value


def after_scan(engine: Any) -> None:
    """Clear the first pass bit; raise LadderFault 0020 if a minor error bit is still set."""
    if not has_status(engine):
        return
    status = Status(engine.interpreter)
    status.set_bit(MODE, FIRST_PASS, False)
    if status[MINOR] & 1:
        status[ERROR] = MINOR_AT_END
        status.set_bit(MODE, HALTED, True)
        lowered = engine.lowered
        lines = lowered.routines[lowered.main].lines if lowered.main in lowered.routines else ()
        site = Site(lowered.name, lowered.main, len(lines), "END")
        text = "the overflow trap S:5/0 is set at the end of the scan"
        raise LadderFault(site, "S:5/0", text, MINOR_AT_END, 0)
