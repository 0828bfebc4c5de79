"""The levels of a 3601's inputs, derived from recorded status bits, the only record from real hardware.

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
    recording: PackedTrace, active_high: Mapping[int, int] = MappingProxyType({})
) -> Iterator[Stimulus]:
    """Yield the level of every input at the beginning and at each change, in time order.

    An unused input has no recorded level and counts as not active.

    Args:
        active_high: masks of the inputs that are active when energized at the beginning, by slot; by default
            all inputs.
    """
    for slot in recording.slots:
        if slot.is_stepper:
            yield from _levels_of(recording, slot.number, active_high.get(slot.number, ALL_INPUTS))


def _levels_of(recording: PackedTrace, slot: int, active_high: int) -> Iterator[Stimulus]:
    """Yield the level of each input of a slot at the beginning, and then each change."""
    first_ns = recording.times[0]
    last_levels: int | None = None
    for at_ns, levels in _level_changes(recording, recording.layout.places[slot], active_high):
        for bit in InputBit:
            if last_levels is None:
                yield Stimulus(first_ns, slot, bit, bool(levels & bit.value))
            elif (last_levels ^ levels) & bit.value:
                yield Stimulus(at_ns, slot, bit, bool(levels & bit.value))
        last_levels = levels


def _level_changes(
    recording: PackedTrace, places: ImagePlaces, active_high: int
) -> Iterator[tuple[int, int]]:
    """Yield each level of a slot, from the first, as time (ns) and mask of energized inputs.

    Args:
        recording: the recording, which is read chunk by chunk.
        places: positions of the slot's images in the memory block.
        active_high: mask of the inputs that are active when energized at the beginning.
    """
    outputs, inputs = places.columns("out"), places.columns("in")
    last_levels, last_mask, last_ns = _NO_LEVELS, np.uint16(active_high), recording.times[0]
    for columns in recording.scans.chunks():
        if not len(columns.scan):
            return
        masks = _active_high(columns.words[:, outputs], last_mask)
        images = columns.words[:, inputs]
        levels = (images[:, 1].view(np.uint16) & _ALL_HIGH) ^ masks ^ _ALL_HIGH
        rows = np.flatnonzero(in_command_mode(images))
        changed = rows[np.diff(levels[rows].astype(np.int32), prepend=last_levels) != 0]
        times = np.concatenate(([last_ns], columns.time_ns))
        for row in changed.tolist():
            yield int(times[row] + times[row + 1]) // 2, int(levels[row])
        last_levels = int(levels[rows[-1]]) if len(rows) else last_levels
        last_mask, last_ns = masks[-1], int(times[-1])


_ALL_HIGH = np.uint16(ALL_INPUTS)
_NO_LEVELS = -1


def _active_high(outputs: NDArray[np.int16], earlier_mask: np.uint16) -> NDArray[np.uint16]:
    """Return, for each scan, the mask of inputs that the latest configuration makes active when energized.

    Args:
        outputs: the slot's output image in each scan.
        earlier_mask: the mask of the configuration before these scans.
    """
    configured = ~in_command_mode(outputs)
    last = np.maximum.accumulate(np.where(configured, np.arange(len(outputs)), -1))
    levels = outputs[last, 1].view(np.uint16) & _ALL_HIGH
    return np.where(last < 0, earlier_mask, levels)
