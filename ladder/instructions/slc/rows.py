"""The rows of the SLC dialect, with operands as RSLogix 500 prints them [1747-RM001, 1766-RM001].

PRE, ACC, LEN and POS after a timer or control in a rung show values of the data file. They are used only if
the export has no data for the file; see `rockwell.slc`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from ...interpreter import Interpreter
from ...model.errors import ScanEndedError
from ...model.operand_checks import OperandError
from ...model.operands import Constant, Place, Resolved
from ...model.spec import InstructionKind, Spec, Use, action, always, condition, do_nothing
from ...model.tree import Operand
from ...state.lowered import OperandResolver
from .. import assertion, bits, compare, control, files, move, shifts
from .. import timing as logix_timing
from ..prescans import prescan_sets
from . import files as words
from . import messages, numbers, timing


def _end_scan(_machine: Interpreter, *_operands: Resolved) -> None:
    """Run TND, or SUS, which stops a real processor."""
    raise ScanEndedError


def _one_shot(machine: Interpreter, power: bool, storage: Place, *output: Place) -> bool:
    """Run OSR: on an SLC 500, pass power for one scan; a MicroLogix also has an output bit."""
    rises = power and not machine.get(storage)
    machine.put(storage, power)
    if not output:
        return rises
    machine.put(output[0], rises)
    return power


def _prescan_one_shot(machine: Interpreter, storage: Place, *output: Place) -> None:
    machine.put(storage, True)
    for bit in output:
        machine.put(bit, False)


_SHOWN = (Use.SHOWN, Use.SHOWN)
"""Uses of the operands PRE and ACC, or LEN and POS."""


# --- timers


def _timer(name: str, run: Callable[..., None], prescan: Callable[..., None]) -> Spec:
    """Return the row of a timer; its second operand is a constant time base."""

    def resolve(resolver: OperandResolver, operands: tuple[Operand, ...]) -> tuple[Any, ...]:
        timer = resolver.checked(Use.SLC_TIMER, operands[0])
        base = resolver.value(operands[1])
        if not isinstance(base, Constant) or float(base.value) not in timing.BASES_NS:
            raise OperandError(f"{operands[1]} is not a time base", "write 1.0, 0.01 or 0.001")
        return timer, base

    return Spec(
        name,
        InstructionKind.BOTH,
        (Use.SLC_TIMER, Use.IGNORED, *_SHOWN),
        run=run,
        prescan=prescan,
        resolve=resolve,
        captions=("Timer", "Time base", "Preset", "Accum"),
    )


def _counter(name: str, bit: str, step: int, beyond: str) -> Spec:
    """Return the row of a counter; `bit` stores the rung's state, and `beyond` shows a wrap of ACC."""
    return always(
        name,
        Use.SLC_COUNTER,
        *_SHOWN,
        optional=2,
        run=lambda machine, power, group, *_shown: timing.count(machine, power, group, bit, step, beyond),
        prescan=prescan_sets(0, **{bit: True}),
        captions=("Counter", "Preset", "Accum"),
    )


def _run_with_first(count: int, spec: Spec) -> Callable[..., Any]:
    """Return the executor of a row that uses only its first `count` operands."""
    power_arguments = 1 if spec.kind is InstructionKind.BOTH else 0
    return lambda machine, *arguments: spec.run(machine, *arguments[: power_arguments + count])


def _queue(spec: Spec, *uses: Use) -> Spec:
    """Return the row of a queue instruction as in Logix; its last two operands are only shown."""

    def prescan(machine: Interpreter, *operands: Resolved) -> None:
        assert spec.prescan is not None
        spec.prescan(machine, *operands[:3])

    return always(
        spec.name, *uses, Use.SLC_CONTROL, *_SHOWN, optional=2, run=_run_with_first(3, spec), prescan=prescan
    )


def _file(name: str, *uses: Use, shown: int, run: Callable[..., None]) -> Spec:
    """Return the row of an instruction on a file; its last `shown` operands are only shown."""
    prescan = prescan_sets(uses.index(Use.SLC_CONTROL), EN=True)
    return always(name, *uses, *_SHOWN[:shown], optional=shown, run=run, prescan=prescan)


def _one_source(name: str, function: Callable[[float], float]) -> Spec:
    return action(name, Use.NUMBER, Use.TARGET, run=numbers.one_source(function))


def _log(function: Callable[[float], float]) -> Callable[[float], float]:
    """Return a version of a logarithm that is -inf at 0 and NaN below 0."""

    def log(value: float) -> float:
        if value > 0:
            return function(value)
        return -math.inf if value == 0 else math.nan

    return log


_TWO = (Use.NUMBER, Use.NUMBER, Use.TARGET)
_MASKED = (Use.TABLE, Use.INTEGER)
_LOGIC = (Use.INTEGER, Use.INTEGER, Use.INTEGER_TARGET)

_ROWS: tuple[Spec, ...] = (
    # bits: as in Logix
    *(bits.XIC, bits.XIO, bits.OTE, bits.OTL, bits.OTU, bits.ONS, bits.OSF),
    always("OSR", Use.STORAGE, Use.COIL, optional=1, run=_one_shot, prescan=_prescan_one_shot, decides=True),
    # timers and counters
    _timer("TON", timing.on_delay, prescan_sets(0, EN=False, TT=False, DN=False, ACC=0)),
    _timer("TOF", timing.off_delay, timing.prescan_off_delay),
    _timer("RTO", timing.retentive, prescan_sets(0, EN=False, TT=False)),
    _counter("CTU", "CU", 1, "OV"),
    _counter("CTD", "CD", -1, "UN"),
    action("RES", Use.SLC_RESETTABLE, run=logix_timing.RES.run),
    # comparisons: as in Logix
    *(compare.EQU, compare.NEQ, compare.LES, compare.LEQ, compare.GRT, compare.GEQ, compare.LIM, compare.MEQ),
    compare.CMP,
    # arithmetic
    action("ADD", *_TWO, run=numbers.add),
    action("SUB", *_TWO, run=numbers.subtract),
    action("MUL", *_TWO, run=numbers.multiply),
    action("DIV", *_TWO, run=numbers.divide),
    action("DDV", Use.INTEGER, Use.TARGET, run=numbers.divide_double),
    action("XPY", *_TWO, run=numbers.power),
    action("NEG", Use.NUMBER, Use.TARGET, run=numbers.negate),
    action("CLR", Use.TARGET, run=numbers.clear),
    action("CPT", Use.TARGET, Use.EXPRESSION, run=numbers.compute),
    _one_source("SQR", lambda value: math.sqrt(abs(value))),
    _one_source("ABS", abs),
    _one_source("SIN", math.sin),
    _one_source("COS", math.cos),
    _one_source("TAN", math.tan),
    _one_source("ASN", math.asin),
    _one_source("ACS", math.acos),
    _one_source("ATN", math.atan),
    _one_source("LN", _log(math.log)),
    _one_source("LOG", _log(math.log10)),
    _one_source("DEG", math.degrees),
    _one_source("RAD", math.radians),
    action("SCL", Use.NUMBER, Use.NUMBER, Use.NUMBER, Use.TARGET, run=numbers.scale),
    action("SCP", *[Use.NUMBER] * 5, Use.TARGET, run=numbers.scale_with_parameters),
    # moves and logic
    action("MOV", Use.NUMBER, Use.TARGET, run=numbers.move),
    action("MVM", *_LOGIC, run=numbers.masked_move),
    action("AND", *_LOGIC, run=numbers.logic(lambda a, b: a & b)),
    action("OR", *_LOGIC, run=numbers.logic(lambda a, b: a | b)),
    action("XOR", *_LOGIC, run=numbers.logic(lambda a, b: a ^ b)),
    action("NOT", Use.INTEGER, Use.INTEGER_TARGET, run=numbers.invert),
    action("SWP", Use.ARRAY, Use.INTEGER, run=numbers.swap),
    move.BTD,
    action("TOD", Use.INTEGER, Use.INTEGER_TARGET, run=numbers.to_decimal),
    action("FRD", Use.INTEGER, Use.INTEGER_TARGET, run=numbers.from_decimal),
    action("DCD", Use.INTEGER, Use.INTEGER_TARGET, run=numbers.decode),
    action("ENC", Use.INTEGER, Use.INTEGER_TARGET, run=numbers.encode),
    # files
    files.COP,
    files.FLL,
    _file("BSL", Use.ARRAY, Use.SLC_CONTROL, Use.BIT, shown=1, run=words.shift(True)),
    _file("BSR", Use.ARRAY, Use.SLC_CONTROL, Use.BIT, shown=1, run=words.shift(False)),
    _queue(shifts.FFL, Use.ITEM, Use.ARRAY),
    _queue(shifts.FFU, Use.ARRAY, Use.ITEM_TARGET),
    _queue(shifts.LFL, Use.ITEM, Use.ARRAY),
    _queue(shifts.LFU, Use.ARRAY, Use.ITEM_TARGET),
    _file("SQO", *_MASKED, Use.INTEGER_TARGET, Use.SLC_CONTROL, shown=2, run=words.sequence_output),
    _file("SQC", *_MASKED, Use.INTEGER, Use.SLC_CONTROL, shown=2, run=words.sequence_compare),
    _file("SQL", Use.ARRAY, Use.INTEGER, Use.SLC_CONTROL, shown=2, run=words.sequence_load),
    # program control
    *(control.JMP, control.LBL, control.JSR, control.RET, control.SBR, control.MCR, control.AFI, control.NOP),
    action("TND", run=_end_scan, prove=lambda machine, power: machine.end_scan(power)),
    condition("END", run=lambda _machine: True, alone=True),
    action("SUS", Use.IGNORED, run=_end_scan, prove=lambda machine, power, _: machine.end_scan(power)),
    # no effect: images are exchanged at the ends of a scan, and interrupts do not run
    *(action(name, *[Use.IGNORED] * 3, optional=2, run=do_nothing) for name in ("IIM", "IOM")),
    *(action(name, *[Use.IGNORED] * 2, optional=2, run=do_nothing) for name in ("REF", "STS")),
    *(action(n, Use.IGNORED, optional=1, run=do_nothing) for n in ("STD", "STE", "INT", "UID", "UIE", "UIF")),
    messages.MSG,
    assertion.ASSERT,
)

SLC_SPECS: Mapping[str, Spec] = {row.name: row for row in _ROWS}
