"""Strings in a scan on terms, with a length up to the size of DATA and a term for each character.

A `TermText` supports the operations of `bytes` that string instructions use: join, slice, compare, find.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from ..algebra.meaning import INT
from ..algebra.numbers import add, bit, clip, div, eq, le, least, lt, mul, rem, sub
from ..algebra.terms import FALSE, T, and_, bits_of, const, ite, not_, or_
from .symbols import UnmodeledError, term_of

MOST_CHARACTERS = 512
"""Maximum number of characters in a text."""

MOST_COMPARED = 2048
"""Maximum number of characters that a search compares."""

Make = Callable[[T], Any]
"""Converts a term to a number that rows can use."""

NONE = const(0)


class TermText:
    """Characters, each from 0 to 255; characters beyond the length are ignored."""

    __hash__ = None  # type: ignore[assignment]

    def __init__(self, make: Make, length: T, codes: Sequence[T]) -> None:
        if len(codes) > MOST_CHARACTERS:
            raise UnmodeledError(f"a text of {len(codes)} characters")
        self.make, self.length, self.codes = make, length, list(codes)

    @classmethod
    def of(cls, make: Make, value: Any) -> TermText:
        """Return known characters as a `TermText`; return a `TermText` unchanged."""
        return value if isinstance(value, TermText) else cls(make, const(len(value)), list(map(const, value)))

    def __len__(self) -> Any:
        return self.make(self.length)

    def __bool__(self) -> bool:
        return bool(self.make(not_(eq(self.length, const(0)))))

    def at(self, number: int) -> T:
        """Return a character; 0 beyond the stored characters."""
        return self.codes[number] if number < len(self.codes) else NONE

    # --- joining and slicing

    def __add__(self, other: Any) -> TermText:
        tail = TermText.of(self.make, other)
        moved = _moved(tail.codes, self.length, len(self.codes) + len(tail.codes))
        codes = [ite(lt(const(index), self.length), self.at(index), code) for index, code in enumerate(moved)]
        return TermText(self.make, add(self.length, tail.length), codes)

    def __radd__(self, other: Any) -> TermText:
        return TermText.of(self.make, other) + self

    def __getitem__(self, part: slice) -> TermText:
        """Return the characters from a start up to a stop; both may be terms and beyond the end."""
        first = clip(term_of(part.start or 0, INT), 0, len(self.codes))
        end = self.length
        if part.stop is not None:
            stop = clip(term_of(part.stop, INT), 0, len(self.codes))
            end = ite(lt(stop, end), stop, end)
        length = ite(lt(first, end), sub(end, first), const(0))
        return TermText(self.make, clip(length, 0, len(self.codes)), _dropped(self.codes, first))

    # --- case

    def upper(self) -> TermText:
        """Return the text in capitals."""
        return self._shifted(b"az", -32)

    def lower(self) -> TermText:
        """Return the text in lower case."""
        return self._shifted(b"AZ", 32)

    def _shifted(self, ends: bytes, difference: int) -> TermText:
        """Return the text with a difference added to each code in the range between two ends."""
        low, high = const(ends[0]), const(ends[1])
        codes = [
            ite(and_(le(low, code), le(code, high)), add(code, const(difference)), code)
            for code in self.codes
        ]
        return TermText(self.make, self.length, codes)

    # --- comparing

    def __eq__(self, other: object) -> Any:
        return self.make(self._equals(TermText.of(self.make, other)))

    def __ne__(self, other: object) -> Any:
        return self.make(not_(self._equals(TermText.of(self.make, other))))

    def __lt__(self, other: Any) -> Any:
        return self.make(self._sorts_before(TermText.of(self.make, other)))

    def __gt__(self, other: Any) -> Any:
        return self.make(TermText.of(self.make, other)._sorts_before(self))

    def __le__(self, other: Any) -> Any:
        return self.make(not_(TermText.of(self.make, other)._sorts_before(self)))

    def __ge__(self, other: Any) -> Any:
        return self.make(not_(self._sorts_before(TermText.of(self.make, other))))

    def _equals(self, other: TermText) -> T:
        """Return whether both texts have the same length and the same characters."""
        equal = eq(self.length, other.length)
        for place in range(min(len(self.codes), len(other.codes))):
            counts = lt(const(place), self.length)
            equal = and_(equal, or_(not_(counts), eq(self.codes[place], other.codes[place])))
        return equal

    def _sorts_before(self, other: TermText) -> T:
        """Return whether this text sorts before another by character codes; a prefix sorts first."""
        less = lt(self.length, other.length)
        for place in reversed(range(min(len(self.codes), len(other.codes)))):
            within = and_(lt(const(place), self.length), lt(const(place), other.length))
            own_code, other_code = self.codes[place], other.codes[place]
            less = ite(and_(within, not_(eq(own_code, other_code))), lt(own_code, other_code), less)
        return less

    def find(self, pattern: Any, start: Any) -> Any:
        """Return the first index of another text at or after a start; -1 if it is not found."""
        text = TermText.of(self.make, pattern)
        if len(self.codes) * len(text.codes) > MOST_COMPARED:
            raise UnmodeledError(f"a search for {len(text.codes)} characters in {len(self.codes)}")
        begin, position = term_of(start, INT), const(-1)
        for place in reversed(range(len(self.codes) + 1)):
            position = ite(and_(le(begin, const(place)), self._has(text, place)), const(place), position)
        return self.make(position)

    def _has(self, text: TermText, start: int) -> T:
        """Return whether another text is found at an index."""
        matches = le(add(text.length, const(start)), self.length)
        for number, code in enumerate(text.codes):
            counts = lt(const(number), text.length)
            matches = and_(matches, or_(not_(counts), eq(self.at(start + number), code)))
        return matches


def _moved(codes: Sequence[T], distance: T, size: int) -> list[T]:
    """Return characters shifted to the right."""
    shifted = [*codes, *[NONE] * (size - len(codes))]
    for k in range(bits_of(distance.lo, distance.hi) - 1):
        # bit k of the distance moves the characters by 2**k
        moves, shifted_once = bit(distance, k), [NONE] * (1 << k) + shifted
        shifted = [
            ite(moves, other_code, code) for code, other_code in zip(shifted, shifted_once, strict=False)
        ]
    return shifted


def _dropped(codes: Sequence[T], count: T) -> list[T]:
    """Return characters without the first `count` characters."""
    shifted = list(codes)
    for k in range(bits_of(count.lo, count.hi) - 1):
        moves, shifted_once = bit(count, k), shifted[1 << k :] + [NONE] * (1 << k)
        shifted = [
            ite(moves, other_code, code) for code, other_code in zip(shifted, shifted_once, strict=False)
        ]
    return shifted


def digits(make: Make, value: Any) -> TermText:
    """Return a whole number as decimal text, with a minus sign and without leading zeros."""
    term = term_of(value, INT)
    negative = lt(term, const(0))
    size = ite(negative, sub(const(0), term), term)
    places = len(str(max(abs(term.lo), abs(term.hi))))
    powers = [const(10**k) for k in range(places)]
    zero = const(ord("0"))
    codes = [add(rem(div(size, power), const(10)), zero) for power in reversed(powers)]
    leading, count = const(0), const(1)
    for power in powers[1:]:
        reached = le(power, size)
        leading = add(leading, ite(reached, const(0), const(1)))
        count = add(count, ite(reached, const(1), const(0)))
    number = TermText(make, clip(count, 1, places), _dropped(codes, clip(leading, 0, places - 1)))
    signed = b"-" + number
    chosen = [ite(negative, signed.at(index), number.at(index)) for index in range(places + 1)]
    return TermText(make, ite(negative, signed.length, number.length), chosen)


FAR = 10**20
"""Limit for numbers read from texts, above the range of every integer type."""


def number_in(text: TermText) -> tuple[T, T]:
    """Return the first whole number in a text, or 0, and the condition that it is exact (below FAR)."""
    value, negative, has_begun, is_over = const(0), FALSE, FALSE, FALSE
    previous = NONE
    for place, code in enumerate(text.codes):
        in_range = and_(le(const(ord("0")), code), le(code, const(ord("9"))))
        is_digit = and_(lt(const(place), text.length), in_range)
        counts = and_(is_digit, not_(is_over))
        negative = ite(and_(counts, not_(has_begun)), eq(previous, const(ord("-"))), negative)
        digit = clip(add(code, const(-ord("0"))), 0, 9)
        value = ite(counts, least(add(mul(value, const(10)), digit), FAR), value)
        is_over, has_begun = or_(is_over, and_(has_begun, not_(is_digit))), or_(has_begun, counts)
        previous = code
    return ite(negative, sub(const(0), value), value), lt(value, const(FAR))
