"""Finds since when a tag, image word or bit, or Python value has had its value, and the value before."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scanrack.io_images.addresses import Address
from scanrack.ladder.state.memory import same

from ..history.catalog import shown_value, value_of
from ..history.program_replica import ProgramReplica
from ..history.strip import values_at
from .monitor import BACK, Monitor


class LastChange(NamedTuple):
    """The last change of a value up to a scan."""

    scan: int  # the first scan with the current value
    before: Any  # the value in the previous scan


Found = tuple[LastChange | None, int]
"""A change or None, and the scan from which to search further back."""


def last_change(monitor: Monitor, tag: str, scan: int) -> Found:
    """Search a stretch of bounded length for the last change of a tag or value up to a scan.

    Raises:
        ValueError: the program calls routines in Python, so its scans are not run again.
    """
    program = monitor.subject.programs.at(scan)
    place = program.address(tag)
    if place is not None:
        return _of_image(monitor, place, scan)
    return _of_python(monitor, tag, scan) if program.past is None else _of_ladder(program.past, tag, scan)


def _of_image(monitor: Monitor, place: Address, scan: int) -> Found:
    first = max(0, scan - BACK)
    rows = monitor.subject.timeline.between(first, scan)
    values = values_at(rows, monitor.subject.spec.layout, place)
    changes = np.flatnonzero(values[1:] != values[:-1])
    if not len(changes):
        return None, first
    return LastChange(int(rows["scan"][changes[-1] + 1]), values[changes[-1]].item()), first


def _of_ladder(replica: ProgramReplica, tag: str, scan: int) -> Found:
    if replica.is_impure:
        raise ValueError("the program calls routines in Python: its scans are not run again")
    change_scan = replica.last_change(lambda engine: value_of(engine.tags, tag), scan)
    before = None
    if change_scan and replica.show(change_scan - 1):
        before = shown_value(value_of(replica.engine.tags, tag))
    replica.show(scan)
    return None if change_scan is None else LastChange(change_scan, before), replica.looked_back(scan)


def _of_python(monitor: Monitor, name: str, scan: int) -> Found:
    """Search the recorded values, and the values that were read about thirty times a second."""
    subject = monitor.subject
    first = max(0, scan - BACK)
    _times, recorded_values = subject.timeline.recorded([name], first, scan)
    values = recorded_values.get(name, [])
    for place in range(len(values) - 1, 0, -1):
        if not same(values[place], values[place - 1]):
            return LastChange(first + place, shown_value(values[place - 1])), first
    change = subject.history.last_change(name, scan)
    return None if change is None else LastChange(*change), first if values else 0
