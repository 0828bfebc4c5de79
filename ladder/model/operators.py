"""Operators and functions of expressions, by the names in the tree."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from scanrack.io_images.dataclass import dataclass

from . import arithmetic
from .arithmetic import decimal, from_decimal, real_decimal, real_from_decimal


@dataclass(frozen=True, slots=True)
class Function:
    """A function in expressions."""

    name: str
    real: Callable[[float], float]  # its value for a REAL or an LREAL, in double precision
    whole: Callable[[int], int] | None = None  # its value for an integer; None if the result is REAL or LREAL
    other: str = ""  # its second name, "" without one
    safe: bool = False  # `real` is finite for finite values
    positive: bool = False  # its value is never negative
    most: int = 0  # its highest value for an integer; 0 = the integer's highest


FUNCTIONS = {
    function.name: function
    for function in (
        Function("ABS", abs, abs, safe=True, positive=True),
        Function("SQR", arithmetic.square_root, arithmetic.integer_root, "SQRT", safe=True, positive=True),
        Function("TRN", arithmetic.real_truncated, int, "TRUNC", safe=True),
        Function("TOD", real_decimal, decimal, "TO_BCD", safe=True, positive=True, most=0x9999_9999),
        Function(
            "FRD", real_from_decimal, from_decimal, "BCD_TO", safe=True, positive=True, most=166_666_665
        ),
        Function("SIN", arithmetic.sine),
        Function("COS", arithmetic.cosine),
        Function("TAN", arithmetic.tangent),
        Function("ASN", arithmetic.arc_sine, other="ASIN"),
        Function("ACS", arithmetic.arc_cosine, other="ACOS"),
        Function("ATN", arithmetic.arc_tangent, other="ATAN"),
        Function("LN", arithmetic.natural_log),
        Function("LOG", arithmetic.common_log),
        Function("DEG", arithmetic.degrees),
        Function("RAD", arithmetic.radians),
    )
}
"""Functions in expressions, by name [1756-RM003N, valid operators]."""

CALLED: dict[str, Callable[..., Any]] = {
    call.__name__: call
    for call in (abs, int, *vars(arithmetic).values())
    if callable(call) and call.__module__ in (arithmetic.__name__, "builtins") and call.__name__[0] != "_"
}
"""Functions that the compiled program calls, by their name in the program."""

FUNCTION_NAMES = {
    name: function.name for function in FUNCTIONS.values() for name in (function.name, function.other) if name
}
"""Canonical name of each function, by each of its names."""

COMPARISONS: Mapping[str, str] = {"EQU": "=", "NEQ": "<>", "LES": "<", "LEQ": "<=", "GRT": ">", "GEQ": ">="}
"""Compare instructions, and their operators."""

RELATIONS = tuple(COMPARISONS.values())

BITWISE = ("AND", "OR", "XOR", "NOT")
"""Bitwise operators, computed in integers even if the rest of the expression is REAL or LREAL."""
