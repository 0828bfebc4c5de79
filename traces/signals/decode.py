"""Words of a 3601 into values, for whole columns at once."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...io_images.amci3601 import LIVE_BITS, CommandMsw, StatusMsw

Words = NDArray[np.int16]
"""A column per word, a row per scan: one image of one slot."""

_MODE_CONFIG = StatusMsw.MODE_CONFIG.value  # the same bit in either direction
_WRAP = 65_536_000


def joined(msw: NDArray[np.int16], lsw: NDArray[np.int16]) -> NDArray[np.float64]:
    """Join reported words into values, as `thousands.join_reported` does for one.

    >>> joined(np.array([-1, -1, 16], np.int16), np.array([999, -999, 214], np.int16)).tolist()
    [65535999.0, -1999.0, 16214.0]
    """
    values = msw.astype(np.float64) * 1000 + lsw
    opposite = (msw < 0) & (lsw > 0), (msw > 0) & (lsw < 0)
    values[opposite[0]] += _WRAP
    values[opposite[1]] -= _WRAP
    return values


def in_command_mode(words: Words) -> NDArray[np.bool_]:
    """Return the scans in which an image is in command mode: bit 15 of word 0 is clear."""
    result: NDArray[np.bool_] = words[:, 0] >= 0
    return result


def value(words: Words, msw: int) -> NDArray[np.float64]:
    """Return the value in words `msw` and `msw + 1`, NaN in configuration mode."""
    values = joined(words[:, msw], words[:, msw + 1])
    values[~in_command_mode(words)] = np.nan
    return values


def bit(column: NDArray[Any], mask: int) -> NDArray[np.bool_]:
    """Return the scans in which a bit of a word is set; `mask` is 1 to 8000h."""
    result: NDArray[np.bool_] = (column.view(np.uint16) & np.uint16(mask)) != 0
    return result


def status_bit(words: Words, word: int, mask: int) -> NDArray[np.bool_]:
    """Return the scans in which a status bit is set.

    In configuration mode all but three bits mirror the configuration: none of these counts as set then.
    """
    found = bit(np.ascontiguousarray(words[:, word]), mask)
    return found if not word and mask & LIVE_BITS else found & in_command_mode(words)


def command_bit(words: Words, word: int, mask: int) -> NDArray[np.bool_]:
    """Return the scans in which a command bit is set; in configuration mode only MODE_CONFIG is one."""
    found = bit(np.ascontiguousarray(words[:, word]), mask)
    return found if not word and mask == CommandMsw.MODE_CONFIG.value else found & in_command_mode(words)


def travel(words: Words) -> NDArray[np.float64]:
    """Return the motion of the position words since the previous scan, steps.

    A preset, the end of homing or a configuration sets the position without a step: changes
    while neither MOVING bit is set, or against its direction, count as 0.

    Args:
        words: an input image's words, a row per scan.
    """
    steps = np.zeros(len(words))
    moved = np.diff(value(words, 2))
    onward = np.where(status_bit(words, 0, StatusMsw.MOVING_CW.value)[1:], moved, 0)
    back = np.where(status_bit(words, 0, StatusMsw.MOVING_CCW.value)[1:], moved, 0)
    steps[1:] = np.fmax(onward, 0) + np.fmin(back, 0)
    return steps


def speed(words: Words, time_ns: NDArray[np.int64], margin: int) -> NDArray[np.float64]:
    """Return the mean speed from `margin` scans before to `margin` scans after each one, steps/s, signed.

    Args:
        words: an input image's words, a row per scan.
        margin: scans either way, 1 or more; fewer at the ends.
    """
    distance = np.cumsum(travel(words))
    rows = np.arange(len(words))
    late, early = np.minimum(rows + margin, len(rows) - 1), np.maximum(rows - margin, 0)
    elapsed = (time_ns[late] - time_ns[early]) / 1e9
    return np.divide(distance[late] - distance[early], elapsed, out=np.zeros(len(rows)), where=elapsed > 0)
