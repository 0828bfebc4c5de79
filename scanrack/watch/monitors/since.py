"""The last change of a tag, image word or bit, or Python value."""

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


Search = tuple[LastChange | None, int]
"""The change, or None, and the scan from which the next search continues backwards."""


def last_change(monitor: Monitor, tag: str, scan: int) -> Search:
    """Search a limited number of scans for the last change of a tag or value up to a scan.

    Raises:
        ValueError: the program calls routines in Python, so its scans can't run again.
    """
    program = monitor.subject.programs.at(scan)
    address = program.address(tag)
    if address is not None:
        return _of_image(monitor, address, scan)
    return _of_python(monitor, tag, scan) if program.past is None else _of_ladder(program.past, tag, scan)


def _of_image(monitor: Monitor, address: Address, scan: int) -> Search:
    """Search the rows for the last change of an image's word or bit."""
    first = max(0, scan - BACK)
    rows = monitor.subject.timeline.between(first, scan)
    values = values_at(rows, monitor.subject.spec.layout, address)
    changes = np.flatnonzero(values[1:] != values[:-1])
    if not len(changes):
        return None, first
    return LastChange(int(rows["scan"][changes[-1] + 1]), values[changes[-1]].item()), first


def _of_ladder(replica: ProgramReplica, tag: str, scan: int) -> Search:
    """Search for the last change of a tag by repeating scans; the replica shows the given scan again."""
    if replica.is_impure:
        raise ValueError("the program calls routines in Python: its scans are not run again")
    change_scan = replica.last_change(lambda engine: value_of(engine.tags, tag), scan)
    old_value = None
    if change_scan and replica.show(change_scan - 1):
        old_value = shown_value(value_of(replica.engine.tags, tag))
    replica.show(scan)
    change = None if change_scan is None else LastChange(change_scan, old_value)
    return change, replica.looked_back(scan)


def _of_python(monitor: Monitor, name: str, scan: int) -> Search:
    """Search the recorded values, or else the values that were read about 30 times per second."""
    subject = monitor.subject
    first = max(0, scan - BACK)
    _times, recorded_values = subject.timeline.recorded([name], first, scan)
    values = recorded_values.get(name, [])
    for index in range(len(values) - 1, 0, -1):
        if not same(values[index], values[index - 1]):
            return LastChange(first + index, shown_value(values[index - 1])), first
    read_change = subject.history.last_change(name, scan)
    change = None if read_change is None else LastChange(*read_change)
    return change, first if values else 0  # all values that were read have been searched
