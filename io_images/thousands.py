"""Splits wide values into two decimal words, an MSW of thousands and an LSW, and joins them.

A value that needs more than 16 bits crosses the backplane as two words:

    value = 1000 * MSW + LSW

The MSW has the thousands, and the LSW the ones, tens and hundreds; if the value is negative, each nonzero
word is negative [3601 manual r3.1, Module Overview].

    value     MSW   LSW
    -12,345   -12   -345
     12,000    12      0
    -12,000   -12      0
        345     0    345
       -345     0   -345

Parameters that the PLC sends are checked: an LSW beyond 999 or words of
opposite signs are illegal [chapter 5 notes 3 to 5; chapter 6, Command
Error 4]. Reported values are not limited to the parameter range: up to 65,535,999, the thousands use all 16
bits of the MSW, so an MSW above 7FFFh reads as negative [chapter 6, Current Position].
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

PARAMETER_MIN = -8_388_608
"""Minimum position parameter [chapter 5 table; the +-8,388,607 of chapter 6 is less specific]."""

PARAMETER_MAX = 8_388_607
"""Maximum position parameter [chapter 5 note 4]."""

LSW_MAX = 999
REPORTED_MAX = 65_535_999
"""Maximum magnitude of a reported value [chapter 6, Current Position]."""

_MSW_MAX = 32_767
_MSW_SPAN = 65_536


def is_legal_pair(msw: int, lsw: int) -> bool:
    """Return whether two words form a legal value: |LSW| <= 999, and no opposite signs.

    The printed sign rule ("one word negative and the other not zero and
    positive") can only mean words of opposite signs, since the manual's own
    -12,000 is (-12, 0) [chapter 6, Command Error 4].

    >>> is_legal_pair(-12, -345), is_legal_pair(-12, 0), is_legal_pair(-12, 345), is_legal_pair(0, 1000)
    (True, True, False, False)
    """
    return -LSW_MAX <= lsw <= LSW_MAX and msw * lsw >= 0


def split_thousands(value: int) -> tuple[int, int]:
    """Split a signed value into the module's (MSW, LSW) pair.

    >>> split_thousands(-12_345), split_thousands(12_000), split_thousands(-345)
    ((-12, -345), (12, 0), (0, -345))

    Args:
        value: steps, counts or steps/s, |value| <= 32,767,999.

    Returns:
        (msw, lsw), two signed 16-bit words without opposite signs.

    Raises:
        ValueError: the thousands do not fit in a signed word.
    """
    magnitude_msw, magnitude_lsw = divmod(abs(value), 1000)
    if magnitude_msw > _MSW_MAX:
        limit = 1000 * _MSW_MAX + LSW_MAX
        raise ValueError(f"{value} does not fit two words: must be -{limit} to {limit}")
    return (-magnitude_msw, -magnitude_lsw) if value < 0 else (magnitude_msw, magnitude_lsw)


def join_thousands(msw: int, lsw: int) -> int:
    """Join an (MSW, LSW) pair into its value; the inverse of `split_thousands`.

    >>> join_thousands(-12, -345), join_thousands(0, 345)
    (-12345, 345)

    Raises:
        ValueError: the pair is illegal (see `is_legal_pair`).
    """
    if not is_legal_pair(msw, lsw):
        raise ValueError(
            f"words ({msw}, {lsw}) are not a value: the LSW must be -999 to 999 and have the MSW's sign"
        )
    return 1000 * msw + lsw


def split_reported(value: int) -> tuple[int, int]:
    """Split a reported position or count into (MSW, LSW) words; large values wrap, as in the module.

    The MSW is the low 16 bits of the signed thousands, and the LSW is the remainder
    with the sign of the value [chapter 6, Current Position].

    >>> split_reported(-345), split_reported(32_767_999), split_reported(32_768_000)
    ((0, -345), (32767, 999), (-32768, 0))

    Args:
        value: steps or counts of any size; it wraps at +-65,536,000.
    """
    if value < 0:
        thousands, lsw = divmod(-value, 1000)
        thousands, lsw = -thousands, -lsw
    else:
        thousands, lsw = divmod(value, 1000)
    return (thousands + 32_768 & 0xFFFF) - 32_768, lsw


def split_reported_all(values: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Split many reported values, as `split_reported` does; the MSW is in the low 16 bits."""
    if values.min(initial=0) >= 0:
        thousands = values // 1000
    else:
        sign = 1 - 2 * (values < 0)
        thousands = values * sign // 1000 * sign
    return thousands, values - 1000 * thousands


def join_reported(msw: int, lsw: int) -> int:
    """Join reported words into the value; the inverse of `split_reported` up to 32,767,999.

    Beyond that the sign of the LSW distinguishes a wrapped MSW from a negative value.
    If the LSW is 0, its sign can't show this, and the unwrapped value is returned.

    >>> join_reported(-1, 999), join_reported(-1, -999), join_reported(16_777, 214)
    (65535999, -1999, 16777214)
    """
    if msw < 0 < lsw:
        return 1000 * (msw + _MSW_SPAN) + lsw
    if lsw < 0 < msw:
        return 1000 * (msw - _MSW_SPAN) + lsw
    return 1000 * msw + lsw


def join_reported_all(msw: NDArray[np.int16], lsw: NDArray[np.int16]) -> NDArray[np.float64]:
    """Join columns of reported words into values, as `join_reported` does for a single pair.

    >>> import numpy as np
    >>> join_reported_all(np.array([-1, -1, 16], np.int16), np.array([999, -999, 214], np.int16)).tolist()
    [65535999.0, -1999.0, 16214.0]
    """
    values: NDArray[np.float64] = msw.astype(float) * 1000 + lsw
    values[(msw < 0) & (lsw > 0)] += 1000 * _MSW_SPAN
    values[(msw > 0) & (lsw < 0)] -= 1000 * _MSW_SPAN
    return values
