"""Move and logical instructions."""

from __future__ import annotations

from collections.abc import Callable

from ..compiler.rungs import RungWriter
from ..interpreter import Interpreter
from ..model import arithmetic
from ..model.operand_checks import OperandError, described, is_string
from ..model.operands import Constant, Group, Place, Resolved, width_moved
from ..model.spec import Spec, Use, action
from ..model.types import LINT
from .compute import ASSIGNED, BINARY, SOURCE_DEST, UNARY
from .statements import set_text, write_set_text


def _check_mov(source: Resolved, target: Resolved) -> None:
    if is_string(source) != is_string(target):
        text = f"{described(source)} can't be moved to {described(target)}"
        raise OperandError(text, "convert it, as DTOS does")


def _mov(machine: Interpreter, source: Resolved, target: Place | Group) -> None:
    """Copy text to a string, or a number to a tag."""
    if isinstance(target, Group):
        set_text(machine, target, source)
        return
    machine.clear_flags()
    machine.store(target, machine.number(source, width_moved(source, target.type)))


def _write_mov(rungs: RungWriter, source: Resolved, target: Place | Group) -> None:
    """Write code equivalent to `_mov`."""
    if isinstance(target, Group):
        write_set_text(rungs, target, source)
        return
    rungs.values.clear_flags()
    rungs.values.store(target, rungs.values.term(source, width_moved(source, target.type)), LINT.bits)


# --- MVM: move the bits of the mask


def _mvm(machine: Interpreter, source: Resolved, mask: Resolved, target: Place) -> None:
    old_value, mask_bits = machine.whole(machine.get(target)), machine.filled(mask)
    machine.store_bits(target, old_value & ~mask_bits | machine.filled(source) & mask_bits)


def _write_mvm(rungs: RungWriter, source: Resolved, mask: Resolved, target: Place) -> None:
    """Write code equivalent to `_mvm`."""
    bits = target.type.bits
    moved, through = rungs.values.filled(source, bits), rungs.values.filled(mask, bits)
    direct = _bits(source) == _bits(mask) == bits
    text = f"{rungs.values.read(target)} & ~{through} | {moved} & {through}"
    rungs.values.store_bits(target, text, direct=direct)


def _bits(operand: Resolved) -> int:
    """Return an integer operand's width, negative if it is unsigned."""
    assert isinstance(operand, (Place, Constant))
    return operand.type.wraps


# --- BTD: copy a field of bits to another position


def _check_btd(
    source: Resolved, source_bit: Constant, target: Place, target_bit: Constant, length: Constant
) -> None:
    """Raise an OperandError if the position or length of the bit field is invalid."""
    limits = (
        (source_bit, 0, source.type.bits - 1 if isinstance(source, (Place, Constant)) else 31, "source bit"),
        (target_bit, 0, target.type.bits - 1, "destination bit"),
        (length, 1, target.type.bits, "length"),
    )
    for operand, low, high, name in limits:
        if not low <= operand.value <= high:
            raise OperandError(f"{name} {operand.value} is out of range", f"must be {low} to {high}")


def _btd(
    machine: Interpreter,
    source: Resolved,
    source_bit: Constant,
    target: Place,
    target_bit: Constant,
    length: Constant,
) -> None:
    """Replace `length` bits of the target by bits of the source."""
    value = arithmetic.distributed(
        machine.filled(source),
        source_bit=int(source_bit.value),
        target=machine.whole(machine.get(target)),
        target_bit=int(target_bit.value),
        length=int(length.value),
        bits=target.type.wraps,
    )
    machine.put(target, value)


def _write_btd(
    rungs: RungWriter,
    source: Resolved,
    source_bit: Constant,
    target: Place,
    target_bit: Constant,
    length: Constant,
) -> None:
    """Write code equivalent to `_btd`."""
    moved = rungs.values.filled(source, LINT.bits)
    rungs.values.assign(
        target,
        f"distributed({moved}, {source_bit.value}, {rungs.values.read(target)}, "
        f"{target_bit.value}, {length.value}, {target.type.wraps})",
    )


# --- CLR: zero


def _clr(machine: Interpreter, target: Place) -> None:
    machine.clear_flags()
    machine.put(target, target.type.zero)
    machine.set_flags(0)


def _write_clr(rungs: RungWriter, target: Place) -> None:
    """Write code equivalent to `_clr`."""
    rungs.values.clear_flags()
    rungs.values.assign(target, repr(target.type.zero))
    if rungs.writer.flags:
        rungs.values.set_flag("S:Z", "True")
        rungs.values.set_flag("S:N", "False")


# --- SWPB: reorder bytes


def _check_swpb(source: Resolved, _mode: str, target: Place) -> None:
    """Raise an OperandError unless SWPB allows the pair of types."""
    allowed = {("INT", "INT"), ("INT", "DINT"), ("DINT", "DINT")}
    if not isinstance(source, Place) or (source.type.name, target.type.name) not in allowed:
        raise OperandError(
            f"SWPB does not go from {described(source)} to {described(target)}",
            "must be INT to INT or DINT, or DINT to DINT",
        )


def _swpb(machine: Interpreter, source: Place, mode: str, target: Place) -> None:
    machine.put(target, arithmetic.swapped(machine.whole(machine.get(source)), source.type.bits, mode))


def _write_swpb(rungs: RungWriter, source: Place, mode: str, target: Place) -> None:
    rungs.values.assign(target, f"swapped({rungs.values.read(source)}, {source.type.bits}, {mode!r})")


# --- AND, OR, XOR, NOT: narrow operands are zero-extended


def _combination(name: str, sign: str, combine: Callable[[int, int], int]) -> Spec:
    """Return the row of a bitwise instruction; `sign` is its operator in compiled code."""

    def run(machine: Interpreter, a: Resolved, b: Resolved, target: Place) -> None:
        machine.store_bits(target, combine(machine.filled(a), machine.filled(b)))

    def write(rungs: RungWriter, a: Resolved, b: Resolved, target: Place) -> None:
        bits = target.type.bits
        a_bits, b_bits = rungs.values.filled(a, bits), rungs.values.filled(b, bits)
        direct = _bits(a) == _bits(b) == bits
        rungs.values.store_bits(target, f"{a_bits} {sign} {b_bits}", direct=direct)

    return action(name, Use.INTEGER, Use.INTEGER, Use.INTEGER_TARGET, run=run, write=write, **BINARY)


def _write_not(rungs: RungWriter, source: Resolved, target: Place) -> None:
    bits = target.type.bits
    rungs.values.store_bits(target, f"~{rungs.values.filled(source, bits)}", direct=_bits(source) == bits)


# --- the rows

MOV = action(
    "MOV/MOVE",
    Use.TEXT_OR_NUMBER,
    Use.TEXT_OR_NUMBER_TARGET,
    check=_check_mov,
    run=_mov,
    write=_write_mov,
    **SOURCE_DEST,
)
MVM = action(
    "MVM",
    Use.INTEGER,
    Use.INTEGER,
    Use.INTEGER_TARGET,
    run=_mvm,
    write=_write_mvm,
    captions=("Source", "Mask", "Dest"),
    instead=ASSIGNED,
)
BTD = action(
    "BTD",
    Use.INTEGER,
    Use.CONSTANT,
    Use.INTEGER_TARGET,
    Use.CONSTANT,
    Use.CONSTANT,
    check=_check_btd,
    run=_btd,
    write=_write_btd,
    captions=("Source", "Source bit", "Dest", "Dest bit", "Length"),
    instead="assign the bits one by one",
)
CLR = action("CLR", Use.TARGET, run=_clr, write=_write_clr, captions=("Dest",), instead=ASSIGNED)
SWPB = action(
    "SWPB",
    Use.INTEGER,
    Use.MODE,
    Use.INTEGER_TARGET,
    check=_check_swpb,
    run=_swpb,
    write=_write_swpb,
    captions=("Source", "Order", "Dest"),
)
AND = _combination("AND", "&", lambda a, b: a & b)
OR = _combination("OR", "|", lambda a, b: a | b)
XOR = _combination("XOR", "^", lambda a, b: a ^ b)
NOT = action(
    "NOT",
    Use.INTEGER,
    Use.INTEGER_TARGET,
    run=lambda machine, source, target: machine.store_bits(target, ~machine.filled(source)),
    write=_write_not,
    **UNARY,
)
