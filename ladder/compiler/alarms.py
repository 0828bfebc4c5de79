"""ALMD and ALMA as Python text; `instructions.process.alarms` has the same steps in the same order."""

from __future__ import annotations

from collections.abc import Iterable

from ..model.operands import SINGLE, Group, Resolved
from ..model.types import ALARM_LEVELS, DINT, REAL
from .files import MemberText, converted_text
from .rungs import RungWriter

_NS_PER_MS, _NS_PER_US = 1_000_000, 1_000


class _AlarmText(MemberText):
    """The common steps of ALMD and ALMA."""

    def copy(self, names: Iterable[str], operands: Iterable[Resolved]) -> None:
        """Write operands to the parameters with these names."""
        for name, operand in zip(names, operands, strict=True):
            self.set(**{name: self._values.condition(operand)})

    def requested(self, name: str) -> str:
        """Return a variable that is true if the program or the operator requests `name`."""
        program = self.keep(self[f"Prog{name}"])
        request = self.keep(f"{program} and not {self[f'~{name}']} or {self[f'Oper{name}']}")
        self.set(**{f"~{name}": program, f"Oper{name}": False})
        return request

    def switch(self, set_request: str, clear_request: str, state: str) -> None:
        """Write code that sets and clears a state on request."""
        with self.block(f"if {self[f'Prog{clear_request}']} or {self[f'Oper{clear_request}']}:"):
            self.set(**{state: False})
        with self.block(f"elif {self[f'Prog{set_request}']} or {self[f'Oper{set_request}']}:"):
            self.set(**{state: True})
        self.set(**{f"Oper{set_request}": False, f"Oper{clear_request}": False})

    def lasts(self, active: str) -> str:
        """Write the timing of a condition; return a variable that is true after it lasted long enough."""
        flag = self.keep("False")
        with self.block(f"if {active}:"):
            with self.block(f"if not {self['~active']}:"):
                self.set(**{"~active": True, "~since_ns": "now"})
            elapsed = self.keep(f"(now - {self['~since_ns']}) // {_NS_PER_MS}")
            self.set(MinDurationACC=f"min({elapsed}, {DINT.highest})")
            self._writer.line(f"{flag} = {elapsed} >= {self['MinDurationPRE']}")
        with self.block("else:"):
            self.set(MinDurationACC=0, **{"~active": False})
        return flag


# --- ALMD


def write_almd(rungs: RungWriter, power: str, group: Group, *operands: Resolved) -> None:
    """Write ALMD: commands of program and operator, the timing of its condition, and the alarm's state.

    The operands are ProgAck, ProgReset, ProgDisable and ProgEnable.
    """
    alarm, power, block = _AlarmText(rungs, group), rungs.kept(power), rungs.writer.block
    alarm.set(EnableIn=power, EnableOut=power, In=power)
    alarm.copy(("ProgAck", "ProgReset", "ProgDisable", "ProgEnable"), operands)
    alarm.switch("Disable", "Enable", "Disabled")
    disabled = alarm.keep(alarm["Disabled"])
    alarm.switch("Suppress", "Unsuppress", "Suppressed")
    acknowledged, reset = alarm.requested("Ack"), alarm.requested("Reset")
    with block(f"if {alarm['AlarmCountReset']}:"):
        alarm.set(AlarmCount=0, AlarmCountReset=False)
    active = alarm.keep(f"not {disabled} and {alarm['In']} == {alarm['Condition']}")
    lasts = alarm.lasts(active)
    with block(f"if {lasts} and not {alarm['InAlarm']}:"):
        alarm.set(InAlarm=True, Acked=f"not {alarm['AckRequired']}")
        alarm.set(AlarmCount=f"min({alarm['AlarmCount']} + 1, {DINT.highest})")
        alarm.set(InAlarmTime=f"now // {_NS_PER_US}")
    with block(f"elif {alarm['InAlarm']} and not {active}:"):
        with block(f"if {disabled} or {alarm['Latched']} and {reset}:"):
            alarm.set(InAlarm=False, Acked=True)
        with block(f"elif not {alarm['Latched']}:"):
            alarm.set(InAlarm=False)
    with block(f"if {acknowledged} or not {alarm['AckRequired']}:"):
        alarm.set(Acked=True)
    alarm.set(InAlarmUnack=f"{alarm['InAlarm']} and not {alarm['Acked']}")


# --- ALMA


def write_alma(rungs: RungWriter, power: str, group: Group, source: Resolved, *operands: Resolved) -> None:
    """Write ALMA: on a true rung, the alarms of the four levels and of the rate of change.

    The operands are ProgAckAll, ProgDisable and ProgEnable.
    """
    alarm, power = _AlarmText(rungs, group), rungs.kept(power)
    alarm.set(EnableIn=power, EnableOut=power)
    with rungs.writer.block(f"if {power}:"):
        alarm.set(In=converted_text(rungs.values.term(source, SINGLE), REAL))
        alarm.copy(("ProgAckAll", "ProgDisable", "ProgEnable"), operands)
        alarm.switch("Disable", "Enable", "Disabled")
        disabled = alarm.keep(alarm["Disabled"])
        alarm.switch("Suppress", "Unsuppress", "Suppressed")
        acknowledged = alarm.requested("AckAll")
        _write_limits(alarm, disabled, acknowledged)
        _write_rates(alarm, disabled, acknowledged)
        for summary, suffix in (("InAlarm", "InAlarm"), ("AnyInAlarmUnack", "InAlarmUnack")):
            names = (*ALARM_LEVELS, "ROCPos", "ROCNeg")
            alarm.set(**{summary: " or ".join(alarm[f"{name}{suffix}"] for name in names)})


def _write_limits(alarm: _AlarmText, disabled: str, acknowledged: str) -> None:
    """Write the alarms of the four levels; an alarm begins after MinDurationPRE beyond any of the limits.

    While any level is in alarm, the alarm of another level begins at once. An alarm ends when the value is
    inside its limit by the deadband.
    """
    beyond = {}
    for name in ALARM_LEVELS:
        passed = f"{alarm['In']} {'>=' if name.startswith('H') else '<='} {alarm[f'{name}Limit']}"
        beyond[name] = alarm.keep(f"not {disabled} and {alarm[f'{name}Enabled']} and {passed}")
    lasts = alarm.lasts(" or ".join(beyond.values()))
    starts = alarm.keep(" or ".join([lasts, *(alarm[f"{name}InAlarm"] for name in ALARM_LEVELS)]))
    for name in ALARM_LEVELS:
        limit, band = alarm[f"{name}Limit"], f"max({alarm['Deadband']}, 0.0)"
        inside = f"< {limit} - {band}" if name.startswith("H") else f"> {limit} + {band}"
        stays = f"not {disabled} and {alarm[f'{name}InAlarm']} and not {alarm['In']} {inside}"
        _write_level(alarm, name, alarm.keep(f"{stays} or {beyond[name]} and {starts}"), acknowledged)


def _write_level(alarm: _AlarmText, name: str, in_alarm: str, acknowledged: str) -> None:
    """Write InAlarm, Acked and InAlarmUnack of one alarm; `in_alarm` is text for its new state."""
    required = alarm["AckRequired"]
    with alarm.block(f"if {in_alarm} and not {alarm[f'{name}InAlarm']}:"):
        alarm.set(**{f"{name}Acked": f"not {required}"})
    with alarm.block(f"if {acknowledged} or not {required}:"):
        alarm.set(**{f"{name}Acked": True})
    alarm.set(**{f"{name}InAlarm": in_alarm})
    alarm.set(**{f"{name}InAlarmUnack": f"{in_alarm} and not {alarm[f'{name}Acked']}"})


def _write_rates(alarm: _AlarmText, disabled: str, acknowledged: str) -> None:
    """Write code that samples the value once per ROCPeriod and compares its rate of change."""
    period = alarm.keep(alarm["ROCPeriod"])
    with alarm.block(f"if not {alarm['~sampled']}:"):
        alarm.set(**{"~sampled": True, "~sampled_ns": "now", "~sample": alarm["In"]})
    with alarm.block(f"elif {period} > 0 and now - {alarm['~sampled_ns']} >= {period} * 1e9:"):
        alarm.set(ROC=f"real(({alarm['In']} - {alarm['~sample']}) / {period})")
        alarm.set(**{"~sampled_ns": "now", "~sample": alarm["In"]})
    for name, rate in (("ROCPos", alarm["ROC"]), ("ROCNeg", f"-{alarm['ROC']}")):
        limit = alarm[f"{name}Limit"]
        in_alarm = alarm.keep(f"not {disabled} and {period} > 0 and {limit} > 0 and {rate} >= {limit}")
        _write_level(alarm, name, in_alarm, acknowledged)
