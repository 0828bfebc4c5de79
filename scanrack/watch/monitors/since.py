"""Since when a value is as it is, and what it was before: of tags, of words and bits, of values of Python.

A question looks through some scans. The next one goes on where it ended:

    scan       40,000 ...... 23,617      23,616 ...... 7,233      7,232 ...
    question   1: not changed            2: not changed           3: changed in 4,752
"""

from __future__ import annotations

from itertools import islice
from typing import Any, NamedTuple

import numpy as np
from scanrack.io_images.addresses import Address
from scanrack.ladder.state.memory import same

from ..history.catalog import shown_value, value_of
from ..history.program_replica import CHAPTERS, MOST_REPEATED, ProgramReplica
from ..history.strip import values_at
from .monitor import BACK, Monitor


class LastChange(NamedTuple):
    """The last change of a value up to a scan."""

    scan: int  # the first with the present value
    before: Any  # the value in the scan before


Searched = int | None
"""The first scan that was looked through, without a change; None: there are no earlier ones."""


def last_change(monitor: Monitor, tag: str, scan: int) -> LastChange | Searched:
    """Return the last change of a tag or a value up to a scan, or how far it was looked for."""
    program = monitor.subject.programs.at(scan)
    place = program.address(tag)
    if place is not None:
        return _of_image(monitor, place, scan)
    return _of_python(monitor, tag, scan) if program.past is None else _of_ladder(program.past, tag, scan)


def _of_image(monitor: Monitor, place: Address, scan: int) -> LastChange | Searched:
    first = max(0, scan - BACK)
    rows = monitor.subject.timeline.between(first, scan)
    values = values_at(rows, monitor.subject.spec.layout, place)
    changes = np.flatnonzero(values[1:] != values[:-1])
    if not len(changes):
        return first if first and len(rows) and int(rows["scan"][0]) == first else None
    return LastChange(int(rows["scan"][changes[-1] + 1]), values[changes[-1]].item())


def _of_ladder(replica: ProgramReplica, tag: str, scan: int) -> LastChange | Searched:
    if replica.is_impure:
        return None
    starts = list(islice(replica.snapshots(scan), CHAPTERS))
    if not starts or scan - starts[0] > MOST_REPEATED:
        return scan  # the values before it are being worked out
    found = replica.last_change(lambda engine: value_of(engine.tags, tag), scan)
    before = None
    if found and replica.show(found - 1):
        before = shown_value(value_of(replica.engine.tags, tag))
    replica.show(scan)
    if found is None:
        return starts[-1] - 1 if starts[-1] > 0 else None
    return LastChange(found, before)


def _of_python(monitor: Monitor, name: str, scan: int) -> LastChange | Searched:
    """Look into the recorded values, and into those that were read some thirty times a second."""
    subject = monitor.subject
    first = max(0, scan - BACK)
    _times, recorded = subject.timeline.recorded([name], first, scan)
    values = recorded.get(name, [])
    for place in range(len(values) - 1, 0, -1):
        if not same(values[place], values[place - 1]):
            return LastChange(first + place, shown_value(values[place - 1]))
    told = subject.told.last_change(name, scan)
    if told is None:
        return first if first and values else None
    return LastChange(*told)
