"""Timers, counter and one-shots of structured text, whose parameters are members of a structure.

In structured text, which replaces TON, TOF, RTO, CTU, CTD, OSR and OSF by these, an instruction always runs:
its input is a member (TimerEnable, CUEnable, InputBit) that a statement before it sets.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ..compiler.rungs import RungWriter
from ..interpreter import Interpreter
from ..model import arithmetic
from ..model.operand_checks import OperandError, described
from ..model.operands import Group
from ..model.spec import Spec, Use, action
from ..model.types import DINT, FBD_COUNTER, FBD_ONESHOT, FBD_TIMER, Structure
from . import timing


def _takes(kind: Structure) -> Callable[[Group], None]:
    def check(block: Group) -> None:
        if block.type is not kind:
            raise OperandError(
                f"{block.text} is {described(block)}, a {kind.name} is needed", f"declare it as {kind.name}"
            )

    return check


def _get(machine: Interpreter, block: Group, name: str) -> bool:
    return bool(machine.get(block.member(name)))


def _put(machine: Interpreter, block: Group, **values: bool | int) -> None:
    for name, value in values.items():
        machine.put(block.member(name), value)


def _write_get(rungs: RungWriter, block: Group, name: str) -> str:
    return rungs.values.read(block.member(name))


def _write_put(rungs: RungWriter, block: Group, **texts: str | bool | int) -> None:
    for name, text in texts.items():
        rungs.values.assign(block.member(name), str(text))


# --- timers: TON, TOF and RTO with TimerEnable for the rung, and Reset; a negative PRE sets fault bits

_INVALID: Mapping[str, bool | int] = {"InstructFault": True, "PresetInv": True, "Status": 3}
_VALID: Mapping[str, bool | int] = {"InstructFault": False, "PresetInv": False, "Status": 0}
_OFF: Mapping[str, bool] = {"EN": False, "TT": False, "DN": False}


def _timer(name: str, of_rungs: Spec, *, full: bool = False) -> Spec:
    """Return a timer block; `full`: a reset sets ACC to PRE instead of 0."""

    def run(machine: Interpreter, timer: Group) -> None:
        _put(machine, timer, EnableOut=True)
        if int(machine.get(timer.member("PRE"))) < 0:
            _put(machine, timer, **_INVALID)
            return
        _put(machine, timer, **_VALID)
        if _get(machine, timer, "Reset"):
            reset(machine, timer)
        else:
            of_rungs.run(machine, _get(machine, timer, "TimerEnable"), timer)

    def reset(machine: Interpreter, timer: Group) -> None:
        _put(machine, timer, **_OFF)
        machine.put(timer.member("ACC"), machine.get(timer.member("PRE")) if full else 0)

    def write(rungs: RungWriter, timer: Group) -> None:
        assert of_rungs.write is not None
        _write_put(rungs, timer, EnableOut=True)
        with rungs.writer.block(f"if {_write_get(rungs, timer, 'PRE')} < 0:"):
            _write_put(rungs, timer, **_INVALID)
        with rungs.writer.block("else:"):
            _write_put(rungs, timer, **_VALID)
            with rungs.writer.block(f"if {_write_get(rungs, timer, 'Reset')}:"):
                _write_put(rungs, timer, **_OFF)
                _write_put(rungs, timer, ACC=_write_get(rungs, timer, "PRE") if full else 0)
            with rungs.writer.block("else:"):
                of_rungs.write(rungs, _write_get(rungs, timer, "TimerEnable"), timer)

    return action(
        name,
        Use.BLOCK,
        run=run,
        write=write,
        prescan=of_rungs.prescan,
        check=_takes(FBD_TIMER),
        in_rungs=False,
    )


# --- CTUD: counts up on a rising CUEnable, down on a rising CDEnable, not at all on both

_CLEARED = {"CU": False, "CD": False, "DN": False, "OV": False, "UN": False, "ACC": 0}


def _ctud(machine: Interpreter, counter: Group) -> None:
    up, down = _get(machine, counter, "CUEnable"), _get(machine, counter, "CDEnable")
    rises = up and not _get(machine, counter, "~up")
    falls = down and not _get(machine, counter, "~down")
    _put(machine, counter, **{"EnableOut": True, "~up": up, "~down": down})
    if _get(machine, counter, "Reset"):
        _put(machine, counter, **_CLEARED)
        return
    _put(machine, counter, CU=up, CD=down)
    if rises != falls:
        _count(machine, counter, 1 if rises else -1)
    over, under = _get(machine, counter, "OV"), _get(machine, counter, "UN")
    reached = machine.get(counter.member("ACC")) >= machine.get(counter.member("PRE"))
    _put(machine, counter, DN=over or (reached and not under))


def _count(machine: Interpreter, counter: Group, by: int) -> None:
    exact = int(machine.get(counter.member("ACC"))) + by
    counted = arithmetic.wrap(exact, DINT.bits)
    _put(machine, counter, ACC=counted)
    if counted != exact:
        beyond, back = ("OV", "UN") if by > 0 else ("UN", "OV")
        if _get(machine, counter, back):
            _put(machine, counter, **{back: False})
        else:
            _put(machine, counter, **{beyond: True})


def _write_ctud(rungs: RungWriter, counter: Group) -> None:
    keep = rungs.values.keep
    up, down = (keep(_write_get(rungs, counter, name)) for name in ("CUEnable", "CDEnable"))
    rises = keep(f"{up} and not {_write_get(rungs, counter, '~up')}")
    falls = keep(f"{down} and not {_write_get(rungs, counter, '~down')}")
    _write_put(rungs, counter, EnableOut=True)
    _write_put(rungs, counter, **{"~up": up, "~down": down})
    with rungs.writer.block(f"if {_write_get(rungs, counter, 'Reset')}:"):
        _write_put(rungs, counter, **_CLEARED)
    with rungs.writer.block("else:"):
        _write_put(rungs, counter, CU=up, CD=down)
        with rungs.writer.block(f"if {rises} and not {falls}:"):
            _write_count(rungs, counter, "+ 1", DINT.highest, DINT.lowest, "OV", "UN")
        with rungs.writer.block(f"if {falls} and not {rises}:"):
            _write_count(rungs, counter, "- 1", DINT.lowest, DINT.highest, "UN", "OV")
        over, under = _write_get(rungs, counter, "OV"), _write_get(rungs, counter, "UN")
        reached = f"{_write_get(rungs, counter, 'ACC')} >= {_write_get(rungs, counter, 'PRE')}"
        _write_put(rungs, counter, DN=f"{over} or {reached} and not {under}")


def _write_count(
    rungs: RungWriter, counter: Group, step: str, last: int, wrapped: int, beyond: str, back: str
) -> None:
    accumulated = _write_get(rungs, counter, "ACC")
    with rungs.writer.block(f"if {accumulated} != {last}:"):
        _write_put(rungs, counter, ACC=f"{accumulated} {step}")
    with rungs.writer.block("else:"):
        _write_put(rungs, counter, ACC=wrapped)
        with rungs.writer.block(f"if {_write_get(rungs, counter, back)}:"):
            _write_put(rungs, counter, **{back: False})
        with rungs.writer.block("else:"):
            _write_put(rungs, counter, **{beyond: True})


# --- one-shots: OutputBit is true in the scan in which InputBit becomes true (OSRI) or false (OSFI)


def _one_shot(name: str, *, rising: bool) -> Spec:
    def run(machine: Interpreter, shot: Group) -> None:
        now, before = _get(machine, shot, "InputBit"), _get(machine, shot, "~before")
        fires = now and not before if rising else before and not now
        _put(machine, shot, **{"EnableOut": True, "OutputBit": fires, "~before": now})

    def write(rungs: RungWriter, shot: Group) -> None:
        now, before = _write_get(rungs, shot, "InputBit"), _write_get(rungs, shot, "~before")
        fires = f"{now} and not {before}" if rising else f"{before} and not {now}"
        _write_put(rungs, shot, EnableOut=True)
        _write_put(rungs, shot, **{"OutputBit": fires, "~before": now})

    return action(
        name,
        Use.BLOCK,
        run=run,
        write=write,
        prescan=lambda machine, shot: _put(machine, shot, **{"OutputBit": False, "~before": rising}),
        check=_takes(FBD_ONESHOT),
        in_rungs=False,
    )


# --- the rows

TONR = _timer("TONR", timing.TON)
TOFR = _timer("TOFR", timing.TOF, full=True)
RTOR = _timer("RTOR", timing.RTO)
CTUD = action(
    "CTUD",
    Use.BLOCK,
    run=_ctud,
    write=_write_ctud,
    prescan=lambda machine, counter: _put(machine, counter, **{"~up": True, "~down": True}),
    check=_takes(FBD_COUNTER),
    in_rungs=False,
)
OSRI = _one_shot("OSRI", rising=True)
OSFI = _one_shot("OSFI", rising=False)
