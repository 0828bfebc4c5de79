"""Strings of a scan on terms: a length up to the room of DATA, and a term for each character.

A `Text` behaves as `bytes` where string instructions use them: joined, cut, compared, searched.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from ..algebra.meaning import INT
from ..algebra.numbers import add, bit, clip, div, eq, le, least, lt, mul, rem, sub
from ..algebra.terms import FALSE, T, and_, bits_of, const, ite, not_, or_
from .symbols import UnmodeledError, term_of

MOST_CHARACTERS = 512
"""Maximum characters of a text."""

MOST_COMPARED = 2048
"""Maximum characters that a search compares."""

Make = Callable[[T], Any]
"""Makes a number for rows from a term."""

NONE = const(0)


class TermText:
    """Characters, each from 0 to 255; those beyond the length do not count."""

    __hash__ = None  # type: ignore[assignment]

    def __init__(self, make: Make, length: T, codes: Sequence[T]) -> None:
        if len(codes) > MOST_CHARACTERS:
            raise UnmodeledError(f"a text of {len(codes)} characters")
        self.make, self.length, self.codes = make, length, list(codes)

    @classmethod
    def of(cls, make: Make, value: Any) -> TermText:
        """Return known characters as a text, a text unchanged."""
        return value if isinstance(value, TermText) else cls(make, const(len(value)), list(map(const, value)))

    def __len__(self) -> Any:
        return self.make(self.length)

    def __bool__(self) -> bool:
        return bool(self.make(not_(eq(self.length, const(0)))))

    def at(self, number: int) -> T:
        """Return a character, 0 beyond the room."""
        return self.codes[number] if number < len(self.codes) else NONE

    # --- joined and cut

    def __add__(self, other: Any) -> TermText:
        tail = TermText.of(self.make, other)
        moved = _moved(tail.codes, self.length, len(self.codes) + len(tail.codes))
        codes = [ite(lt(const(at), self.length), self.at(at), each) for at, each in enumerate(moved)]
        return TermText(self.make, add(self.length, tail.length), codes)

    def __radd__(self, other: Any) -> TermText:
        return TermText.of(self.make, other) + self

    def __getitem__(self, part: slice) -> TermText:
        first = clip(term_of(part.start or 0, INT), 0, len(self.codes))
        end = self.length
        if part.stop is not None:
            stop = clip(term_of(part.stop, INT), 0, len(self.codes))
            end = ite(lt(stop, end), stop, end)
        length = ite(lt(first, end), sub(end, first), const(0))
        return TermText(self.make, clip(length, 0, len(self.codes)), _dropped(self.codes, first))

    # --- letters

    def upper(self) -> TermText:
        """Return capitals."""
        return self._shifted(b"az", -32)

    def lower(self) -> TermText:
        """Return small letters."""
        return self._shifted(b"AZ", 32)

    def _shifted(self, ends: bytes, by: int) -> TermText:
        low, high = const(ends[0]), const(ends[1])
        codes = [ite(and_(le(low, each), le(each, high)), add(each, const(by)), each) for each in self.codes]
        return TermText(self.make, self.length, codes)

    # --- compared

    def __eq__(self, other: object) -> Any:
        return self.make(self._equals(TermText.of(self.make, other)))

    def __ne__(self, other: object) -> Any:
        return self.make(not_(self._equals(TermText.of(self.make, other))))

    def __lt__(self, other: Any) -> Any:
        return self.make(self._before(TermText.of(self.make, other)))

    def __gt__(self, other: Any) -> Any:
        return self.make(TermText.of(self.make, other)._before(self))

    def __le__(self, other: Any) -> Any:
        return self.make(not_(TermText.of(self.make, other)._before(self)))

    def __ge__(self, other: Any) -> Any:
        return self.make(not_(self._before(TermText.of(self.make, other))))

    def _equals(self, other: TermText) -> T:
        found = eq(self.length, other.length)
        for at in range(min(len(self.codes), len(other.codes))):
            counts = lt(const(at), self.length)
            found = and_(found, or_(not_(counts), eq(self.codes[at], other.codes[at])))
        return found

    def _before(self, other: TermText) -> T:
        """Whether this comes before another by the codes of the characters, a prefix first."""
        found = lt(self.length, other.length)
        for at in reversed(range(min(len(self.codes), len(other.codes)))):
            both = and_(lt(const(at), self.length), lt(const(at), other.length))
            a, b = self.codes[at], other.codes[at]
            found = ite(and_(both, not_(eq(a, b))), lt(a, b), found)
        return found

    def find(self, pattern: Any, start: Any) -> Any:
        """Return the first place of another text from a start on, -1 if it is not in it."""
        text = TermText.of(self.make, pattern)
        if len(self.codes) * len(text.codes) > MOST_COMPARED:
            raise UnmodeledError(f"a search for {len(text.codes)} characters in {len(self.codes)}")
        begin, found = term_of(start, INT), const(-1)
        for at in reversed(range(len(self.codes) + 1)):
            found = ite(and_(le(begin, const(at)), self._has(text, at)), const(at), found)
        return self.make(found)

    def _has(self, text: TermText, at: int) -> T:
        """Whether another text is at a place."""
        found = le(add(text.length, const(at)), self.length)
        for number, code in enumerate(text.codes):
            counts = lt(const(number), text.length)
            found = and_(found, or_(not_(counts), eq(self.at(at + number), code)))
        return found


def _moved(codes: Sequence[T], by: T, size: int) -> list[T]:
    """Return characters at places further to the right."""
    found = [*codes, *[NONE] * (size - len(codes))]
    for k in range(bits_of(by.lo, by.hi) - 1):
        here, moved = bit(by, k), [NONE] * (1 << k) + found
        found = [ite(here, there, each) for each, there in zip(found, moved, strict=False)]
    return found


def _dropped(codes: Sequence[T], by: T) -> list[T]:
    """Return characters without the first ones."""
    found = list(codes)
    for k in range(bits_of(by.lo, by.hi) - 1):
        here, moved = bit(by, k), found[1 << k :] + [NONE] * (1 << k)
        found = [ite(here, there, each) for each, there in zip(found, moved, strict=False)]
    return found


def digits(make: Make, value: Any) -> TermText:
    """Return a whole number as text."""
    t = term_of(value, INT)
    negative = lt(t, const(0))
    size = ite(negative, sub(const(0), t), t)
    places = len(str(max(abs(t.lo), abs(t.hi))))
    powers = [const(10**k) for k in range(places)]
    codes = [add(rem(div(size, power), const(10)), const(48)) for power in reversed(powers)]
    leading, count = const(0), const(1)
    for power in powers[1:]:
        more = le(power, size)
        leading = add(leading, ite(more, const(0), const(1)))
        count = add(count, ite(more, const(1), const(0)))
    number = TermText(make, clip(count, 1, places), _dropped(codes, clip(leading, 0, places - 1)))
    signed = b"-" + number
    chosen = [ite(negative, signed.at(at), number.at(at)) for at in range(places + 1)]
    return TermText(make, ite(negative, signed.length, number.length), chosen)


FAR = 10**20
"""Numbers in texts count up to here: beyond every type of integers."""


def number_in(text: TermText) -> tuple[T, T]:
    """Return the first whole number in a text, 0 without one, and whether it is exact: below FAR."""
    value, negative, begun, over = const(0), FALSE, FALSE, FALSE
    before = NONE
    for at, code in enumerate(text.codes):
        is_digit = and_(lt(const(at), text.length), and_(le(const(48), code), le(code, const(57))))
        counts = and_(is_digit, not_(over))
        negative = ite(and_(counts, not_(begun)), eq(before, const(45)), negative)
        digit = clip(add(code, const(-48)), 0, 9)
        value = ite(counts, least(add(mul(value, const(10)), digit), FAR), value)
        over, begun = or_(over, and_(begun, not_(is_digit))), or_(begun, counts)
        before = code
    return ite(negative, sub(const(0), value), value), lt(value, const(FAR))
