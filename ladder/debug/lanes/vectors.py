"""Runs a compiled program on arrays: each value has an element per lane, and all lanes run in parallel.

    compiled     if Start and not T_DN:  Lamp = True
    on arrays    m1 = both(m0, and_(Start, not_(T_DN)))
                 if some(m1):  Lamp = put(m1, True, Lamp)

The Python code from `compiler.source_of` is translated; a mask says which lanes run a line. A value that all
lanes share can be a plain number. Lanes that fault, or that run a line without a translation, are `lost`:
their values are meaningless.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import reduce
from typing import Any

import numpy as np

from ...model.arithmetic import wrap

MOST_PASSES = 2_000
"""Maximum passes of a loop."""

MOST_PLACES = 16
"""Maximum number of different subscripts in one access in one scan."""

_EXACT = float(1 << 60)

_BOOL = np.dtype(bool)

_WHOLE = (bool, int)

Mask = Any
"""Lanes as an array of bools; None means all lanes, and False means no lanes."""


class Vectors:
    """A program whose values are arrays, one value per lane.

    Args:
        values: variables of the program by identifier, each an array or a number, or a list of these.
        lanes: number of lanes.

    Attributes:
        lost: the lanes whose values are meaningless.
    """

    def __init__(self, code: Any, values: Mapping[str, Any], lanes: int) -> None:
        self.lost = np.zeros(lanes, bool)
        self.values: dict[str, Any] = {**values}
        methods = {name: getattr(self, f"_{name}") for name in OWN}
        self.values.update({**SERVICES, **methods})
        exec(code, self.values)

    def scan(self, active: Mask, now: Any) -> None:
        """Run one scan of some lanes, at their times in ns."""
        with np.errstate(all="ignore"):
            self.values["scan"](active, now)

    def _lose(self, mask: Mask, *_ignored: Any) -> int:
        """Mark the lanes of a mask as lost; return 0 instead of the value that they lack."""
        if mask is None:
            self.lost[:] = True
        elif mask is not False:
            self.lost |= mask
        return 0

    def _lose_if(self, mask: Mask, condition: Any) -> None:
        self._lose(both(mask, condition))

    def _loop(self, mask: Mask, passes: int) -> bool:
        """Return whether any lanes continue a loop."""
        if some(mask) and passes > MOST_PASSES:
            self._lose(mask)
            return False
        return some(mask)

    def _at(self, mask: Mask, rows: Any, index: Any) -> Any:
        """Return an element of a list, whose index may differ between lanes."""
        if index.__class__ is int:
            return rows[index]
        picked: Any = 0
        for place in self._places(mask, rows, index):
            picked = np.where(index == place, rows[place], picked)
        return picked

    def _store(self, mask: Mask, rows: Any, index: Any, value: Any) -> None:
        """Set an element of a list in the lanes of a mask; its index may differ between lanes."""
        if index.__class__ is int:
            rows[index] = put(mask, value, rows[index])
            return
        for place in self._places(mask, rows, index):
            rows[place] = put(both(mask, index == place), value, rows[place])

    def _places(self, mask: Mask, rows: Any, index: Any) -> list[int]:
        """Return the indexes that lanes use; the lanes are lost if one is out of range or too many differ."""
        used = index if mask is None else np.broadcast_to(index, self.lost.shape)[mask]
        places: list[int] = np.unique(used).tolist()
        if len(places) > MOST_PLACES or any(not 0 <= place < len(rows) for place in places):
            self._lose(mask)
            return []
        return places

    def _rows(self, mask: Mask, rows: Any, first: Any, end: Any) -> Any:
        """Return a slice of a list; the lanes are lost unless they share the bounds."""
        if first.__class__ is int and end.__class__ is int:
            return rows[first:end]
        return self._lose(mask)

    def _put_rows(self, mask: Mask, rows: Any, first: Any, end: Any, values: Any) -> None:
        """Set a slice of a list in the lanes of a mask; they are lost unless they share the bounds."""
        if (
            first.__class__ is not int
            or end.__class__ is not int
            or values.__class__ is not list
            or len(values) != end - first
        ):
            self._lose(mask)
        else:
            rows[first:end] = [put(mask, new, old) for new, old in zip(values, rows[first:end], strict=True)]

    def _copy_row(self, mask: Mask, goal: Any, at: Any, origin: Any, first: Any, count: Any) -> None:
        """Copy elements between lists; the lanes are lost unless they share the indexes."""
        if any(item.__class__ is not int for item in (at, first, count)):
            self._lose(mask)
        elif count > 0:
            self._put_rows(mask, goal, at, at + count, origin[first : first + count])

    def _times(self, mask: Mask, a: Any, b: Any) -> Any:
        """Return a product; the lanes are lost if it might not fit in 64 bits."""
        a, b = number(a), number(b)
        result = a * b
        if np.asarray(result).dtype.kind == "i" and np.abs(np.multiply(a, b, dtype=float)).max() > _EXACT:
            self._lose(mask)
        return result

    def _negative(self, mask: Mask, _site: int, _tag: str, preset: Any, accumulated: Any) -> None:
        """Mark the lanes where PRE or ACC of a timer is negative as lost."""
        self._lose_if(mask, truth((preset < 0) | (accumulated < 0)))

    def _divide(self, mask: Mask, _site: int, a: Any, b: Any) -> Any:
        """Return a quotient, rounded toward 0; lanes with a divisor of 0 are lost."""
        self._lose_if(mask, truth(b == 0))
        a, b = number(a), np.where(b == 0, 1, b)
        size = np.abs(a) // np.abs(b)
        return np.where((a < 0) == (b < 0), size, -size)

    def _modulo(self, mask: Mask, site: int, a: Any, b: Any) -> Any:
        return number(a) - self._divide(mask, site, a, b) * np.where(b == 0, 1, b)

    def _real_result(self, mask: Mask, _site: int, value: Any, *_operands: Any) -> Any:
        """Return a number rounded to REAL; lanes without a finite result are lost."""
        result = np.asarray(value, float).astype(np.float32).astype(float)
        self._lose_if(mask, truth(~np.isfinite(result)))
        return result

    def _real_divide(self, mask: Mask, site: int, a: Any, b: Any) -> Any:
        self._lose_if(mask, truth(b == 0))
        return self._real_result(mask, site, np.asarray(a, float) / np.where(b == 0, 1.0, b))

    def _wrap(self, mask: Mask, value: Any, bits: Any) -> Any:
        """Return a number wrapped to `bits` bits; the lanes are lost unless they share `bits`."""
        if bits.__class__ is not int or not -32 <= bits <= 32:
            return self._lose(mask)
        return wrap(number(value), bits)

    def _real(self, mask: Mask, value: Any) -> Any:
        return self._real_result(mask, 0, value)

    def _pick(
        self, mask: Mask, condition: Any, then: Callable[[Mask], Any], otherwise: Callable[[Mask], Any]
    ) -> Any:
        """Return one of two values by a condition; each value is evaluated only for its own lanes."""
        condition = truth(condition)
        if condition is True:
            return then(mask)
        if condition is False:
            return otherwise(mask)
        remaining = less(mask, condition)
        if not some(remaining):
            return then(mask)
        return np.where(condition, then(both(mask, condition)), otherwise(remaining))


WITH_MASK = (
    "at",
    "store",
    "rows",
    "put_rows",
    "copy_row",
    "times",
    "negative",
    "divide",
    "modulo",
    "real_result",
    "real_divide",
    "wrap",
    "real",
    "pick",
)
"""Methods of the class whose first argument is the mask."""

OWN = ("lose", "loop", *WITH_MASK)


def truth(value: Any) -> Any:
    """Return a value as a bool, or as an array of bools."""
    if value.__class__ is np.ndarray:
        return value if value.dtype is _BOOL else value != 0
    return bool(value)


def number(value: Any) -> Any:
    """Return a value as a number for arithmetic: True as 1."""
    if value.__class__ is int:
        return value
    if value.__class__ is np.ndarray:
        return value.astype(np.int64) if value.dtype is _BOOL else value
    return int(value) if isinstance(value, (bool, np.bool_)) else value


def not_(value: Any) -> Any:
    """Return the negation of a Boolean value."""
    value = truth(value)
    return not value if value.__class__ is bool else ~value


def and_(*values: Any) -> Any:
    """Return whether all are true."""
    result: Any = True
    for value in map(truth, values):
        if value is False:
            return False
        if value is not True:
            result = value if result is True else result & value
    return result


def or_(*values: Any) -> Any:
    """Return whether any is true."""
    result: Any = False
    for value in map(truth, values):
        if value is True:
            return True
        if value is not False:
            result = value if result is False else result | value
    return result


def both(mask: Mask, condition: Any) -> Mask:
    """Return the lanes of a mask where a condition is true."""
    if condition is True or mask is False:
        return mask
    if condition is False:
        return False
    return condition if mask is None else mask & condition


def less(mask: Mask, condition: Any) -> Mask:
    """Return the lanes of a mask where a condition is false."""
    return both(mask, not_(condition))


def some(mask: Mask) -> bool:
    """Return whether a mask has any lane."""
    return mask is None or (mask is not False and bool(np.count_nonzero(mask)))


def put(mask: Mask, new: Any, old: Any) -> Any:
    """Return new values in the lanes of a mask, and old values in the others.

    A value that all lanes share stays a single number.
    """
    if mask is None or old is None or new is old:
        return new
    if new.__class__ in _WHOLE and new.__class__ is old.__class__ and (mask is False or new == old):
        return old
    if new.__class__ is bool:
        if old.__class__ is bool:
            return mask if new else not_(mask)
        if old.__class__ is np.ndarray and old.dtype is _BOOL:
            return old | mask if new else old > mask
    return np.where(mask, new, old)


def least(*values: Any) -> Any:
    """Return the smallest value in each lane."""
    return min(values) if all(value.__class__ is int for value in values) else reduce(np.minimum, values)


def greatest(*values: Any) -> Any:
    """Return the largest value in each lane."""
    return reduce(np.maximum, values)


SERVICES: Mapping[str, Any] = {
    function.__name__: function
    for function in (truth, number, not_, and_, or_, both, less, some, put, least, greatest)
}
