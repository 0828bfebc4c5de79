"""Instructions on numbers: compare, compute, move, logical."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from ..interpreter import width_of
from ..operands import Constant, Place, Resolved, can_fault
from ..types import LINT
from .values import Term

if TYPE_CHECKING:
    from .steps import RungWriter


def lim(rungs: RungWriter, low: Resolved, test: Resolved, high: Resolved) -> str:
    """LIM: inside of both limits, or outside if the low one is above the high one."""
    width = width_of(low, test, high)
    texts = [rungs.values.term(each, width).text for each in (low, test, high)]
    if any(map(can_fault, (low, test, high))):
        texts = [rungs.values.keep(text) for text in texts]
    least, value, most = texts
    if isinstance(low, Constant) and isinstance(high, Constant) and low.value <= high.value:
        return f"({least} <= {value} <= {most})"
    return f"({least} <= {value} <= {most} if {least} <= {most} else {value} >= {least} or {value} <= {most})"


def meq(rungs: RungWriter, source: Resolved, mask: Resolved, compare: Resolved) -> str:
    """MEQ: equal where the mask has ones."""
    texts = [rungs.values.filled(each, LINT.bits) for each in (source, mask, compare)]
    return f"(({texts[0]} ^ {texts[2]}) & {texts[1]} == 0)"


def _compute(rungs: RungWriter, name: str, operands: tuple[Resolved, ...], target: Place) -> None:
    rungs.values.before()
    width = width_of(*operands, target)
    if rungs.writer.flags and width and name in ("+", "-", "NEG"):
        _carry(rungs, name, operands, width)
    terms = [rungs.values.term(each, width) for each in operands]
    operation = rungs.values.operation if width else rungs.values.real_operation
    term = operation(name, terms)
    rungs.values.store(target, term, width)


def _carry(rungs: RungWriter, name: str, operands: tuple[Resolved, ...], width: int) -> None:
    mask = (1 << width) - 1
    texts = [f"({rungs.values.term(each, width).text} & {mask})" for each in operands]
    rungs.values.set_flag(
        "S:C",
        {
            "+": f"{texts[0]} + {texts[-1]} > {mask}",
            "-": f"{texts[0]} < {texts[-1]}",
            "NEG": f"{texts[0]} != 0",
        }[name],
    )


def cpt(rungs: RungWriter, target: Place, expression: Resolved) -> None:
    """CPT: an expression into a tag."""
    rungs.values.before()
    width = width_of(expression, target)
    rungs.values.store(target, rungs.values.term(expression, width), 0 if width == 0 else LINT.bits)


def sqr(rungs: RungWriter, source: Resolved, target: Place) -> None:
    """SQR: the square root."""
    _compute(rungs, "SQR", (source,), target)


def mov(rungs: RungWriter, source: Resolved, target: Place) -> None:
    """MOV: a value into a tag."""
    rungs.values.before()
    rungs.values.store(target, rungs.values.term(source, width_of(source)), LINT.bits)


def trn(rungs: RungWriter, source: Resolved, target: Place) -> None:
    """TRN: a REAL cut off."""
    rungs.values.before()
    term = rungs.values.term(source, width_of(source))
    if term.real:
        term = Term(f"cut({rungs.values.site}, {term.text})", -(1 << 200), 1 << 200)
    _store_wide(rungs, target, term)


def _store_wide(rungs: RungWriter, target: Place, term: Term) -> None:
    """Store an integer that may have any width."""
    kind = target.type
    if kind.is_real or term.fits(LINT.bits):
        rungs.values.store(target, term, LINT.bits)
        return
    value = rungs.values.keep(term.text)
    otherwise = f"narrow({rungs.values.site}, {value}, 256, {kind.bits})"
    text = f"{value} if {kind.lowest} <= {value} <= {kind.highest} else {otherwise}"
    rungs.values.assign(target, text)
    if rungs.writer.flags:
        rungs.values.result_flags(target)


def clr(rungs: RungWriter, target: Place) -> None:
    """CLR: zero."""
    rungs.values.before()
    rungs.values.assign(target, repr(target.type.zero))
    if rungs.writer.flags:
        rungs.values.set_flag("S:Z", "True")
        rungs.values.set_flag("S:N", "False")


def _combined(rungs: RungWriter, target: Place, text: str, *, direct: bool) -> None:
    rungs.values.before()
    rungs.values.assign(target, text if direct else f"wrap({text}, {target.type.bits})")
    if rungs.writer.flags:
        rungs.values.result_flags(target)


def _combine(rungs: RungWriter, sign: str, a: Resolved, b: Resolved, target: Place) -> None:
    bits = target.type.bits
    texts = [rungs.values.filled(each, bits) for each in (a, b)]
    direct = all(_bits(each) == bits for each in (a, b))
    _combined(rungs, target, f"{texts[0]} {sign} {texts[1]}", direct=direct)


def invert(rungs: RungWriter, source: Resolved, target: Place) -> None:
    """NOT: every bit inverted."""
    bits = target.type.bits
    _combined(rungs, target, f"~{rungs.values.filled(source, bits)}", direct=_bits(source) == bits)


def mvm(rungs: RungWriter, source: Resolved, mask: Resolved, target: Place) -> None:
    """MVM: the bits where the mask has ones."""
    bits = target.type.bits
    moved, through = rungs.values.filled(source, bits), rungs.values.filled(mask, bits)
    direct = _bits(source) == _bits(mask) == bits
    text = f"{rungs.values.read(target)} & ~{through} | {moved} & {through}"
    _combined(rungs, target, text, direct=direct)


def btd(
    rungs: RungWriter,
    source: Resolved,
    source_bit: Constant,
    target: Place,
    target_bit: Constant,
    length: Constant,
) -> None:
    """BTD: a field of bits into another place."""
    moved = rungs.values.filled(source, LINT.bits)
    rungs.values.assign(
        target,
        f"distributed({moved}, {source_bit.value}, {rungs.values.read(target)}, "
        f"{target_bit.value}, {length.value}, {target.type.bits})",
    )


def swpb(rungs: RungWriter, source: Place, mode: str, target: Place) -> None:
    """SWPB: bytes in another order."""
    rungs.values.assign(target, f"swapped({rungs.values.read(source)}, {source.type.bits}, {mode!r})")


def _bits(operand: Resolved) -> int:
    assert isinstance(operand, (Place, Constant))
    return operand.type.bits


def comparing(relation: str) -> Callable[..., str]:
    """Return what writes a comparison of two operands."""
    return lambda rungs, a, b: rungs.values.comparison(relation, a, b)


def computing(operator: str) -> Callable[..., None]:
    """Return what writes a computation on all operands but the last, into that one."""
    return lambda rungs, *operands: _compute(rungs, operator, operands[:-1], operands[-1])


def combining(sign: str) -> Callable[..., None]:
    """Return what writes an operation on bits."""
    return lambda rungs, a, b, target: _combine(rungs, sign, a, b, target)
