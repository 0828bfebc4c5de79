"""What a picture of a rung consists of, in cells of one character: x to the right, y downwards."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Wire:
    """A straight piece of wire between two cells, both included.

    Attributes:
        x: where it starts.
        y: row where it starts.
        to_x: where it ends.
        to_y: row where it ends.
        live: whether there is power on it; None if that is not known.
    """

    x: int
    y: int
    to_x: int
    to_y: int
    live: bool | None = None


@dataclass(frozen=True, slots=True)
class Symbol:
    """A contact or a coil on the wire, its name above.

    Attributes:
        x: first column of its sign.
        y: row of the wire.
        sign: as in `SYMBOLS`.
        name: its operand.
        label_x: first column of the name.
        fed: whether there is power in front of it.
        live: whether there is power behind it.
    """

    x: int
    y: int
    sign: str
    name: str
    label_x: int
    fed: bool | None = None
    live: bool | None = None


@dataclass(frozen=True, slots=True)
class Box:
    """An instruction with its operands.

    Attributes:
        x: column of the left edge.
        y: row of the wire, which meets the first line.
        width: columns, edges included.
        title: the instruction.
        lines: caption and operand, one per line.
        live: whether there is power behind it.
    """

    x: int
    y: int
    width: int
    title: str
    lines: tuple[tuple[str, str], ...]
    live: bool | None = None


@dataclass(frozen=True, slots=True)
class Corner:
    """Where a lower leg of a branch meets the vertical wire.

    Attributes:
        x: column.
        y: row.
        opens: on the left wire of the branch, so that the leg goes on to the right of it.
        live: whether there is power on it.
    """

    x: int
    y: int
    opens: bool
    live: bool | None = None


Mark = Wire | Symbol | Box | Corner


@dataclass(slots=True)
class Picture:
    """A rung, placed.

    Attributes:
        marks: everything that is drawn.
        width: columns between the rails.
        rows: rows in all.
        lines: rows of the wires that start at the left rail, and of those that end at the right one.
        continued: (x, y) of the marks that show that a wire goes on in the next line, or comes from the last.
    """

    marks: list[Mark] = field(default_factory=list)
    width: int = 0
    rows: int = 0
    left: list[int] = field(default_factory=list)
    right: list[int] = field(default_factory=list)
    continued: list[tuple[int, int]] = field(default_factory=list)
