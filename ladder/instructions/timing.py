"""Timers and counters."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from ..compiler.rungs import RungWriter
from ..interpreter import Interpreter
from ..model import arithmetic
from ..model.operands import Group, Place
from ..model.spec import Spec, Use, action, always, do_nothing
from ..model.types import DINT, Elementary, Structure
from .prescans import prescan_sets

_MS = 1_000_000  # nanoseconds in a millisecond


def _cleared_by_res(structure: Group) -> Iterator[tuple[Place, Elementary]]:
    """Yield the members that RES clears (all except PRE and LEN), with their types."""
    assert isinstance(structure.type, Structure)
    for member in structure.type.members:
        if member.name not in ("PRE", "LEN"):
            assert isinstance(member.type, Elementary)
            yield structure.member(member.name), member.type


# --- in the interpreter


def _count_time(machine: Interpreter, timer: Group) -> None:
    """Add the whole ms since the last call; keep the remainder."""
    accumulated = timer.member("ACC")
    exact = machine.whole(machine.get(accumulated)) + machine.elapsed(timer.member("~last_ns"), _MS)
    machine.put(accumulated, machine.least(exact, DINT.highest))


def _start_time(machine: Interpreter, timer: Group) -> None:
    machine.start_clock(timer.member("~last_ns"))


def _reached(machine: Interpreter, timer: Group) -> bool:
    """Return whether ACC has reached PRE; fault if either is negative."""
    preset, accumulated = (machine.whole(machine.get(timer.member(name))) for name in ("PRE", "ACC"))
    if preset < 0 or accumulated < 0:
        machine.fault_log.negative_timer(machine.site, timer.text, preset, accumulated)
    return accumulated >= preset


def put(machine: Interpreter, structure: Group, **members: bool | int) -> None:
    """Set members to values of their types."""
    for name, value in members.items():
        machine.put(structure.member(name), value)


def _time_on(machine: Interpreter, timer: Group) -> None:
    """Run TON or RTO on a true rung: start or count the time, and set DN when PRE is reached."""
    if machine.get(timer.member("DN")):
        put(machine, timer, EN=True, TT=False)
        return
    if machine.get(timer.member("EN")):
        _count_time(machine, timer)
    else:
        _start_time(machine, timer)
    done = _reached(machine, timer)
    put(machine, timer, EN=True, TT=not done, DN=done)


def _tof(machine: Interpreter, power: bool, timer: Group) -> None:
    """Run TOF: a true rung sets DN; a false rung counts the time, and clears DN when PRE is reached."""
    if power:
        put(machine, timer, EN=True, TT=False, DN=True, ACC=0)
    elif machine.get(timer.member("DN")):
        if machine.get(timer.member("EN")):
            _start_time(machine, timer)
        else:
            _count_time(machine, timer)
        done = _reached(machine, timer)
        put(machine, timer, EN=False, TT=not done, DN=not done)
    else:
        put(machine, timer, EN=False, TT=False)


def _count(machine: Interpreter, power: bool, counter: Group, enable: str, step: int) -> None:
    """Count if the rung has risen, and set DN; `enable` (CU or CD) stores the rung's state."""
    if not power:
        machine.put(counter.member(enable), False)
        return
    if not machine.get(counter.member(enable)):
        machine.put(counter.member(enable), True)
        one_count(machine, counter, step)
    put_done(machine, counter)


def put_done(machine: Interpreter, counter: Group) -> None:
    """Set DN of a counter."""
    over, under = machine.get(counter.member("OV")), machine.get(counter.member("UN"))
    reached = machine.get(counter.member("ACC")) >= machine.get(counter.member("PRE"))
    machine.put(counter.member("DN"), machine.truth(over or (reached and not under)))


def one_count(machine: Interpreter, counter: Group, step: int) -> None:
    """Count by a step of 1 or -1; if ACC wraps, set OV or UN, or clear the opposite bit if it is set."""
    accumulated = counter.member("ACC")
    exact = machine.whole(machine.get(accumulated)) + step
    machine.put(accumulated, arithmetic.wrap(exact, 32))
    if exact != machine.get(accumulated):
        beyond, opposite = ("OV", "UN") if step > 0 else ("UN", "OV")
        if machine.get(counter.member(opposite)):
            machine.put(counter.member(opposite), False)
        else:
            machine.put(counter.member(beyond), True)


def _res(machine: Interpreter, structure: Group) -> None:
    for place, kind in _cleared_by_res(structure):
        machine.put(place, kind.zero)


# --- in the compiler


def write_set(rungs: RungWriter, structure: Group, **members: object) -> None:
    """Write code that assigns values to members."""
    for name, text in members.items():
        rungs.values.assign(structure.member(name), str(text))


def write_get(rungs: RungWriter, structure: Group, name: str) -> str:
    """Return code that reads a member."""
    return rungs.values.read(structure.member(name))


def _write_start(rungs: RungWriter, timer: Group) -> None:
    rungs.values.assign(timer.member("~last_ns"), "now")


def _write_add_time(rungs: RungWriter, timer: Group) -> None:
    """Write the code of `_count_time`."""
    last, accumulated = write_get(rungs, timer, "~last_ns"), write_get(rungs, timer, "ACC")
    elapsed = rungs.values.keep(f"(now - {last}) // {_MS}")
    with rungs.writer.block(f"if {elapsed}:"):
        rungs.values.assign(timer.member("~last_ns"), f"{last} + {elapsed} * {_MS}")
        rungs.values.assign(timer.member("ACC"), f"min({accumulated} + {elapsed}, {DINT.highest})")


def _write_reached(rungs: RungWriter, timer: Group, **when_reached: str) -> None:
    """Write code that sets TT until PRE is reached, then the members `when_reached`; see `_reached`."""
    preset, accumulated = write_get(rungs, timer, "PRE"), write_get(rungs, timer, "ACC")
    with rungs.writer.block(f"if 0 <= {accumulated} < {preset}:"):
        write_set(rungs, timer, TT="True")
    with rungs.writer.block("else:"):
        rungs.writer.line(f"negative({rungs.values.site}, {timer.text!r}, {preset}, {accumulated})")
        write_set(rungs, timer, **when_reached)


def _write_time_on(rungs: RungWriter, timer: Group) -> None:
    """Write the code of `_time_on`."""
    with rungs.writer.block(f"if not {write_get(rungs, timer, 'DN')}:"):
        with rungs.writer.block(f"if {write_get(rungs, timer, 'EN')}:"):
            _write_add_time(rungs, timer)
        with rungs.writer.block("else:"):
            _write_start(rungs, timer)
        _write_reached(rungs, timer, TT="False", DN="True")
    with rungs.writer.block("else:"):
        write_set(rungs, timer, TT="False")
    write_set(rungs, timer, EN="True")


def _write_tof(rungs: RungWriter, power: str, timer: Group) -> None:
    """Write the code of `_tof`."""
    rungs.either(
        power,
        lambda: write_set(rungs, timer, EN="True", TT="False", DN="True", ACC="0"),
        lambda: _write_time_off(rungs, timer),
    )


def _write_time_off(rungs: RungWriter, timer: Group) -> None:
    """Write the code of `_tof` on a false rung."""
    with rungs.writer.block(f"if {write_get(rungs, timer, 'DN')}:"):
        with rungs.writer.block(f"if {write_get(rungs, timer, 'EN')}:"):
            _write_start(rungs, timer)
        with rungs.writer.block("else:"):
            _write_add_time(rungs, timer)
        _write_reached(rungs, timer, TT="False", DN="False")
    with rungs.writer.block("else:"):
        write_set(rungs, timer, TT="False")
    write_set(rungs, timer, EN="False")


def write_one_count(rungs: RungWriter, counter: Group, accumulated: str, step: int) -> None:
    """Write the code of `one_count`."""
    last, wrapped = (DINT.highest, DINT.lowest) if step > 0 else (DINT.lowest, DINT.highest)
    beyond, opposite = ("OV", "UN") if step > 0 else ("UN", "OV")
    with rungs.writer.block(f"if {accumulated} != {last}:"):
        write_set(rungs, counter, ACC=f"{accumulated} {'+' if step > 0 else '-'} 1")
    with rungs.writer.block("else:"):
        write_set(rungs, counter, ACC=wrapped)
        with rungs.writer.block(f"if {write_get(rungs, counter, opposite)}:"):
            write_set(rungs, counter, **{opposite: False})
        with rungs.writer.block("else:"):
            write_set(rungs, counter, **{beyond: True})


def write_done(rungs: RungWriter, counter: Group, accumulated: str) -> None:
    """Write code that sets DN of a counter."""
    reached = f"{accumulated} >= {write_get(rungs, counter, 'PRE')}"
    over, under = write_get(rungs, counter, "OV"), write_get(rungs, counter, "UN")
    write_set(rungs, counter, DN=f"{over} or {reached} and not {under}")


def _write_count(rungs: RungWriter, power: str, counter: Group, enable: str, step: int) -> None:
    """Write the code of `_count`."""

    def when_true() -> None:
        accumulated = write_get(rungs, counter, "ACC")
        with rungs.writer.block(f"if not {write_get(rungs, counter, enable)}:"):
            write_set(rungs, counter, **{enable: True})
            write_one_count(rungs, counter, accumulated, step)
        write_done(rungs, counter, accumulated)

    rungs.either(power, when_true, lambda: write_set(rungs, counter, **{enable: False}))


def _write_res(rungs: RungWriter, structure: Group) -> None:
    for place, kind in _cleared_by_res(structure):
        rungs.values.assign(place, repr(kind.zero))


# --- in prescan


def _prescan_tof(machine: Interpreter, timer: Group) -> None:
    put(machine, timer, EN=False, TT=False, DN=False)
    machine.put(timer.member("ACC"), machine.get(timer.member("PRE")))


# --- the rows


def _timer(name: str, **parts: Any) -> Spec:
    instead = f"use {name}R with an FBD_TIMER"
    return always(
        name, Use.TIMER, *_PRESETS, optional=2, captions=("Timer", *_SHOWN), instead=instead, **parts
    )


def _on_delay(name: str, **off: bool | int) -> Spec:
    """Return the row of TON or RTO; a false rung sets the members `off`, and prescan also clears DN."""

    def run(machine: Interpreter, power: bool, timer: Group) -> None:
        if power:
            _time_on(machine, timer)
        else:
            put(machine, timer, **off)

    def write(rungs: RungWriter, power: str, timer: Group) -> None:
        rungs.either(power, lambda: _write_time_on(rungs, timer), lambda: write_set(rungs, timer, **off))

    return _timer(name, run=run, write=write, prescan=prescan_sets(0, **(off | {"DN": False})))


def _counter(name: str, enable: str, step: int) -> Spec:
    """Return the row of CTU or CTD.

    Prescan sets `enable`, so a rung that is already true does not count.
    """
    return always(
        name,
        Use.COUNTER,
        *_PRESETS,
        optional=2,
        captions=("Counter", *_SHOWN),
        instead="use CTUD with an FBD_COUNTER",
        run=lambda machine, power, counter: _count(machine, power, counter, enable, step),
        write=lambda rungs, power, counter: _write_count(rungs, power, counter, enable, step),
        prescan=prescan_sets(0, **{enable: True}),
        postscan=do_nothing,
    )


_PRESETS = (Use.PRESET, Use.PRESET)
_SHOWN = ("Preset", "Accum")

TON = _on_delay("TON", EN=False, TT=False, DN=False, ACC=0)
TOF = _timer("TOF", run=_tof, write=_write_tof, prescan=_prescan_tof, postscan=_prescan_tof)
RTO = _on_delay("RTO", EN=False, TT=False)
CTU = _counter("CTU", "CU", 1)
CTD = _counter("CTD", "CD", -1)
RES = action("RES", Use.RESETTABLE, run=_res, write=_write_res, symbol="(RES)")
