"""Timers, a counter and one-shots for structured text; their parameters are members of a structure.

They replace TON, TOF, RTO, CTU, CTD, OSR and OSF in structured text. They act on every call. An earlier
statement sets the input, which is a member: TimerEnable, CUEnable or InputBit.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from ..compiler.rungs import RungWriter
from ..interpreter import Interpreter
from ..model.operand_checks import require_type
from ..model.operands import Group
from ..model.spec import Spec, Use, action
from ..model.types import FBD_COUNTER, FBD_ONESHOT, FBD_TIMER, Structure
from . import timing
from .prescans import prescan_sets
from .timing import one_count, put, put_done, write_done, write_get, write_one_count, write_set


def _block(name: str, kind: Structure, **parts: Any) -> Spec:
    return action(name, Use.BLOCK, check=partial(require_type, kind=kind), in_rungs=False, **parts)


def _get(machine: Interpreter, block: Group, name: str) -> bool:
    return machine.truth(machine.get(block.member(name)))


# --- timers: TimerEnable replaces the rung of TON, TOF and RTO; a negative PRE sets fault bits

_INVALID: Mapping[str, bool | int] = {"InstructFault": True, "PresetInv": True, "Status": 3}
_VALID: Mapping[str, bool | int] = {"InstructFault": False, "PresetInv": False, "Status": 0}
_OFF: Mapping[str, bool] = {"EN": False, "TT": False, "DN": False}


def _timer(name: str, of_rungs: Spec, *, full: bool = False) -> Spec:
    """Return the row of a timer block; with `full`, a reset sets ACC to PRE instead of 0."""

    def run(machine: Interpreter, timer: Group) -> None:
        put(machine, timer, EnableOut=True)
        if machine.whole(machine.get(timer.member("PRE"))) < 0:
            put(machine, timer, **_INVALID)
            return
        put(machine, timer, **_VALID)
        if _get(machine, timer, "Reset"):
            reset(machine, timer)
        else:
            of_rungs.run(machine, _get(machine, timer, "TimerEnable"), timer)

    def reset(machine: Interpreter, timer: Group) -> None:
        put(machine, timer, **_OFF)
        machine.put(timer.member("ACC"), machine.get(timer.member("PRE")) if full else 0)

    def write(rungs: RungWriter, timer: Group) -> None:
        assert of_rungs.write is not None
        write_set(rungs, timer, EnableOut=True)
        with rungs.writer.block(f"if {write_get(rungs, timer, 'PRE')} < 0:"):
            write_set(rungs, timer, **_INVALID)
        with rungs.writer.block("else:"):
            write_set(rungs, timer, **_VALID)
            with rungs.writer.block(f"if {write_get(rungs, timer, 'Reset')}:"):
                write_set(rungs, timer, **_OFF)
                write_set(rungs, timer, ACC=write_get(rungs, timer, "PRE") if full else 0)
            with rungs.writer.block("else:"):
                of_rungs.write(rungs, write_get(rungs, timer, "TimerEnable"), timer)

    return _block(name, FBD_TIMER, run=run, write=write, prescan=of_rungs.prescan)


# --- CTUD: counts up on a rising CUEnable, and down on a rising CDEnable; if both rise, it does not count

_CLEARED = {"CU": False, "CD": False, "DN": False, "OV": False, "UN": False, "ACC": 0}


def _ctud(machine: Interpreter, counter: Group) -> None:
    """Count when exactly one of the enables rises; a reset clears the counter instead."""
    up, down = _get(machine, counter, "CUEnable"), _get(machine, counter, "CDEnable")
    counts_up = up and not _get(machine, counter, "~up")
    counts_down = down and not _get(machine, counter, "~down")
    put(machine, counter, **{"EnableOut": True, "~up": up, "~down": down})
    if _get(machine, counter, "Reset"):
        put(machine, counter, **_CLEARED)
        return
    put(machine, counter, CU=up, CD=down)
    if counts_up != counts_down:
        one_count(machine, counter, 1 if counts_up else -1)
    put_done(machine, counter)


def _write_ctud(rungs: RungWriter, counter: Group) -> None:
    """Write code that does the same as `_ctud`."""
    keep = rungs.values.keep
    up, down = (keep(write_get(rungs, counter, name)) for name in ("CUEnable", "CDEnable"))
    counts_up = keep(f"{up} and not {write_get(rungs, counter, '~up')}")
    counts_down = keep(f"{down} and not {write_get(rungs, counter, '~down')}")
    write_set(rungs, counter, EnableOut=True)
    write_set(rungs, counter, **{"~up": up, "~down": down})
    with rungs.writer.block(f"if {write_get(rungs, counter, 'Reset')}:"):
        write_set(rungs, counter, **_CLEARED)
    with rungs.writer.block("else:"):
        write_set(rungs, counter, CU=up, CD=down)
        with rungs.writer.block(f"if {counts_up} and not {counts_down}:"):
            write_one_count(rungs, counter, write_get(rungs, counter, "ACC"), 1)
        with rungs.writer.block(f"if {counts_down} and not {counts_up}:"):
            write_one_count(rungs, counter, write_get(rungs, counter, "ACC"), -1)
        write_done(rungs, counter, write_get(rungs, counter, "ACC"))


# --- one-shots: OutputBit is true for one scan when InputBit becomes true (OSRI) or false (OSFI)


def _one_shot(name: str, *, rising: bool) -> Spec:
    """Return the row of OSRI, or of OSFI if not `rising`."""

    def run(machine: Interpreter, shot: Group) -> None:
        is_on, was_on = _get(machine, shot, "InputBit"), _get(machine, shot, "~before")
        fires = is_on and not was_on if rising else was_on and not is_on
        put(machine, shot, **{"EnableOut": True, "OutputBit": fires, "~before": is_on})

    def write(rungs: RungWriter, shot: Group) -> None:
        is_on, was_on = write_get(rungs, shot, "InputBit"), write_get(rungs, shot, "~before")
        fires = f"{is_on} and not {was_on}" if rising else f"{was_on} and not {is_on}"
        write_set(rungs, shot, EnableOut=True)
        write_set(rungs, shot, **{"OutputBit": fires, "~before": is_on})

    prescan = prescan_sets(0, **{"OutputBit": False, "~before": rising})
    return _block(name, FBD_ONESHOT, run=run, write=write, prescan=prescan)


# --- the rows

TONR = _timer("TONR", timing.TON)
TOFR = _timer("TOFR", timing.TOF, full=True)
RTOR = _timer("RTOR", timing.RTO)
CTUD = _block(
    "CTUD",
    FBD_COUNTER,
    run=_ctud,
    write=_write_ctud,
    prescan=prescan_sets(0, **{"~up": True, "~down": True}),
)
OSRI = _one_shot("OSRI", rising=True)
OSFI = _one_shot("OSFI", rising=False)
