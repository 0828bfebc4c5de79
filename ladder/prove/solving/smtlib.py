"""Writes questions for any solver as SMT-LIB 2.6 text.

(set-logic QF_BVFP) (declare-const |Start[0]@1| Bool) (assert |Start[0]@1|) (check-sat)
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from typing import Any, NamedTuple

from ..algebra.meaning import BOOL, F32, F64
from .translation import FIELDS, Sort


class Text(NamedTuple):
    """The text and the sort of a term."""

    text: str
    sort: Sort


class Script:
    """Writes a script. Terms have names, so a term that is used twice is written only once."""

    def __init__(self) -> None:
        self.lines = ["(set-logic QF_BVFP)"]
        self._names: dict[str, Text] = {}

    def declare(self, sort: Sort, name: str) -> Text:
        """Declare a constant; bars and backslashes in its name become underscores."""
        quoted = "|" + name.replace("|", "_").replace("\\", "_") + "|"
        self.lines.append(f"(declare-const {quoted} {_sort(sort)})")
        return Text(quoted, sort)

    def value(self, sort: Sort, value: Any) -> Text:
        """Return a literal."""
        if isinstance(sort, int):
            return Text(f"(_ bv{value & (1 << sort) - 1} {sort})", sort)
        if sort == BOOL:
            return Text("true" if value else "false", sort)
        return Text(_float(value, sort), sort)

    def apply(self, op: str, args: Sequence[Text | str], indices: Sequence[int] = ()) -> Text:
        """Define a name for the result of an operation, and return it."""
        head = "to_fp" if op == "to_fp_signed" else op
        head = f"(_ {head} {' '.join(map(str, indices))})" if indices else head
        text = f"({head} {' '.join(arg if isinstance(arg, str) else arg.text for arg in args)})"
        named = self._names.get(text)
        if named is None:
            sort = result_sort(op, [operand.sort for operand in args if isinstance(operand, Text)], indices)
            named = self._names[text] = Text(f"t{len(self._names)}", sort)
            self.lines.append(f"(define-fun {named.text} () {_sort(sort)} {text})")
        return named

    def state(self, formula: Text) -> None:
        """Assert a condition."""
        self.lines.append(f"(assert {formula.text})")

    def text(self) -> str:
        """Return the script; its last command is the question."""
        return "\n".join([*self.lines, "(check-sat)", ""])


def result_sort(op: str, sorts: Sequence[Sort], indices: Sequence[int]) -> Sort:
    """Return the sort of an operation's result, given its operands' sorts without a rounding mode."""
    match op:
        case "ite":
            return sorts[1]
        case "sign_extend" | "zero_extend":
            return int(sorts[0]) + indices[0]
        case "extract":
            return indices[0] - indices[1] + 1
        case "fp.to_sbv":
            return indices[0]
        case "to_fp" | "to_fp_signed":
            return F32 if tuple(indices) == FIELDS[F32] else F64
    return sorts[0] if op in _KEEPING else BOOL


_WORDS = frozenset(["bvadd", "bvsub", "bvmul", "bvsdiv", "bvsrem", "bvand", "bvor", "bvxor"])
_KEEPING = _WORDS | {"fp.add", "fp.sub", "fp.mul", "fp.div", "fp.neg", "fp.abs", "fp.sqrt", "fp.rem"}
"""Operations whose result has the same sort as their operands."""


def _sort(sort: Sort) -> str:
    """Return a sort as SMT-LIB writes it."""
    if sort == BOOL:
        return "Bool"
    if isinstance(sort, int):
        return f"(_ BitVec {sort})"
    return "(_ FloatingPoint {} {})".format(*FIELDS[sort])


def pattern_of(value: float, sort: Sort) -> str:
    """Return the bits of a float as digits, sign first.

    >>> pattern_of(-2.0, F32)
    '11000000000000000000000000000000'
    """
    packed = struct.pack(">f" if sort == F32 else ">d", value)
    return f"{int.from_bytes(packed):0{8 * len(packed)}b}"


def _float(value: float, sort: Sort) -> str:
    """Return a float as SMT-LIB writes it: NaN, or the bits of sign, exponent and significand."""
    exponent, significand = FIELDS[str(sort)]
    if math.isnan(value):
        return f"(_ NaN {exponent} {significand})"
    bits = pattern_of(value, sort)
    return f"(fp #b{bits[0]} #b{bits[1 : exponent + 1]} #b{bits[exponent + 1 :]})"
