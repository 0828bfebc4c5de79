"""The instruction set: names, operands, kinds; one row per instruction.

Names and order are those of the Logix 5000 general instructions manual; the
second name is the one Studio 5000 prints from revision 36 on. What instructions
do stands in the two back ends; here is what both, the checks and the front ends
need to know of their shape.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto


class Use(Enum):
    """What an instruction wants of an operand, and what it does with it."""

    BIT = auto()
    """Reads a bit."""
    COIL = auto()
    """Writes a bit, true or false: one place in the program may."""
    LATCH = auto()
    """Writes a bit when true."""
    STORAGE = auto()
    """Remembers the rung of the scan before in a bit of its own."""
    NUMBER = auto()
    """Reads a number."""
    TEXT_OR_NUMBER = auto()
    """Reads a number or a STRING."""
    INTEGER = auto()
    """Reads an integer."""
    TARGET = auto()
    """Writes a number."""
    INTEGER_TARGET = auto()
    """Writes an integer."""
    EXPRESSION = auto()
    """Reads an expression."""
    CONDITION = auto()
    """Reads an expression that is true or false."""
    TIMER = auto()
    COUNTER = auto()
    RESETTABLE = auto()
    """A TIMER, COUNTER or CONTROL."""
    PRESET = auto()
    """Number or `?` in an exported rung: initial value of PRE or ACC."""
    SOURCE = auto()
    """First element to copy from."""
    DESTINATION = auto()
    """First element to copy to."""
    CONSTANT = auto()
    """An integer constant."""
    MODE = auto()
    """Byte order of SWPB."""
    LABEL = auto()
    ROUTINE = auto()
    PARAMETERS = auto()
    """Any number of further operands: values in and out of a subroutine."""
    INSTANCE = auto()
    """A tag of an add-on instruction's type."""
    ARGUMENT = auto()
    """What a parameter of an add-on instruction stands for."""


class Kind(Enum):
    """Where in a rung an instruction acts."""

    INPUT = auto()
    """Decides whether the rung is true behind it."""
    OUTPUT = auto()
    """Acts when the rung is true; the rung stays as it is behind it."""
    BOTH = auto()
    """Acts whether the rung is true or false; the rung stays as it is behind it."""


@dataclass(frozen=True, slots=True)
class Spec:
    """Shape of an instruction.

    Attributes:
        name: the name it prints under.
        kind: input or output.
        operands: the use of each operand.
        optional: how many of the last ones may be missing.
        other: its second name, or None.
    """

    name: str
    kind: Kind
    operands: tuple[Use, ...]
    optional: int = 0
    other: str | None = None

    @property
    def variadic(self) -> bool:
        """Takes any number of further operands."""
        return Use.PARAMETERS in self.operands


def _spec(kind: Kind, name: str, *operands: Use, optional: int = 0) -> Spec:
    first, _, other = name.partition("/")
    return Spec(first, kind, operands, optional, other or None)


def _in(name: str, *operands: Use) -> Spec:
    return _spec(Kind.INPUT, name, *operands)


def _out(name: str, *operands: Use, optional: int = 0) -> Spec:
    return _spec(Kind.OUTPUT, name, *operands, optional=optional)


def _both(name: str, *operands: Use, optional: int = 0) -> Spec:
    return _spec(Kind.BOTH, name, *operands, optional=optional)


_COMPARED = (Use.TEXT_OR_NUMBER, Use.TEXT_OR_NUMBER)
_COMPUTED = (Use.NUMBER, Use.NUMBER, Use.TARGET)
_CONVERTED = (Use.NUMBER, Use.TARGET)
_COMBINED = (Use.INTEGER, Use.INTEGER, Use.INTEGER_TARGET)
_TIMED = (Use.TIMER, Use.PRESET, Use.PRESET)
_COUNTED = (Use.COUNTER, Use.PRESET, Use.PRESET)

SPECS = (
    # bit instructions
    _in("XIC", Use.BIT),
    _in("XIO", Use.BIT),
    _both("OTE", Use.COIL),
    _out("OTL", Use.LATCH),
    _out("OTU", Use.LATCH),
    _in("ONS", Use.STORAGE),
    _both("OSR", Use.STORAGE, Use.COIL),
    _both("OSF", Use.STORAGE, Use.COIL),
    # timers and counters
    _both("TON", *_TIMED, optional=2),
    _both("TOF", *_TIMED, optional=2),
    _both("RTO", *_TIMED, optional=2),
    _both("CTU", *_COUNTED, optional=2),
    _both("CTD", *_COUNTED, optional=2),
    _out("RES", Use.RESETTABLE),
    # compare
    _in("CMP", Use.CONDITION),
    _in("EQU/EQ", *_COMPARED),
    _in("GEQ/GE", *_COMPARED),
    _in("GRT/GT", *_COMPARED),
    _in("LEQ/LE", *_COMPARED),
    _in("LES/LT", *_COMPARED),
    _in("LIM/LIMIT", Use.NUMBER, Use.NUMBER, Use.NUMBER),
    _in("MEQ", Use.INTEGER, Use.INTEGER, Use.INTEGER),
    _in("NEQ/NE", *_COMPARED),
    # compute
    _out("CPT", Use.TARGET, Use.EXPRESSION),
    _out("ADD", *_COMPUTED),
    _out("SUB", *_COMPUTED),
    _out("MUL", *_COMPUTED),
    _out("DIV", *_COMPUTED),
    _out("MOD", *_COMPUTED),
    _out("SQR/SQRT", *_CONVERTED),
    _out("NEG", *_CONVERTED),
    _out("ABS", *_CONVERTED),
    # move and logical
    _out("MOV/MOVE", *_CONVERTED),
    _out("MVM", Use.INTEGER, Use.INTEGER, Use.INTEGER_TARGET),
    _out("BTD", Use.INTEGER, Use.CONSTANT, Use.INTEGER_TARGET, Use.CONSTANT, Use.CONSTANT),
    _out("CLR", Use.TARGET),
    _out("SWPB", Use.INTEGER, Use.MODE, Use.INTEGER_TARGET),
    _out("AND", *_COMBINED),
    _out("OR", *_COMBINED),
    _out("XOR", *_COMBINED),
    _out("NOT", Use.INTEGER, Use.INTEGER_TARGET),
    # files
    _out("COP", Use.SOURCE, Use.DESTINATION, Use.INTEGER),
    _out("CPS", Use.SOURCE, Use.DESTINATION, Use.INTEGER),
    _out("FLL", Use.NUMBER, Use.DESTINATION, Use.INTEGER),
    # program control
    _out("JMP", Use.LABEL),
    _in("LBL", Use.LABEL),
    _out("JSR", Use.ROUTINE, Use.CONSTANT, Use.PARAMETERS, optional=1),
    _out("RET", Use.PARAMETERS),
    _in("SBR", Use.PARAMETERS),
    _out("TND"),
    _both("MCR"),
    _in("AFI"),
    _in("NOP"),
    # conversion
    _out("TRN/TRUNC", *_CONVERTED),
)

BY_NAME = {name: spec for spec in SPECS for name in (spec.name, spec.other) if name}
"""Shape by either name, in capitals."""

BYTE_ORDERS = ("REVERSE", "WORD", "HIGH/LOW")
"""Modes of SWPB: DCBA, CDAB, BADC [1756-RM003N, SWPB]; also written 0, 1, 2 and HIGHLOW."""

FUNCTIONS = ("ABS", "SQR", "TRN")
"""Functions in expressions."""

FUNCTION_NAMES = {"ABS": "ABS", "SQR": "SQR", "SQRT": "SQR", "TRN": "TRN", "TRUNC": "TRN"}
"""Functions by any of their names, to the one they print under."""

RELATIONS = ("=", "<>", "<", "<=", ">", ">=")
"""Operators that compare."""

BITWISE = ("AND", "OR", "XOR", "NOT")
"""Operators on bits: computed in integers, even where the rest of the expression is REAL."""
