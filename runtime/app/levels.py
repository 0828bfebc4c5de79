"""The levels of a 3601's inputs, from the status bits of a recording: all that real hardware tells of them.

configuration, word 1     which level is active       [chapter 3]
input word 1, bits 0-5    which inputs are active     [chapter 6]
scan       n-1        n
bit         0         1        the level changed between the two scans: half-way, for want of better
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ...io_images.amci3601 import ALL_INPUTS, InputBit
from ...io_images.image import WORDS
from ...traces.layout import SPEAK_3601
from ...traces.replay import Recording
from ...traces.signals.decode import in_command_mode
from .playback import Stimulus


def recorded_levels(recording: Recording) -> Iterator[Stimulus]:
    """Yield the level of every input at the beginning, and whenever it changed, in order of time.

    An input that is not used shows no level: it is taken as it is shown, not active.
    """
    for slot in recording.slots:
        if slot.module in SPEAK_3601:
            yield from _levels_of(recording, slot.number)


def _levels_of(recording: Recording, slot: int) -> Iterator[Stimulus]:
    columns = recording.columns
    words, times = columns.words, columns.time_ns
    first = recording.place(slot) // 2
    outputs, inputs = words[:, first : first + WORDS], words[:, first + WORDS : first + 2 * WORDS]
    shown = in_command_mode(inputs)
    if not shown.any():
        return
    active = inputs[:, 1].view(np.uint16) & np.uint16(ALL_INPUTS)
    energised = active ^ _active_high(outputs) ^ np.uint16(ALL_INPUTS)
    rows = np.flatnonzero(shown)
    changed = rows[1:][energised[rows][1:] != energised[rows][:-1]]
    before = int(energised[rows[0]])
    for bit in InputBit:
        yield Stimulus(int(times[0]), slot, bit, bool(before & bit.value))
    for row in changed.tolist():
        now = int(energised[row])
        at_ns = int(times[row - 1] + times[row]) // 2
        for bit in InputBit:
            if (before ^ now) & bit.value:
                yield Stimulus(at_ns, slot, bit, bool(now & bit.value))
        before = now


def _active_high(outputs: NDArray[np.int16]) -> NDArray[np.uint16]:
    """Return for each scan which inputs are active when energised: as configured last, all at first."""
    configured = ~in_command_mode(outputs)
    last = np.maximum.accumulate(np.where(configured, np.arange(len(outputs)), -1))
    levels = outputs[last, 1].view(np.uint16) & np.uint16(ALL_INPUTS)
    return np.where(last < 0, np.uint16(ALL_INPUTS), levels)
