"""ALMD and ALMA: alarms with acknowledgment, for a condition and for limits.

    InAlarm  Acked   becomes
    0        1       1 0 when the condition has lasted MinDurationPRE ms (1 1 without AckRequired)
    1        0       1 1 when acknowledged; 0 0 when the condition ends, Latched: 0 1 on a reset after the end
    1        1       0 1 when the condition ends, Latched: on a reset after the end
    0        0       0 1 when acknowledged, 1 0 when the condition returns

[1756-RM003N p. 49, 50, 64, 65]. A rising ProgAck or ProgReset is one request. A set OperAck or OperReset is
one request, and the instruction clears it. Alarms have no subscribers here, so they send no messages.
"""

from __future__ import annotations

from collections.abc import Iterable

from ...compiler.alarms import write_alma, write_almd
from ...interpreter import Interpreter
from ...interpreter.files import Members
from ...model.operands import Group, Resolved
from ...model.spec import IN_RUNGS, Use, always
from ...model.types import ALARM_LEVELS, ANALOG_ALARMS
from ..prescans import prescan_sets

_NS_PER_MS, _NS_PER_US = 1_000_000, 1_000


def _copy(machine: Interpreter, alarm: Members, names: Iterable[str], operands: Iterable[Resolved]) -> None:
    """Copy operands to the parameters with these names."""
    for name, operand in zip(names, operands, strict=True):
        alarm.set(**{name: machine.condition(operand)})


def _take_request(alarm: Members, name: str) -> bool:
    """Return whether the program (by a rising bit) or the operator makes a request, and clear the request."""
    program, program_before = alarm[f"Prog{name}"], alarm[f"~{name}"]
    requested = bool(program and not program_before) or bool(alarm[f"Oper{name}"])
    alarm.set(**{f"~{name}": program, f"Oper{name}": False})
    return requested


def _switch(alarm: Members, set_request: str, reset_request: str, state: str) -> bool:
    """Set or reset a state by its two requests, and return the state. Reset has precedence."""
    if alarm[f"Prog{reset_request}"] or alarm[f"Oper{reset_request}"]:
        alarm.set(**{state: False})
    elif alarm[f"Prog{set_request}"] or alarm[f"Oper{set_request}"]:
        alarm.set(**{state: True})
    alarm.set(**{f"Oper{set_request}": False, f"Oper{reset_request}": False})
    return bool(alarm[state])


def _has_lasted(machine: Interpreter, alarm: Members, active: bool) -> bool:
    """Measure how long a condition lasts; return whether the time is at least MinDurationPRE ms."""
    if not active:
        alarm.set(MinDurationACC=0, **{"~active": False})
        return False
    if not alarm["~active"]:
        alarm.set(**{"~active": True, "~since_ns": machine.now_ns})
    elapsed = (machine.now_ns - int(alarm["~since_ns"])) // _NS_PER_MS
    alarm.set(MinDurationACC=min(elapsed, 0x7FFF_FFFF))
    return elapsed >= alarm["MinDurationPRE"]


# --- ALMD


def _almd(machine: Interpreter, power: bool, group: Group, *operands: Resolved) -> None:
    """Run one call of ALMD: read the requests, begin or end the alarm, and set its acknowledgment."""
    alarm = Members(machine, group)
    alarm.set(EnableIn=power, EnableOut=power, In=power)
    _copy(machine, alarm, ("ProgAck", "ProgReset", "ProgDisable", "ProgEnable"), operands)
    disabled = _switch(alarm, "Disable", "Enable", "Disabled")
    _switch(alarm, "Suppress", "Unsuppress", "Suppressed")
    acknowledged, reset = _take_request(alarm, "Ack"), _take_request(alarm, "Reset")
    if alarm["AlarmCountReset"]:
        alarm.set(AlarmCount=0, AlarmCountReset=False)
    active = not disabled and alarm["In"] == alarm["Condition"]
    if _has_lasted(machine, alarm, active) and not alarm["InAlarm"]:
        alarm.set(
            InAlarm=True,
            Acked=not alarm["AckRequired"],
            AlarmCount=min(int(alarm["AlarmCount"]) + 1, 0x7FFF_FFFF),
            InAlarmTime=machine.now_ns // _NS_PER_US,
        )
    elif alarm["InAlarm"] and not active:
        _end_alarm(alarm, reset=reset, disabled=disabled)
    if acknowledged or not alarm["AckRequired"]:
        alarm.set(Acked=True)
    alarm.set(InAlarmUnack=alarm["InAlarm"] and not alarm["Acked"])


def _end_alarm(alarm: Members, *, reset: bool, disabled: bool) -> None:
    """End the alarm of a condition that has ended, unless it is latched and not reset."""
    if disabled or (alarm["Latched"] and reset):
        alarm.set(InAlarm=False, Acked=True)
    elif not alarm["Latched"]:
        alarm.set(InAlarm=False)


# --- ALMA


def _alma(machine: Interpreter, power: bool, group: Group, source: Resolved, *operands: Resolved) -> None:
    """Run one call of ALMA, which sets its alarms; a false rung changes only EnableIn and EnableOut."""
    alarm = Members(machine, group)
    alarm.set(EnableIn=power, EnableOut=power)
    if not power:
        return
    alarm.set(In=float(machine.number(source, 0)))
    _copy(machine, alarm, ("ProgAckAll", "ProgDisable", "ProgEnable"), operands)
    disabled = _switch(alarm, "Disable", "Enable", "Disabled")
    _switch(alarm, "Suppress", "Unsuppress", "Suppressed")
    acknowledged = _take_request(alarm, "AckAll")
    _set_levels(machine, alarm, disabled=disabled, acknowledged=acknowledged)
    _set_rate_alarms(machine, alarm, disabled=disabled, acknowledged=acknowledged)
    alarm.set(InAlarm=any(alarm[f"{name}InAlarm"] for name in ANALOG_ALARMS))
    alarm.set(AnyInAlarmUnack=any(alarm[f"{name}InAlarmUnack"] for name in ANALOG_ALARMS))


def _set_levels(machine: Interpreter, alarm: Members, *, disabled: bool, acknowledged: bool) -> None:
    """Set the level alarms; while one is on, other alarms need no minimum duration."""
    beyond = {
        name: not disabled and bool(alarm[f"{name}Enabled"]) and _is_beyond(alarm, name)
        for name in ALARM_LEVELS
    }
    lasts = _has_lasted(machine, alarm, any(beyond.values()))
    already = any(alarm[f"{name}InAlarm"] for name in ALARM_LEVELS)
    for name in ALARM_LEVELS:
        stays = not disabled and bool(alarm[f"{name}InAlarm"]) and not _is_back_inside(alarm, name)
        _set_level(
            alarm, name, in_alarm=stays or (beyond[name] and (lasts or already)), acknowledged=acknowledged
        )


def _is_beyond(alarm: Members, name: str) -> bool:
    value, limit = alarm["In"], alarm[f"{name}Limit"]
    return value >= limit if name.startswith("H") else value <= limit


def _is_back_inside(alarm: Members, name: str) -> bool:
    """Return whether the value has returned from a limit by more than the deadband."""
    value, limit, band = alarm["In"], alarm[f"{name}Limit"], max(alarm["Deadband"], 0.0)
    return value < limit - band if name.startswith("H") else value > limit + band


def _set_level(alarm: Members, name: str, *, in_alarm: bool, acknowledged: bool) -> None:
    """Set InAlarm, Acked and InAlarmUnack of one alarm.

    With AckRequired, a new alarm is not acknowledged.
    """
    required = alarm["AckRequired"]
    if in_alarm and not alarm[f"{name}InAlarm"]:
        alarm.set(**{f"{name}Acked": not required})
    if acknowledged or not required:
        alarm.set(**{f"{name}Acked": True})
    alarm.set(**{f"{name}InAlarm": in_alarm, f"{name}InAlarmUnack": in_alarm and not alarm[f"{name}Acked"]})


def _set_rate_alarms(machine: Interpreter, alarm: Members, *, disabled: bool, acknowledged: bool) -> None:
    """Sample once per ROCPeriod (s), and set the rate-of-change alarms."""
    period, elapsed = alarm["ROCPeriod"], machine.now_ns - int(alarm["~sampled_ns"])
    if not alarm["~sampled"]:
        alarm.set(**{"~sampled": True, "~sampled_ns": machine.now_ns, "~sample": alarm["In"]})
    elif period > 0 and elapsed >= period * 1e9:
        alarm.set(ROC=(alarm["In"] - alarm["~sample"]) / period)
        alarm.set(**{"~sampled_ns": machine.now_ns, "~sample": alarm["In"]})
    for name, sign in (("ROCPos", 1), ("ROCNeg", -1)):
        limit = alarm[f"{name}Limit"]
        in_alarm = not disabled and period > 0 and limit > 0 and sign * alarm["ROC"] >= limit
        _set_level(alarm, name, in_alarm=in_alarm, acknowledged=acknowledged)


_NOT_IN_ALARM = {
    **{f"{name}InAlarm": False for name in ("", *ANALOG_ALARMS)},
    **{f"{name}InAlarmUnack": False for name in ("Any", *ANALOG_ALARMS)},
    **{f"{name}Acked": True for name in ANALOG_ALARMS},
    "OperAckAll": False,
}


# --- the rows

_SWITCHES = (Use.SWITCH, Use.SWITCH, Use.SWITCH)

ALMD = always(
    "ALMD",
    Use.ALARM_DIGITAL,
    Use.SWITCH,
    *_SWITCHES,
    Use.PRESET,
    Use.PRESET,
    optional=2,
    run=_almd,
    write=write_almd,
    faults=False,
    instead=IN_RUNGS,
    prescan=prescan_sets(0, InAlarm=False, InAlarmUnack=False, Acked=True, OperAck=False, OperReset=False),
)
ALMA = always(
    "ALMA",
    Use.ALARM_ANALOG,
    Use.NUMBER,
    *_SWITCHES,
    *[Use.PRESET] * 4,
    optional=4,
    run=_alma,
    write=write_alma,
    faults=False,
    prescan=prescan_sets(0, **_NOT_IN_ALARM),
)
