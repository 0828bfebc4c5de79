"""The operators and functions of expressions, by the names that the tree uses."""

from __future__ import annotations

FUNCTIONS = ("ABS", "SQR", "TRN")
"""Functions in expressions."""

FUNCTION_NAMES = {"ABS": "ABS", "SQR": "SQR", "SQRT": "SQR", "TRN": "TRN", "TRUNC": "TRN"}
"""Functions by any of their names, to the one they print under."""

RELATIONS = ("=", "<>", "<", "<=", ">", ">=")
"""Operators that compare."""

BITWISE = ("AND", "OR", "XOR", "NOT")
"""Operators on bits: computed in integers, even where the rest of the expression is REAL."""
