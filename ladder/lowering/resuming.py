"""Start a program from the values in an export, as if it had been running.

The first scan has no prescan, S:FS is off, and steps of charts stay active. An export does not have the
hidden state of instructions. It is derived from visible members:

| hidden state | derived from |
|---|---|
| PID: integral term | the output, without a bump |
| PID, one-shots, counters, flip-flops of diagrams: values of the previous scan | the current values |
| ALMD, ALMA: whether the condition is active, and since when | InAlarm, MinDurationACC |
| steps and actions: time | T |
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from ..instructions.charts import resume_chart
from ..model.types import HIDDEN, DataType, Elementary, Structure, count_of
from ..run.engine import Engine
from ..state.memory import Value

Visible = Callable[[str], Any]
"""Returns the value of a member of an instance, by name."""


def _integral(pid: Visible) -> float:
    """Return the integral term that makes the output SO, %."""
    span = pid("MAXS") - pid("MINS")
    error = 100 * pid("ERR") / span if span else 0.0
    return float(pid("SO") - pid("KP") * error - pid("BIAS"))


def _measured(pid: Visible) -> float:
    """Return the value that the PID differentiates, either the error or the process variable."""
    return float(pid("ERR") if pid("DOE") else pid("PV") if pid("CA") else -pid("PV"))


_ALARM: Mapping[str, Callable[[Visible], Value]] = {
    "active": lambda alarm: bool(alarm("InAlarm") or alarm("MinDurationACC")),
    "since_ns": lambda alarm: -1_000_000 * int(alarm("MinDurationACC")),
}

HIDDEN_STATE: Mapping[str, Mapping[str, Callable[[Visible], Value]]] = {
    "PID": {
        "sum": _integral,
        "last": _measured,
        "error": lambda pid: float(pid("SP") - pid("PV")),
    },
    "FBD_ONESHOT": {"before": lambda shot: bool(shot("InputBit"))},
    "FBD_COUNTER": {
        "up": lambda counter: bool(counter("CUEnable")),
        "down": lambda counter: bool(counter("CDEnable")),
    },
    "FLIP_FLOP_D": {"before": lambda flip_flop: bool(flip_flop("Clock"))},
    "FLIP_FLOP_JK": {"before": lambda flip_flop: bool(flip_flop("Clock"))},
    "ALARM_DIGITAL": {
        **_ALARM,
        "Ack": lambda alarm: bool(alarm("ProgAck")),
        "Reset": lambda alarm: bool(alarm("ProgReset")),
    },
    "ALARM_ANALOG": {**_ALARM, "AckAll": lambda alarm: bool(alarm("ProgAckAll"))},
}
"""Hidden members by type, each with a function that returns its initial value."""


def resume(engine: Engine) -> None:
    """Set the hidden state of a new engine from the initial values of its tags."""
    layout = engine.lowered.layout
    for tag in layout.tags().values():
        _resume(engine, tag.name, tag.type, count_of(tag.dims))
    for chart in engine.lowered.charts.values():
        resume_chart(engine.interpreter, chart)


def _resume(engine: Engine, path: str, kind: DataType, count: int) -> None:
    """Set the hidden members of all instances at a path, and of the structures in them."""
    if isinstance(kind, Elementary):
        return
    memory, layout = engine.memory, engine.lowered.layout
    for name, value in HIDDEN_STATE.get(kind.name, {}).items():
        leaf = layout.leaves.get(f"{path}.{HIDDEN}{name}".upper())
        for index in range(count) if leaf is not None else ():
            instance = memory.dump(path, kind, (), index)
            memory.write(leaf, index, value(instance.__getitem__))  # type: ignore[arg-type]
    for member in kind.own:
        if isinstance(member.type, Structure):
            _resume(engine, f"{path}.{member.name}", member.type, count * count_of(member.dims))
