"""Timers and counters."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..interpreter import MS
from ..operands import Group
from ..types import DINT

if TYPE_CHECKING:
    from .steps import RungWriter


def _set(rungs: RungWriter, structure: Group, **members: str) -> None:
    for name, text in members.items():
        rungs.values.assign(structure.member(name), text)


def _get(rungs: RungWriter, structure: Group, name: str) -> str:
    return rungs.values.read(structure.member(name))


def _start(rungs: RungWriter, timer: Group) -> None:
    rungs.values.assign(timer.member("~last_ns"), "now")


def _add_time(rungs: RungWriter, timer: Group) -> None:
    last, accumulated = _get(rungs, timer, "~last_ns"), _get(rungs, timer, "ACC")
    elapsed = rungs.values.keep(f"(now - {last}) // {MS}")
    with rungs.writer.block(f"if {elapsed}:"):
        rungs.values.assign(timer.member("~last_ns"), f"{last} + {elapsed} * {MS}")
        rungs.values.assign(timer.member("ACC"), f"min({accumulated} + {elapsed}, {DINT.highest})")


def _reached(rungs: RungWriter, timer: Group, **done: str) -> None:
    preset, accumulated = _get(rungs, timer, "PRE"), _get(rungs, timer, "ACC")
    with rungs.writer.block(f"if 0 <= {accumulated} < {preset}:"):
        _set(rungs, timer, TT="True")
    with rungs.writer.block("else:"):
        rungs.writer.line(f"negative({rungs.values.site}, {timer.text!r}, {preset}, {accumulated})")
        _set(rungs, timer, **done)


def _time_on(rungs: RungWriter, timer: Group) -> None:
    with rungs.writer.block(f"if not {_get(rungs, timer, 'DN')}:"):
        with rungs.writer.block(f"if {_get(rungs, timer, 'EN')}:"):
            _add_time(rungs, timer)
        with rungs.writer.block("else:"):
            _start(rungs, timer)
        _reached(rungs, timer, TT="False", DN="True")
    with rungs.writer.block("else:"):
        _set(rungs, timer, TT="False")
    _set(rungs, timer, EN="True")


def ton(rungs: RungWriter, power: str, timer: Group) -> None:
    """TON: time the rung while it is true, forget when it is false."""
    rungs.either(
        power,
        lambda: _time_on(rungs, timer),
        lambda: _set(rungs, timer, EN="False", TT="False", DN="False", ACC="0"),
    )


def rto(rungs: RungWriter, power: str, timer: Group) -> None:
    """RTO: time the rung while it is true, keep what there is when it is false."""
    rungs.either(power, lambda: _time_on(rungs, timer), lambda: _set(rungs, timer, EN="False", TT="False"))


def tof(rungs: RungWriter, power: str, timer: Group) -> None:
    """TOF: done at once on a true rung, no longer done a time after it has become false."""
    rungs.either(
        power,
        lambda: _set(rungs, timer, EN="True", TT="False", DN="True", ACC="0"),
        lambda: _time_off(rungs, timer),
    )


def _time_off(rungs: RungWriter, timer: Group) -> None:
    with rungs.writer.block(f"if {_get(rungs, timer, 'DN')}:"):
        with rungs.writer.block(f"if {_get(rungs, timer, 'EN')}:"):
            _start(rungs, timer)
        with rungs.writer.block("else:"):
            _add_time(rungs, timer)
        _reached(rungs, timer, TT="False", DN="False")
    with rungs.writer.block("else:"):
        _set(rungs, timer, TT="False")
    _set(rungs, timer, EN="False")


def ctu(rungs: RungWriter, power: str, counter: Group) -> None:
    """CTU: count up from false to true."""
    _count(rungs, power, counter, "CU", DINT.highest, DINT.lowest, "+ 1", "UN", "OV")


def ctd(rungs: RungWriter, power: str, counter: Group) -> None:
    """CTD: count down from false to true."""
    _count(rungs, power, counter, "CD", DINT.lowest, DINT.highest, "- 1", "OV", "UN")


def _count(
    rungs: RungWriter,
    power: str,
    counter: Group,
    enable: str,
    last: int,
    wrapped: int,
    step: str,
    back: str,
    beyond: str,
) -> None:
    def when_true() -> None:
        accumulated = _get(rungs, counter, "ACC")
        with rungs.writer.block(f"if not {_get(rungs, counter, enable)}:"):
            _set(rungs, counter, **{enable: "True"})
            with rungs.writer.block(f"if {accumulated} != {last}:"):
                _set(rungs, counter, ACC=f"{accumulated} {step}")
            with rungs.writer.block("else:"):
                _set(rungs, counter, ACC=str(wrapped))
                with rungs.writer.block(f"if {_get(rungs, counter, back)}:"):
                    _set(rungs, counter, **{back: "False"})
                with rungs.writer.block("else:"):
                    _set(rungs, counter, **{beyond: "True"})
        reached = f"{accumulated} >= {_get(rungs, counter, 'PRE')}"
        over, under = _get(rungs, counter, "OV"), _get(rungs, counter, "UN")
        _set(rungs, counter, DN=f"{over} or {reached} and not {under}")

    rungs.either(power, when_true, lambda: _set(rungs, counter, **{enable: "False"}))


def res(rungs: RungWriter, structure: Group) -> None:
    """RES: clear a timer, counter or control, all but its PRE or LEN."""
    kind: Any = structure.type
    for member in kind.members:
        if member.name not in ("PRE", "LEN"):
            rungs.values.assign(structure.member(member.name), repr(member.type.zero))
