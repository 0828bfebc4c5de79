"""PID: a closed loop with independent or dependent gains.

    E% = (SP - PV) in percent of MAXS - MINS; PV - SP with CA
    OUT% = KP E + KI sum(E UPD) + KD dE/UPD + BIAS                 independent gains, in seconds
    OUT% = KP (E + sum(E UPD)/(60 KI) + 60 KD dE/UPD) + BIAS       dependent gains (PE), in minutes
    CV = MINCV + OUT% (MAXCV - MINCV)

OUT stays between MINO and MAXO [1756-RM003N p. 511-526]. PV and the tieback are scaled first, from the ranges
MINI to MAXI and MINTIE to MAXTIE. The derivative is of -PV, or with DOE of the error. The sum stops while OUT
is at a limit. In manual (MO: the tieback; SWM: SO), the sum follows OUT, for a bumpless change to automatic.
Each scan with a true rung is one update of UPD seconds, so run it in a periodic task or with a timer.
"""

from __future__ import annotations

from ...compiler.pid import write_pid
from ...interpreter import Interpreter
from ...interpreter.files import Members
from ...model.arithmetic import percent, scaled
from ...model.errors import PID_SETPOINT_CODE, PID_TIME_CODE
from ...model.operands import Constant, Group, Place, Resolved
from ...model.spec import Use, always
from ..prescans import prescan_sets


class _Loop(Members):
    """A PID in a scan."""

    def bit(self, name: str) -> bool:
        return self._machine.truth(self[name])

    def real(self, name: str) -> float:
        return float(self[name])


def _pid(
    machine: Interpreter,
    power: bool,
    group: Group,
    process_variable: Resolved,
    tieback: Resolved,
    target: Place | Constant,
    _master: Resolved,
    hold: Resolved,
    hold_value: Resolved,
) -> None:
    """Run one update of PID: measure PV, compute OUT or follow the hold value, and store CV in the target.

    A false rung changes only EN. A UPD that is not above 0 is a minor fault.
    """
    loop = _Loop(machine, group)
    loop.set(EN=power)
    if not power:
        return
    if not loop.real("UPD") > 0:
        machine.fault_log.record(machine.site, "UPD is not above 0", PID_TIME_CODE)
        return
    if loop.real("MAXO") == loop.real("MINO"):
        loop.set(MAXO=100.0, MINO=0.0)
    _measure(machine, loop, float(machine.number(process_variable, 0)))
    raw_tieback = float(machine.number(tieback, 0))
    loop.set(TIE=scaled(raw_tieback, loop.real("MINTIE"), loop.real("MAXTIE"), 0.0, 100.0))
    output = _output(loop)
    if machine.condition(hold):
        raw_hold = float(machine.number(hold_value, 0))
        output = scaled(raw_hold, loop.real("MINCV"), loop.real("MAXCV"), 0.0, 100.0)
        _track(loop, output)
    loop.set(OUT=output)
    if isinstance(target, Place):
        low, high = loop.real("MINCV"), loop.real("MAXCV")
        machine.store(target, output if low == high else low + output * (high - low) / 100)


def _measure(machine: Interpreter, loop: _Loop, raw: float) -> None:
    """Scale PV, set its alarms, and compute the error."""
    value = scaled(raw, loop.real("MINI"), loop.real("MAXI"), loop.real("MINS"), loop.real("MAXS"))
    loop.set(PV=value)
    if loop.bit("PVT") and (loop.bit("MO") or loop.bit("SWM")):
        loop.set(SP=value)
    low, high = loop.real("MINS"), loop.real("MAXS")
    outside = low != high and not low <= loop.real("SP") <= high
    loop.set(SPOR=outside)
    if outside:
        machine.fault_log.record(machine.site, "SP is out of range", PID_SETPOINT_CODE)
        loop.set(SP=min(max(loop.real("SP"), low), high))
    error = loop.real("SP") - loop.real("PV")
    loop.set(ERR=-error if loop.bit("CA") else error)
    _set_alarms(loop)


def _set_alarms(loop: _Loop) -> None:
    """Set the alarms of PV and the error, and EWD (the error is within the deadband).

    `~crossed` is true if the error has crossed zero and stayed within the deadband since then.
    """
    value, error = loop.real("PV"), loop.real("SP") - loop.real("PV")
    loop.set(
        PVHA=value >= loop.real("PVH") - (loop.real("PVDB") if loop.bit("PVHA") else 0.0),
        PVLA=value <= loop.real("PVL") + (loop.real("PVDB") if loop.bit("PVLA") else 0.0),
        DVPA=-error >= loop.real("DVP") - (loop.real("DVDB") if loop.bit("DVPA") else 0.0),
        DVNA=error >= abs(loop.real("DVN")) - (loop.real("DVDB") if loop.bit("DVNA") else 0.0),
        EWD=abs(error) <= loop.real("DB"),
    )
    crosses = loop["~crossed"] or error * loop.real("~error") <= 0
    loop.set(**{"~crossed": loop.bit("EWD") and crosses, "~error": error})


def _output(loop: _Loop) -> float:
    """Return OUT in percent: the computed value, or in manual the tieback or SO.

    Store it in SO, and the integral in `~sum`.
    """
    if loop.bit("MO") or loop.bit("SWM"):
        output = loop.real("TIE") if loop.bit("MO") else loop.real("SO")
        _track(loop, output)
        return output
    error, change = _percent(loop, loop.real("ERR")), _change(loop)
    if loop.bit("EWD") and (loop.bit("NOZC") or loop["~crossed"]):
        error, change = 0.0, 0.0
    sum_before = loop.real("~sum")
    proportional, integral, derivative = _gains(loop)
    loop.set(**{"~sum": sum_before + integral * error * loop.real("UPD")})
    output = proportional * error + loop.real("~sum") + derivative * change + loop.real("BIAS")
    low, high = loop.real("MINO"), loop.real("MAXO")
    loop.set(OLL=output <= low, OLH=output >= high)
    if (output > high and error > 0) or (output < low and error < 0):
        loop.set(**{"~sum": sum_before})
    limited = min(max(output, low), high)
    loop.set(SO=limited)
    return limited


def _gains(loop: _Loop) -> tuple[float, float, float]:
    """Return the proportional, integral (1/s) and derivative (s) gains, for the selected form."""
    kp, ki, kd = (loop.real(name) for name in ("KP", "KI", "KD"))
    if loop.bit("PE"):
        return kp, kp / (60 * ki) if ki else 0.0, kp * 60 * kd
    return kp, ki, kd


def _percent(loop: _Loop, value: float) -> float:
    return percent(value, loop.real("MINS"), loop.real("MAXS"))


def _change(loop: _Loop) -> float:
    """Return the rate of change of the error, or of -PV, in percent per second.

    Store the present value for the next update.
    """
    sign = 1.0 if loop.bit("CA") else -1.0
    present = loop.real("ERR") if loop.bit("DOE") else sign * loop.real("PV")
    previous = loop.real("~last") if loop.bit("INI") else present
    loop.set(**{"~last": present})
    loop.set(INI=True)
    return _percent(loop, present - previous) / loop.real("UPD")


def _track(loop: _Loop, output: float) -> None:
    """Set the integral so that the computed output equals `output`, for a bumpless transfer."""
    _change(loop)  # stores the present value
    proportional, _, _ = _gains(loop)
    error = _percent(loop, loop.real("ERR"))
    loop.set(**{"~sum": output - proportional * error - loop.real("BIAS")}, SO=output)


PID = always(
    "PID",
    Use.PID,
    Use.NUMBER,
    Use.NUMBER,
    Use.OPTIONAL_TARGET,
    Use.IGNORED,
    Use.SWITCH,
    Use.NUMBER,
    run=_pid,
    write=write_pid,
    faults=False,
    prescan=prescan_sets(0, INI=False),
)
