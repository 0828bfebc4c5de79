"""The operators and functions of expressions, by the names that the tree uses."""

from __future__ import annotations

FUNCTIONS = ("ABS", "SQR", "TRN")
"""Functions in expressions whose result has the type of the operand."""

REAL_FUNCTIONS = {
    "SIN": "sine",
    "COS": "cosine",
    "TAN": "tangent",
    "ASN": "arc_sine",
    "ACS": "arc_cosine",
    "ATN": "arc_tangent",
    "LN": "natural_log",
    "LOG": "common_log",
    "DEG": "degrees",
    "RAD": "radians",
}
"""Functions whose result is REAL, each with its name in `arithmetic`."""

_SECOND_NAMES = {"SQRT": "SQR", "TRUNC": "TRN", "ASIN": "ASN", "ACOS": "ACS", "ATAN": "ATN"}

FUNCTION_NAMES = {name: name for name in (*FUNCTIONS, *REAL_FUNCTIONS)} | _SECOND_NAMES
"""Functions by any of their names, to the one they print under."""

RELATIONS = ("=", "<>", "<", "<=", ">", ">=")
"""Operators that compare."""

BITWISE = ("AND", "OR", "XOR", "NOT")
"""Operators on bits: computed in integers, even where the rest of the expression is REAL."""
