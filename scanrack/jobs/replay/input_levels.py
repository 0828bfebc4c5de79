"""Derives the levels of a 3601's inputs from recorded status bits, the only source on real hardware.

configuration, word 1     which level is active       [chapter 3]
input word 1, bits 0-5    which inputs are active     [chapter 6]

scan       n-1        n
bit         0         1        the level changed between the two scans: assumed half-way
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray
from scanrack.io_images.amci3601 import ALL_INPUTS, InputBit
from scanrack.io_images.memory_layout import ImagePlaces
from scanrack.traces.replay import PackedTrace
from scanrack.traces.signals.decode import in_command_mode

from ..run.playback import Stimulus


def recorded_levels(
    recording: PackedTrace, high: Mapping[int, int] = MappingProxyType({})
) -> Iterator[Stimulus]:
    """Yield the level of every input at the beginning and at each change, in time order.

    An unused input shows no level: it counts as not active.

    Args:
        high: masks of the inputs that are active when energized at the beginning, by slot; default all.
    """
    for slot in recording.slots:
        if slot.is_stepper:
            yield from _levels_of(recording, slot.number, high.get(slot.number, ALL_INPUTS))


def _levels_of(recording: PackedTrace, slot: int, high: int) -> Iterator[Stimulus]:
    first_ns = recording.times[0]
    before: int | None = None
    for at_ns, levels in _shown(recording, recording.layout.places[slot], high):
        for bit in InputBit:
            if before is None:
                yield Stimulus(first_ns, slot, bit, bool(levels & bit.value))
            elif (before ^ levels) & bit.value:
                yield Stimulus(at_ns, slot, bit, bool(levels & bit.value))
        before = levels


def _shown(recording: PackedTrace, places: ImagePlaces, high: int) -> Iterator[tuple[int, int]]:
    """Yield the levels of a slot, first and after each change: time, ns, and mask of energized inputs.

    Args:
        recording: the recording, which is read chunk by chunk.
        places: places of the slot's images.
        high: mask of the inputs that are active when energized at the beginning.
    """
    outputs, inputs = places.columns("out"), places.columns("in")
    before, configured, last_ns = _NOTHING, np.uint16(high), recording.times[0]
    for columns in recording.scans.chunks():
        if not len(columns.scan):
            return
        active_high = _active_high(columns.words[:, outputs], configured)
        shown = columns.words[:, inputs]
        levels = (shown[:, 1].view(np.uint16) & _ALL_HIGH) ^ active_high ^ _ALL_HIGH
        rows = np.flatnonzero(in_command_mode(shown))
        changed = rows[np.diff(levels[rows].astype(np.int32), prepend=before) != 0]
        times = np.concatenate(([last_ns], columns.time_ns))
        for row in changed.tolist():
            yield int(times[row] + times[row + 1]) // 2, int(levels[row])
        before = int(levels[rows[-1]]) if len(rows) else before
        configured, last_ns = active_high[-1], int(times[-1])


_ALL_HIGH = np.uint16(ALL_INPUTS)
_NOTHING = -1  # no levels


def _active_high(outputs: NDArray[np.int16], before: np.uint16) -> NDArray[np.uint16]:
    """Return, for each scan, the mask of inputs that the latest configuration makes active when energized.

    Args:
        outputs: the slot's output image in each scan.
        before: the earlier configuration.
    """
    configured = ~in_command_mode(outputs)
    last = np.maximum.accumulate(np.where(configured, np.arange(len(outputs)), -1))
    levels = outputs[last, 1].view(np.uint16) & _ALL_HIGH
    return np.where(last < 0, before, levels)
