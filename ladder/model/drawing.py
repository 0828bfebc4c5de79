"""The drawing of a function block diagram: elements and wires on sheets, and the tags of their values."""

from __future__ import annotations

from typing import Any

from scanrack.io_images.dataclass import dataclass


@dataclass(frozen=True, slots=True)
class DrawnPin:
    """A pin of an element; `value` is the address of its value, or "" if it has none."""

    name: str
    value: str = ""


@dataclass(frozen=True, slots=True)
class DrawnElement:
    """A block, reference, connector or text, with its position in editor units."""

    kind: str  # block, input, output, connector or text
    x: int
    y: int
    lines: tuple[str, ...]  # its type and its tag, its operand, or its text
    tag: str = ""  # the address that it shows, "" without one
    inputs: tuple[DrawnPin, ...] = ()
    outputs: tuple[DrawnPin, ...] = ()
    places: tuple[int, ...] = ()  # numbers of its lines of structured text


@dataclass(frozen=True, slots=True)
class DrawnWire:
    """A wire from an output pin of an element to an input pin of another; a reference's pin is ""."""

    source: int  # index of the element
    output: str
    target: int
    input: str
    value: str  # the address of its value
    feedback: bool = False


@dataclass(frozen=True, slots=True)
class DrawnSheet:
    """A sheet of a diagram."""

    number: int
    comment: str
    elements: tuple[DrawnElement, ...]
    wires: tuple[DrawnWire, ...]


@dataclass(frozen=True, slots=True)
class Drawing:
    """The sheets of a diagram."""

    sheets: tuple[DrawnSheet, ...]
    record: Any  # its data in the file, for export
