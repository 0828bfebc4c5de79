"""Compare instructions."""

from __future__ import annotations

from ..compiler.rungs import RungWriter
from ..interpreter import Interpreter
from ..model.operand_checks import OperandError, described, is_string
from ..model.operands import Constant, Resolved, can_fault, width_of
from ..model.spec import Spec, Use, condition
from ..model.types import LINT


def _check_same_kind(a: Resolved, b: Resolved) -> None:
    if is_string(a) != is_string(b):
        raise OperandError(f"{described(a)} and {described(b)} can't be compared", "compare like with like")


def _comparison(name: str, relation: str) -> Spec:
    """Return the row of an instruction that compares two numbers or two strings."""
    return condition(
        name,
        Use.TEXT_OR_NUMBER,
        Use.TEXT_OR_NUMBER,
        check=_check_same_kind,
        run=lambda machine, a, b: machine.compare(relation, a, b),
        write=lambda rungs, a, b: rungs.values.comparison(relation, a, b),
        captions=("Source A", "Source B"),
    )


# --- LIM: within both limits, or outside if the low limit is above the high limit


def _lim(machine: Interpreter, low: Resolved, test: Resolved, high: Resolved) -> bool:
    """Return whether a number is within the limits, or outside them if `low` is above `high`."""
    width = width_of(low, test, high)
    least, value, most = (machine.number(operand, width) for operand in (low, test, high))
    if least <= most:
        return least <= value <= most
    return value >= least or value <= most


def _write_lim(rungs: RungWriter, low: Resolved, test: Resolved, high: Resolved) -> str:
    """Return code for LIM; if an operand can fault, first read all operands into variables."""
    width = width_of(low, test, high)
    texts = [rungs.values.term(operand, width).text for operand in (low, test, high)]
    if not _lim_is_inline(low, test, high):
        texts = [rungs.values.keep(text) for text in texts]
    least, value, most = texts
    if isinstance(low, Constant) and isinstance(high, Constant) and low.value <= high.value:
        return f"({least} <= {value} <= {most})"
    return f"({least} <= {value} <= {most} if {least} <= {most} else {value} >= {least} or {value} <= {most})"


def _lim_is_inline(*operands: Resolved) -> bool:
    """Return whether no operand can fault. LIM reads all operands, but Python's `a <= b <= c` can skip c."""
    return not any(map(can_fault, operands))


# --- MEQ: equal in the bits of the mask


def _meq(machine: Interpreter, source: Resolved, mask: Resolved, compare: Resolved) -> bool:
    different = machine.filled(source) ^ machine.filled(compare)
    return different & machine.filled(mask) == 0


def _write_meq(rungs: RungWriter, source: Resolved, mask: Resolved, compare: Resolved) -> str:
    source_bits, mask_bits, compare_bits = (
        rungs.values.filled(operand, LINT.bits) for operand in (source, mask, compare)
    )
    return f"(({source_bits} ^ {compare_bits}) & {mask_bits} == 0)"


# --- the rows

CMP = condition(
    "CMP",
    Use.CONDITION,
    run=lambda machine, expression: machine.condition(expression),
    write=lambda rungs, expression: rungs.values.condition(expression),
    captions=("Expression",),
)
EQU = _comparison("EQU/EQ", "=")
GEQ = _comparison("GEQ/GE", ">=")
GRT = _comparison("GRT/GT", ">")
LEQ = _comparison("LEQ/LE", "<=")
LES = _comparison("LES/LT", "<")
LIM = condition(
    "LIM/LIMIT",
    Use.NUMBER,
    Use.NUMBER,
    Use.NUMBER,
    run=_lim,
    write=_write_lim,
    inline=_lim_is_inline,
    captions=("Low", "Test", "High"),
)
MEQ = condition(
    "MEQ",
    Use.INTEGER,
    Use.INTEGER,
    Use.INTEGER,
    run=_meq,
    write=_write_meq,
    captions=("Source", "Mask", "Compare"),
)
NEQ = _comparison("NEQ/NE", "<>")

ISINF = condition(
    "ISINF",
    Use.NUMBER,
    run=lambda machine, source: machine.is_infinite(machine.number(source, width_of(source))),
)
ISNAN = condition(
    "ISNAN", Use.NUMBER, run=lambda machine, source: machine.is_nan(machine.number(source, width_of(source)))
)
