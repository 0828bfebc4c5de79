"""How much room the parts of a rung take: columns, and rows above and below the wire.

Contacts and coils have their name above the wire; every other instruction is a box with its name in the upper
edge and an operand per line, the wire at the first one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from ..addon import AddOn
from ..tree import Branch, Element, Instruction, Series

SYMBOLS = {
    "XIC": "┤ ├",
    "XIO": "┤/├",
    "OTE": "( )",
    "OTL": "(L)",
    "OTU": "(U)",
    "ONS": "[ONS]",
    "RES": "(RES)",
}
"""Instructions that are drawn as contacts and coils; their one operand stands above."""

CAPTIONS = {
    "TON": ("Timer", "Preset", "Accum"),
    "TOF": ("Timer", "Preset", "Accum"),
    "RTO": ("Timer", "Preset", "Accum"),
    "CTU": ("Counter", "Preset", "Accum"),
    "CTD": ("Counter", "Preset", "Accum"),
    "LIM": ("Low", "Test", "High"),
    "MEQ": ("Source", "Mask", "Compare"),
    "MOV": ("Source", "Dest"),
    "MVM": ("Source", "Mask", "Dest"),
    "COP": ("Source", "Dest", "Length"),
    "CPS": ("Source", "Dest", "Length"),
    "FLL": ("Source", "Dest", "Length"),
    "CPT": ("Dest", "Expression"),
    "CMP": ("Expression",),
    "CLR": ("Dest",),
    "BTD": ("Source", "Source bit", "Dest", "Dest bit", "Length"),
    "SWPB": ("Source", "Order", "Dest"),
    "OSR": ("Storage", "Output"),
    "OSF": ("Storage", "Output"),
    "JSR": ("Routine", "Inputs"),
    "JMP": ("Label",),
    "LBL": ("Label",),
    **dict.fromkeys(("EQU", "NEQ", "GRT", "GEQ", "LES", "LEQ"), ("Source A", "Source B")),
    **dict.fromkeys(
        ("ADD", "SUB", "MUL", "DIV", "MOD", "AND", "OR", "XOR"), ("Source A", "Source B", "Dest")
    ),
    **dict.fromkeys(("NEG", "ABS", "SQR", "NOT", "TRN"), ("Source", "Dest")),
}
"""What the operands of a box are called, as Studio 5000 calls them."""

GAP = 1
"""Columns of wire on either side of a contact, a coil or a box."""

JOIN = 1
"""Columns that the vertical wire of a branch takes on either side."""


@dataclass(frozen=True, slots=True)
class Size:
    """Room that a part takes.

    Attributes:
        width: columns.
        above: rows above its wire.
        below: rows below its wire.
    """

    width: int
    above: int
    below: int


def captions_of(add_ons: Iterable[AddOn]) -> dict[str, tuple[str, ...]]:
    """Return what the operands of add-on instructions are called, by the instruction's name."""
    return {each.name: ("Instance", *(parameter.name for parameter in each.required)) for each in add_ons}


class Ruler:
    """Measures elements; knows what operands are called."""

    def __init__(self, captions: Mapping[str, Sequence[str]]) -> None:
        self._captions = {**CAPTIONS, **captions}

    def size(self, element: Element) -> Size:
        """Return the room that an element takes."""
        if isinstance(element, Branch):
            legs = list(map(self.series, element.legs))
            width = max(leg.width for leg in legs) + 2 * JOIN
            below = legs[0].below + sum(leg.above + 1 + leg.below for leg in legs[1:])
            return Size(max(width, 2 * JOIN + 1), legs[0].above, below)
        if is_symbol(element):
            widest = max(len(str(element.operands[0])), len(SYMBOLS[element.name]))
            return Size(widest + 2 * GAP, 1, 0)
        lines = self.lines(element)
        caption = caption_width(lines)
        inner = max([len(element.name), *(caption + len(operand) for _, operand in lines)])
        return Size(inner + 4 + 2 * GAP, 1, max(len(lines), 1))

    def series(self, series: Series) -> Size:
        """Return the room that elements take behind each other."""
        sizes = list(map(self.size, series))
        return Size(
            sum(size.width for size in sizes),
            max((size.above for size in sizes), default=0),
            max((size.below for size in sizes), default=0),
        )

    def lines(self, instruction: Instruction) -> tuple[tuple[str, str], ...]:
        """Return caption and text of each operand of a box."""
        captions = self._captions.get(instruction.name, ())
        return tuple(
            (captions[number] if number < len(captions) else "", str(operand))
            for number, operand in enumerate(instruction.operands)
        )

    def leg_rows(self, branch: Branch, y: int) -> list[int]:
        """Return the rows of the legs' wires; the first one is the branch's own."""
        rows, below = [y], self.series(branch.legs[0]).below
        for leg in branch.legs[1:]:
            size = self.series(leg)
            rows.append(rows[-1] + below + size.above + 1)
            below = size.below
        return rows

    def chunks(self, series: Series, width: int) -> Iterator[Series]:
        """Break a series into lines that keep to the width where that is possible."""
        line: list[Element] = []
        used = 0
        for element in series:
            wide = self.size(element).width
            if line and used + wide > width:
                yield tuple(line)
                line, used = [], 0
            line.append(element)
            used += wide
        yield tuple(line)


def caption_width(lines: Sequence[tuple[str, str]]) -> int:
    """Return the columns of the captions of a box, with the space behind them."""
    widest = max((len(caption) for caption, _ in lines), default=0)
    return widest + 1 if widest else 0


def is_symbol(instruction: Instruction) -> bool:
    """Tell whether an instruction is drawn as a contact or a coil."""
    return instruction.name in SYMBOLS and len(instruction.operands) == 1
