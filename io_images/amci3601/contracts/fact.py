"""Facts about images, stored as data that both a checker and a prover can use.

A fact is about up to three images of one module:

    outputs |<-- sent --->|     words that the module has between two updates
    inputs  ^ was         ^ now

`now(POSITION_INVALID)` is a bit of the later inputs, `was(...)` of the earlier ones, `sent(...)` of the
outputs in between. `&`, `|` and `~` connect facts.

>>> from scanrack.io_images.amci3601.bits import CommandMsw, StatusMsw
>>> lost = now(StatusMsw.POSITION_INVALID) & ~was(StatusMsw.POSITION_INVALID)
>>> lost.only_with(now(StatusMsw.STOPPED)).holds(now=(0x4408, 0), was=(0x4001, 0))
True
>>> lost.only_with(sent(CommandMsw.IMMEDIATE_STOP)).images == {Side.NOW, Side.WAS, Side.SENT}
True
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from functools import reduce
from operator import and_, or_
from typing import Protocol, TypeVar

from typing_extensions import override

from ..bits import CommandLsw, CommandMsw, StatusLsw, StatusMsw

Truth = TypeVar("Truth")


class Side(Enum):
    """An image that a fact is about."""

    WAS = "was"
    NOW = "now"
    SENT = "sent"


class Reading(Protocol[Truth]):
    """Reads images as truth values: bools for a checker, terms for a prover."""

    def any_of(self, side: Side, word: int, mask: int) -> Truth:
        """Return whether any bit of a mask is set in a word, 0 to 7."""

    def within(self, side: Side, word: int, least: int, most: int) -> Truth:
        """Return whether a signed word is in a range."""

    def both(self, first: Truth, second: Truth) -> Truth:
        """Return whether both values are true."""

    def negated(self, truth: Truth) -> Truth:
        """Return the negation of a truth value."""


class Fact(ABC):
    """A statement about images that is true or false."""

    @abstractmethod
    def read(self, images: Reading[Truth]) -> Truth:
        """Return the truth value of the fact."""

    @property
    @abstractmethod
    def images(self) -> frozenset[Side]:
        """The images that the fact is about."""

    def __and__(self, other: Fact) -> Fact:
        return Both(self, other)

    def __or__(self, other: Fact) -> Fact:
        return ~(~self & ~other)

    def __invert__(self) -> Fact:
        return Negation(self)

    def only_with(self, other: Fact) -> Fact:
        """Return the fact that `other` is true whenever this fact is true."""
        return ~(self & ~other)

    def same_as(self, other: Fact) -> Fact:
        """Return the fact that this fact and `other` are both true or both false."""
        return self.only_with(other) & other.only_with(self)

    def holds(
        self, now: Sequence[int], was: Sequence[int] = (0,) * 8, sent: Sequence[int] = (0,) * 8
    ) -> bool:
        """Return whether the fact is true for images; words are 16 bits, signed or unsigned."""
        return self.read(_Words({Side.NOW: now, Side.WAS: was, Side.SENT: sent}))


@dataclass(frozen=True, slots=True)
class AnyOf(Fact):
    """The fact that any bit of a mask is set."""

    side: Side
    word: int
    mask: int

    @override
    def read(self, images: Reading[Truth]) -> Truth:
        return images.any_of(self.side, self.word, self.mask)

    @property
    @override
    def images(self) -> frozenset[Side]:
        return frozenset({self.side})


@dataclass(frozen=True, slots=True)
class Within(Fact):
    """The fact that a signed word is in a range."""

    side: Side
    word: int
    least: int
    most: int

    @override
    def read(self, images: Reading[Truth]) -> Truth:
        return images.within(self.side, self.word, self.least, self.most)

    @property
    @override
    def images(self) -> frozenset[Side]:
        return frozenset({self.side})


@dataclass(frozen=True, slots=True)
class Both(Fact):
    """The fact that two facts are both true."""

    first: Fact
    second: Fact

    @override
    def read(self, images: Reading[Truth]) -> Truth:
        return images.both(self.first.read(images), self.second.read(images))

    @property
    @override
    def images(self) -> frozenset[Side]:
        return self.first.images | self.second.images


@dataclass(frozen=True, slots=True)
class Negation(Fact):
    """The negation of a fact."""

    fact: Fact

    @override
    def read(self, images: Reading[Truth]) -> Truth:
        return images.negated(self.fact.read(images))

    @property
    @override
    def images(self) -> frozenset[Side]:
        return self.fact.images


@dataclass(frozen=True, slots=True)
class _Words:
    """Reads facts about images of numbers, as bools."""

    images: dict[Side, Sequence[int]]

    def any_of(self, side: Side, word: int, mask: int) -> bool:
        return bool(self.images[side][word] & mask)

    def within(self, side: Side, word: int, least: int, most: int) -> bool:
        signed = (self.images[side][word] + 0x8000 & 0xFFFF) - 0x8000
        return least <= signed <= most

    def both(self, first: bool, second: bool) -> bool:
        return first and second

    def negated(self, truth: bool) -> bool:
        return not truth


def now(*bits: StatusMsw | StatusLsw) -> Fact:
    """Return the fact that any of the bits is set in the later inputs."""
    return _set(Side.NOW, *bits)


def was(*bits: StatusMsw | StatusLsw) -> Fact:
    """Return the fact that any of the bits was set in the earlier inputs."""
    return _set(Side.WAS, *bits)


def sent(*bits: CommandMsw | CommandLsw) -> Fact:
    """Return the fact that any of the bits was set in the outputs in between."""
    return _set(Side.SENT, *bits)


def every(*facts: Fact) -> Fact:
    """Return the fact that all of these facts are true."""
    return reduce(and_, facts)


def _set(side: Side, *bits: StatusMsw | StatusLsw | CommandMsw | CommandLsw) -> Fact:
    facts = (AnyOf(side, int(isinstance(bit, StatusLsw | CommandLsw)), bit.value) for bit in bits)
    return reduce(or_, facts)
