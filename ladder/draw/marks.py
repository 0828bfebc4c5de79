"""What a picture of a rung consists of, in cells of one character: x to the right, y downwards.

A mark names the element of the rung whose power it carries; `power` numbers them.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple


@dataclass(frozen=True, slots=True)
class Wire:
    """A straight piece of wire between two cells, both included.

    Attributes:
        x: where it starts.
        y: row where it starts.
        to_x: where it ends.
        to_y: row where it ends.
        element: after which it starts.
    """

    x: int
    y: int
    to_x: int
    to_y: int
    element: int


@dataclass(frozen=True, slots=True)
class Symbol:
    """A contact or a coil on the wire, its name above.

    Attributes:
        x: first column of its sign.
        y: row of the wire.
        sign: as in `SYMBOLS`.
        name: its operand.
        label_x: first column of the name.
        element: its number.
        feeder: the element before it.
        value: the tag whose value is beside it; None without one.
    """

    x: int
    y: int
    sign: str
    name: str
    label_x: int
    element: int
    feeder: int
    value: str | None = None


class BoxLine(NamedTuple):
    """A line of a box.

    Attributes:
        caption: what the operand is called.
        operand: its text, or as many spaces as its value takes.
        value: the tag whose value replaces the text; None without one.
    """

    caption: str
    operand: str
    value: str | None = None


@dataclass(frozen=True, slots=True)
class Box:
    """An instruction with its operands.

    Attributes:
        x: column of the left edge.
        y: row of the wire, which meets the first line.
        width: columns, edges included.
        title: the instruction.
        lines: from top to bottom.
        element: its number.
    """

    x: int
    y: int
    width: int
    title: str
    lines: tuple[BoxLine, ...]
    element: int


@dataclass(frozen=True, slots=True)
class Corner:
    """Where a lower leg of a branch meets the vertical wire.

    Attributes:
        x: column.
        y: row.
        opens: on the left wire of the branch, so that the leg goes on to the right of it.
        element: whose power it carries.
    """

    x: int
    y: int
    opens: bool
    element: int


Mark = Wire | Symbol | Box | Corner


@dataclass(slots=True)
class Picture:
    """A rung, placed.

    Attributes:
        marks: everything that is drawn.
        elements: number of elements of the rung.
        width: columns between the rails.
        rows: rows in all.
        left: rows of the wires that start at the left rail.
        right: rows of the wires that end at the right one.
        continued: (x, y) of the marks that show that a wire goes on in the next line, or comes from the last.
        power: of each element, as `power` gives it; None if that is not known.
    """

    marks: list[Mark] = field(default_factory=list)
    elements: int = 0
    width: int = 0
    rows: int = 0
    left: list[int] = field(default_factory=list)
    right: list[int] = field(default_factory=list)
    continued: list[tuple[int, int]] = field(default_factory=list)
    power: str | None = None

    def live(self, element: int) -> bool:
        """Whether there is known to be power after an element."""
        return self.power is not None and self.power[element] == "1"
