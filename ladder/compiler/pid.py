"""PID as Python code; `instructions.process.process` has the same steps in the same order."""

from __future__ import annotations

from ..model.errors import PID_SETPOINT_CODE, PID_TIME_CODE
from ..model.operands import SINGLE, Constant, Group, Place, Resolved
from ..model.types import LINT
from .files import MemberText
from .rungs import RungWriter
from .terms import Term


class _LoopText(MemberText):
    """A PID with its bits in CTL."""

    def bit(self, name: str) -> str:
        """Return text for a bit."""
        return self[name]

    def set_bits(self, **texts: object) -> None:
        """Write assignments to bits."""
        for name, text in texts.items():
            self._values.set_bit(self._group.member(name), str(text))

    def round(self, **texts: str) -> None:
        """Write assignments to members, rounded to REAL."""
        self.set(**{name: f"real({text})" for name, text in texts.items()})

    def number(self, operand: Resolved) -> str:
        """Return a variable that contains a number as REAL."""
        return self.keep(self._values.term(operand, SINGLE).text)

    def record(self, text: str, code: int) -> None:
        """Write code that records a minor fault."""
        self._writer.line(f"faults.record({self._values.site}, {text!r}, {code})")

    def scaled(self, value: str, low: str, high: str, least: str, most: str) -> str:
        """Return text for a number scaled from one range to another; the bounds are members or numbers."""
        bounds = (self[limit] if limit[0].isalpha() else limit for limit in (low, high, least, most))
        return f"scaled({value}, {', '.join(bounds)})"

    def percent(self, value: str) -> str:
        """Return text for a number in percent of MAXS - MINS."""
        return f"percent({value}, {self['MINS']}, {self['MAXS']})"


def write_pid(
    rungs: RungWriter,
    power: str,
    group: Group,
    process: Resolved,
    tieback: Resolved,
    target: Place | Constant,
    _master: Resolved,
    inhold: Resolved,
    inhold_value: Resolved,
) -> None:
    """Write PID: on a true rung, it computes OUT in percent and stores it, scaled, in `target`.

    While `inhold` is true, OUT follows `inhold_value`.
    """
    loop, power = _LoopText(rungs, group), rungs.kept(power)
    loop.set_bits(EN=power)
    with loop.block(f"if {power} and not {loop['UPD']} > 0:"):
        loop.record("UPD is not above 0", PID_TIME_CODE)
    with loop.block(f"elif {power}:"):
        with loop.block(f"if {loop['MAXO']} == {loop['MINO']}:"):
            loop.set(MAXO="100.0", MINO="0.0")
        _write_measure(loop, loop.number(process))
        loop.round(TIE=loop.scaled(loop.number(tieback), "MINTIE", "MAXTIE", "0.0", "100.0"))
        output = rungs.writer.temporary()
        _write_output(loop, output)
        with loop.block(f"if {rungs.values.condition(inhold)}:"):
            value = loop.scaled(loop.number(inhold_value), "MINCV", "MAXCV", "0.0", "100.0")
            rungs.writer.line(f"{output} = {value}")
            _write_track(loop, output)
        loop.round(OUT=output)
        if isinstance(target, Place):
            low, high = loop["MINCV"], loop["MAXCV"]
            value = f"({output} if {low} == {high} else {low} + {output} * ({high} - {low}) / 100)"
            rungs.values.store(target, Term(value, real=True, double=True), LINT.bits)


def _write_measure(loop: _LoopText, raw: str) -> None:
    """Write the scaled PV, its alarms and the error."""
    value = loop.keep(loop.scaled(raw, "MINI", "MAXI", "MINS", "MAXS"))
    loop.round(PV=value)
    with loop.block(f"if {loop.bit('PVT')} and ({loop.bit('MO')} or {loop.bit('SWM')}):"):
        loop.round(SP=value)
    low, high = loop["MINS"], loop["MAXS"]
    outside = loop.keep(f"{low} != {high} and not {low} <= {loop['SP']} <= {high}")
    loop.set_bits(SPOR=outside)
    with loop.block(f"if {outside}:"):
        loop.record("SP is out of range", PID_SETPOINT_CODE)
        loop.round(SP=f"min(max({loop['SP']}, {low}), {high})")
    error = loop.keep(f"{loop['SP']} - {loop['PV']}")
    loop.round(ERR=f"-{error} if {loop.bit('CA')} else {error}")
    _write_states(loop)


def _write_states(loop: _LoopText) -> None:
    """Write the alarm bits and the zero-crossing state."""
    value, error = loop["PV"], loop.keep(f"{loop['SP']} - {loop['PV']}")

    def band(name: str, bit: str) -> str:
        return f"({loop[name]} if {loop.bit(bit)} else 0.0)"

    loop.set_bits(
        PVHA=f"{value} >= {loop['PVH']} - {band('PVDB', 'PVHA')}",
        PVLA=f"{value} <= {loop['PVL']} + {band('PVDB', 'PVLA')}",
        DVPA=f"-{error} >= {loop['DVP']} - {band('DVDB', 'DVPA')}",
        DVNA=f"{error} >= abs({loop['DVN']}) - {band('DVDB', 'DVNA')}",
        EWD=f"abs({error}) <= {loop['DB']}",
    )
    crosses = f"({loop['~crossed']} or {error} * {loop['~error']} <= 0)"
    loop.set(**{"~crossed": f"{loop.bit('EWD')} and {crosses}", "~error": error})


def _write_output(loop: _LoopText, output: str) -> None:
    """Write OUT, in percent, to a variable: the computed output, tieback or SO."""
    line = loop._writer.line
    with loop.block(f"if {loop.bit('MO')} or {loop.bit('SWM')}:"):
        line(f"{output} = {loop['TIE']} if {loop.bit('MO')} else {loop['SO']}")
        _write_track(loop, output)
    with loop.block("else:"):
        error, change = loop.keep(loop.percent(loop["ERR"])), _write_change(loop)
        with loop.block(f"if {loop.bit('EWD')} and ({loop.bit('NOZC')} or {loop['~crossed']}):"):
            line(f"{error} = {change} = 0.0")
        previous_sum, (kp, ki, kd) = loop.keep(loop["~sum"]), _gains(loop)
        loop.set(**{"~sum": f"{previous_sum} + {ki} * {error} * {loop['UPD']}"})
        line(f"{output} = {kp} * {error} + {loop['~sum']} + {kd} * {change} + {loop['BIAS']}")
        low, high = loop["MINO"], loop["MAXO"]
        loop.set_bits(OLL=f"{output} <= {low}", OLH=f"{output} >= {high}")
        with loop.block(f"if {output} > {high} and {error} > 0 or {output} < {low} and {error} < 0:"):
            loop.set(**{"~sum": previous_sum})
        line(f"{output} = min(max({output}, {low}), {high})")
        loop.round(SO=output)


def _gains(loop: _LoopText) -> tuple[str, str, str]:
    """Return variables with the three gains; the integral gain is per second."""
    kp, ki, kd = (loop.keep(loop[name]) for name in ("KP", "KI", "KD"))
    with loop.block(f"if {loop.bit('PE')}:"):
        loop._writer.line(f"{ki}, {kd} = {kp} / (60 * {ki}) if {ki} else 0.0, {kp} * 60 * {kd}")
    return kp, ki, kd


def _write_change(loop: _LoopText) -> str:
    """Return a variable with the rate at which the error or -PV changes, in percent per second."""
    current = loop.keep(
        f"{loop['ERR']} if {loop.bit('DOE')} else {loop['PV']} if {loop.bit('CA')} else -{loop['PV']}"
    )
    previous = loop.keep(f"{loop['~last']} if {loop.bit('INI')} else {current}")
    loop.set(**{"~last": current})
    loop.set_bits(INI="True")
    return loop.keep(f"{loop.percent(f'{current} - {previous}')} / {loop['UPD']}")


def _write_track(loop: _LoopText, output: str) -> None:
    """Write the integral term that produces an output."""
    _write_change(loop)
    proportional = f"{_gains(loop)[0]} * {loop.percent(loop['ERR'])}"
    loop.set(**{"~sum": f"{output} - {proportional} - {loop['BIAS']}"})
    loop.round(SO=output)
