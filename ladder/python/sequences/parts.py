"""Parts, which are declared in a logic class and copied for each instance.

A part in the class body is a declaration. Each instance of the class has a separate copy, which is attached
to the slots of a rack before the first scan, and reset on each first scan.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple, Protocol, Self

from scanrack.io_images.image import Image
from scanrack.io_images.module_words import PLAIN_WORDS, ModuleWords
from scanrack.io_images.site import Site, SiteError

_OURS = f"{Path(__file__).parents[2]}{os.sep}"

Turn = Callable[[int], None]
"""A device's action in each scan, called with the virtual time, ns."""


class Slot(Protocol):
    """A slot of the rack, as the logic sees it."""

    @property
    def inputs(self) -> Image:
        """Image from the module."""

    @property
    def outputs(self) -> Image:
        """Image to the module."""


Slots = Mapping[int, Slot]
"""The slots of a rack by number."""


class LogicScan(Protocol):
    """A scan, as the logic sees it."""

    @property
    def slot(self) -> Slots:
        """The slots."""

    @property
    def now_ns(self) -> int:
        """Virtual time, ns since power-up."""

    @property
    def first(self) -> bool:
        """Whether this is the first scan since power-up or program mode."""


class Clock:
    """The virtual time of the current scan, ns since power-up."""

    __slots__ = ("now_ns",)

    def __init__(self) -> None:
        self.now_ns = 0


class DeclarationError(SiteError):
    """Declared parts use places that the rack lacks, or share a place."""

    errors: tuple[ValueError, ...] = ()  # one for each wrong part


class Part:
    """A declared part of a logic class.

    Attributes:
        declared: file and line of its declaration.
        loose: whether an `__init__` may create it, because it needs nothing from the rack.
    """

    name = ""
    loose = False
    _part_made: tuple[tuple[object, ...], dict[str, object]]

    def __new__(cls, *args: object, **options: object) -> Self:
        """Create a part, and store where it is declared."""
        part = super().__new__(cls)
        part._part_made = (args, options)
        return part

    def __init__(self) -> None:
        self.declared = site_of_caller()

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    def attach(self, slots: Slots, clock: Clock) -> None:
        """Attach to the slots; raise a ValueError for an unknown slot, word, bit or name."""

    def reset_part(self) -> None:
        """Reset, in the first scan since power-up or program mode."""

    def continues_as(self, edited: Part) -> bool:
        """Return whether its state fits its declaration in the edited program."""
        return type(self) is type(edited) and self._part_made == edited._part_made

    def continue_as(self, edited: Part) -> None:
        """Copy its declaration in the edited program, and keep the state."""
        self.declared, self._part_made = edited.declared, edited._part_made

    def owns(self) -> tuple[int, int, int] | None:
        """Return the place that only this part writes: slot, word and mask; word -1 is the whole slot."""
        return None


class Level(Part):
    """A part with a truth value."""

    def __bool__(self) -> bool:
        raise NotImplementedError(f"{type(self).__name__} has no __bool__")


class Idle(NamedTuple):
    """Python expressions that are true while a device's actions have no effect."""

    before: str  # for the action before the logic; `{name}` stands for an object in `names`
    after: str
    names: Mapping[str, object]


class Device(Part):
    """A part with actions before and after the logic of each scan."""

    def turns(self) -> tuple[Turn, Turn]:
        """Return its actions before and after the logic."""
        raise NotImplementedError

    def idle(self) -> Idle | None:
        """Return the conditions under which these actions have no effect; None to call them in each scan."""
        return None


def words_of(slots: Slots) -> dict[int, ModuleWords]:
    """Return the word names of each slot's module."""
    return {number: getattr(slot, "words", PLAIN_WORDS) for number, slot in slots.items()}


def site_of_caller() -> Site:
    """Return the file and line of the innermost code on the stack that is outside this package."""
    frame = sys._getframe(1)
    while frame.f_code.co_filename.startswith(_OURS) and frame.f_back is not None:
        frame = frame.f_back
    return Site(file=frame.f_code.co_filename, line=frame.f_lineno)
