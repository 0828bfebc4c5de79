"""Parts: what a class of logic declares, and each instance has for itself.

A part in the class body is a description. Each instance of the class has its own copy, attached to the
slots of a rack before the first scan, and as new on each first scan.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Protocol

from ....io_images.image import Image
from ....io_images.module_words import PLAIN_WORDS, ModuleWords
from ....io_images.site import Site, SiteError

_OURS = f"{Path(__file__).parents[2]}/"

Turn = Callable[[int], None]
"""What a device does in each scan; called with the virtual time, ns."""


class Slot(Protocol):
    """A slot of the rack, as logic sees it."""

    @property
    def inputs(self) -> Image:
        """Image from the module."""

    @property
    def outputs(self) -> Image:
        """Image to the module."""


Slots = Mapping[int, Slot]
"""The slots of a rack by number."""


class LogicScan(Protocol):
    """A scan, as logic sees it."""

    @property
    def slot(self) -> Slots:
        """The slots."""

    @property
    def now_ns(self) -> int:
        """Virtual time, ns since power-up."""

    @property
    def first(self) -> bool:
        """Whether the logic is called for the first time since power-up or program mode."""


class Clock:
    """The virtual time of the present scan.

    Attributes:
        now_ns: ns since power-up.
    """

    __slots__ = ("now_ns",)

    def __init__(self) -> None:
        self.now_ns = 0


class DeclarationError(SiteError):
    """Parts that a class declares and a rack does not have, or that two own.

    Attributes:
        errors: one for each of them.
    """

    errors: tuple[ValueError, ...] = ()


class Part:
    """Something that a class of logic declares.

    Attributes:
        name: the name it is declared under.
        declared: where.
        loose: whether an instance may make it in its `__init__`, since it needs nothing of the rack.
    """

    name = ""
    loose = False

    def __init__(self) -> None:
        self.declared = site_of_caller()

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    def attach(self, slots: Slots, clock: Clock) -> None:
        """Become a part of an instance that runs on these slots.

        Raises:
            ValueError: there is no such slot, word, bit or name.
        """

    def reset_part(self) -> None:
        """Reset: the first scan since power-up or program mode."""

    def owns(self) -> tuple[int, int, int] | None:
        """Return the place that this part alone writes: slot, word, mask; word -1 is the whole slot."""
        return None


class Level(Part):
    """A part that is true or false by itself."""

    def __bool__(self) -> bool:
        raise NotImplementedError(f"{type(self).__name__} has no __bool__")


class Device(Part):
    """A part with turns of its own in each scan: before the logic, and after it."""

    def turns(self) -> tuple[Turn, Turn]:
        """Return what it does before the logic, and what it does after it."""
        raise NotImplementedError


def words_of(slots: Slots) -> dict[int, ModuleWords]:
    """Return the names of the words of each slot's module."""
    return {number: getattr(slot, "words", PLAIN_WORDS) for number, slot in slots.items()}


def site_of_caller() -> Site:
    """Return file and line of the innermost code on the stack that is not in this room."""
    frame = sys._getframe(1)
    while frame.f_code.co_filename.startswith(_OURS) and frame.f_back is not None:
        frame = frame.f_back
    return Site(file=frame.f_code.co_filename, line=frame.f_lineno)
