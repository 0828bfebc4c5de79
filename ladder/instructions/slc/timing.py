"""Timers with a time base, and 16-bit counters [1747-RM001, chapter "Basic instructions"].

rung  ___|‾‾‾‾‾‾‾‾‾‾|______     ACC counts time bases up to PRE; a fraction carries over to the next scan
EN    ___|‾‾‾‾‾‾‾‾‾‾|______
TT    ___|‾‾‾‾‾|___________     TON; a TOF times while the rung is false
DN    _________|‾‾‾‾|______
"""

from __future__ import annotations

from ...interpreter import Interpreter
from ...interpreter.files import Members
from ...model.arithmetic import wrap
from ...model.operands import Constant, Group, Resolved
from ...model.types import INT

BASES_NS = {1.0: 1_000_000_000, 0.01: 10_000_000, 0.001: 1_000_000}
"""Time bases in ns, by operand; only MicroLogix has 0.001 s."""


def _count_time(machine: Interpreter, group: Group, timer: Members, base: Resolved) -> None:
    """Add the elapsed time bases to ACC."""
    assert isinstance(base, Constant)
    preset, accumulated = machine.whole(timer["PRE"]), machine.whole(timer["ACC"])
    if preset < 0 or accumulated < 0:
        machine.fault_log.negative_timer(machine.site, group.text, preset, accumulated)
    units = machine.elapsed(group.member("~last_ns"), BASES_NS[float(base.value)])
    timer.set(ACC=min(accumulated + units, max(preset, accumulated)))


def _start_clock(machine: Interpreter, group: Group) -> None:
    machine.start_clock(group.member("~last_ns"))


def on_delay(machine: Interpreter, power: bool, group: Group, base: Resolved, *_shown: Resolved) -> None:
    """Run TON."""
    retentive(machine, power, group, base)
    if not power:
        Members(machine, group).set(DN=False, ACC=0)


def retentive(machine: Interpreter, power: bool, group: Group, base: Resolved, *_shown: Resolved) -> None:
    """Run RTO; a false rung keeps ACC and DN."""
    timer = Members(machine, group)
    if not power:
        timer.set(EN=False, TT=False)
        return
    if not timer["EN"]:
        _start_clock(machine, group)
    _count_time(machine, group, timer, base)
    done = timer["ACC"] >= timer["PRE"]
    timer.set(EN=True, DN=done, TT=not done)


def off_delay(machine: Interpreter, power: bool, group: Group, base: Resolved, *_shown: Resolved) -> None:
    """Run TOF."""
    timer = Members(machine, group)
    if power:
        timer.set(EN=True, TT=False, DN=True, ACC=0)
        return
    if timer["EN"]:
        _start_clock(machine, group)
    elif not timer["TT"]:
        return
    _count_time(machine, group, timer, base)
    done = timer["ACC"] >= timer["PRE"]
    timer.set(EN=False, TT=not done, DN=not done)


def prescan_off_delay(machine: Interpreter, group: Group, *_others: Resolved) -> None:
    """Reset a TOF to its state after the delay."""
    timer = Members(machine, group)
    timer.set(EN=False, TT=False, DN=False, ACC=max(machine.whole(timer["PRE"]), 0))


# --- counters


def count(machine: Interpreter, power: bool, group: Group, bit: str, step: int, beyond: str) -> None:
    """Run CTU or CTD; ACC wraps from 32,767 to -32,768 or back, and sets OV or UN."""
    counter = Members(machine, group)
    if power and not counter[bit]:
        value = machine.whole(counter["ACC"]) + step
        counter.set(ACC=wrap(value, INT.bits))
        if not INT.lowest <= value <= INT.highest:
            counter.set(**{beyond: True})
    counter.set(**{bit: power})
    counter.set(DN=counter["ACC"] >= counter["PRE"])
