"""Parts of a rung's drawing, in one-character cells; x points right and y points down.

A mark carries the power of an element, as numbered by `power`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field
from typing import NamedTuple

from scanrack.io_images.dataclass import dataclass


@dataclass(frozen=True, slots=True)
class Wire:
    """A straight wire from one cell to another, both included."""

    x: int
    y: int
    to_x: int
    to_y: int
    element: int


@dataclass(frozen=True, slots=True)
class Symbol:
    """A contact or a coil on the wire, with its name above."""

    x: int  # first column of the sign
    y: int
    sign: str  # as in `SYMBOLS`
    name: str
    label_x: int  # first column of the name
    element: int
    feeder: int  # number of the element before it
    value: str | None = None  # the tag of the value beside it, or None


class BoxLine(NamedTuple):
    """A line of a box."""

    caption: str
    operand: str  # its text, or spaces for its value
    value: str | None = None  # the tag of the value that replaces the text, or None
    states: Sequence[tuple[str, str]] = ()  # conditions and texts of states, see `block_states`


@dataclass(frozen=True, slots=True)
class Box:
    """An instruction with its operands."""

    x: int  # column of the left edge
    y: int  # row of the wire, which meets the first line
    width: int  # columns, including the edges
    title: str
    lines: tuple[BoxLine, ...]
    element: int
    states: Sequence[tuple[str, str]] = ()  # the block's state, beside its title; see `BoxLine`


@dataclass(frozen=True, slots=True)
class Corner:
    """The point where a lower leg of a branch meets the vertical wire."""

    x: int
    y: int
    opens: bool  # whether it is on the branch's left wire; the leg then continues to the right
    element: int


Mark = Wire | Symbol | Box | Corner


@dataclass(slots=True)
class Picture:
    """The layout of a rung."""

    marks: list[Mark] = field(default_factory=list)
    elements: int = 0  # number of elements
    width: int = 0  # columns between the rails
    rows: int = 0
    left: list[int] = field(default_factory=list)  # rows of the wires that start at the left rail
    right: list[int] = field(default_factory=list)  # rows of the wires that end at the right one
    continued: list[tuple[int, int]] = field(default_factory=list)  # (x, y) of the marks at a line break
    gaps: list[tuple[int, int]] = field(default_factory=list)  # (x, y) where an element may be inserted
    power: str | None = None  # power after each element, as `power` returns it; None if unknown

    def live(self, element: int) -> bool:
        """Return whether an element is known to have power after it."""
        return self.power is not None and self.power[element] == "1"
