"""PIDE: a closed loop in velocity form [1756-RM006K p. 66-100, 255].

    E% = (SP - PV) in percent of PVEUMax - PVEUMin; PV - SP with ControlAction
    CV = CV before + P dE% + I/60 E% DeltaT + 60 D d(dE%)/DeltaT         independent gains
    CV = CV before + P (dE% + E% DeltaT/(60 I) + 60 D d(dE%)/DeltaT)     dependent gains (DependIndepend)

With PVEProportional, dE% uses only the change of PV. With PVEDerivative, so does d(dE%). The feedforward is
then added, and CV is limited: windup, 0 to 100 %, CVHLimit and CVLLimit, rate of change.

    mode               CV                       requested by
    Hand               HandFB                   ProgHandReq
    Override           CVOverride               ProgOverrideReq
    Manual             CVProg or CVOper         ProgManualReq or OperManualReq
    Auto               the algorithm            ProgAutoReq or OperAutoReq
    CasRat             the algorithm            ProgCasRatReq or OperCasRatReq

Where the manual is silent: after Hand or Override, the mode is Manual; a setpoint or ratio is checked when it
is used; DSmoothing has no effect. Tuning is not simulated, so AtuneReady stays false.
"""

from __future__ import annotations

import math

from scanrack.io_images.dataclass import dataclass

from ...model.types import ALARM_LEVELS, ANALOG_ALARMS
from .function_block import FunctionBlock, block_row
from .measuring import level_alarms, rate_alarms

_REGULATING = ("CasRat", "Auto")
_MODES = (*_REGULATING, "Manual", "Override", "Hand")
_ALARMS = (
    *(f"PV{name}Alarm" for name in ANALOG_ALARMS),
    *(f"Dev{name}Alarm" for name in ALARM_LEVELS),
)


@dataclass(slots=True)
class _PidLoop:
    """One call of a PIDE."""

    block: FunctionBlock
    program: bool
    bad_pv: bool = False  # no error can be computed
    bad_cv: bool = False  # no CV can be computed
    initializing: bool = False
    mode: str = "Manual"
    error: float = 0.0  # in percent
    setpoint_high: bool = False
    setpoint_low: bool = False

    @property
    def regulates(self) -> bool:
        return self.mode in _REGULATING

    def of_control(self, name: str) -> str:
        """Return the name of an input for the side in control, program or operator."""
        return f"{name}{'Prog' if self.program else 'Oper'}"


def _note_faults(loop: _PidLoop) -> None:
    """Note faults of the process variable and of CV, and whether CV is initialized."""
    block = loop.block
    was_faulted = block.on("CVFaulted")
    low, high = block.real("PVEUMin"), block.real("PVEUMax")
    least, most = block.real("SPLLimit"), block.real("SPHLimit")
    loop.bad_pv = block.wrong(
        PVFaulted=block.on("PVFault") or not math.isfinite(block.real("PV")),
        PVSpanInv=not low < high,
        SPLimitsInv=not low <= least <= most <= high,
    )
    spanless = block["CVEUMax"] == block["CVEUMin"]
    loop.bad_cv = block.wrong(CVFaulted=block.on("CVFault"), CVEUSpanInv=spanless)
    requested = block.first or block.on("CVInitReq") or was_faulted
    loop.initializing = requested and not loop.bad_cv


def _requested_mode(loop: _PidLoop) -> str:
    """Return the mode (Manual, Auto or CasRat) that the side in control requests, else the last mode."""
    block, side = loop.block, "Prog" if loop.program else "Oper"
    if block[f"{side}ManualReq"]:
        return "Manual"
    if block[f"{side}AutoReq"]:
        return "Auto"
    if block[f"{side}CasRatReq"] and block["AllowCasRat"]:
        return "CasRat"
    return next((name for name in _REGULATING if block[name]), "Manual")


def _choose_mode(loop: _PidLoop) -> None:
    """Set the mode.

    Hand and Override have the highest precedence. Next is Manual after a fault or initialization, then the
    requested mode.
    """
    block = loop.block
    mode = _requested_mode(loop)
    if mode == "CasRat" and not block["AllowCasRat"]:
        mode = "Auto"
    if loop.bad_pv or loop.bad_cv or (loop.initializing and block.on("ManualAfterInit")):
        mode = "Manual"
    if block["ProgHandReq"]:
        mode = "Hand"
    elif block["ProgOverrideReq"]:
        mode = "Override"
    loop.mode = mode
    block.set(**{name: name == mode for name in _MODES})


def _set_ratio(loop: _PidLoop) -> float:
    """Set Ratio within its limits, with its alarms and faults; return it."""
    block = loop.block
    low, high = block.real("RatioLLimit"), block.real("RatioHLimit")
    block.wrong(RatioLimitsInv=low < 0 or high < low)
    low = max(low, 0.0)
    name = loop.of_control("Ratio")
    ratio = block.real(name)
    block.set(RatioHAlarm=ratio > high, RatioLAlarm=ratio < low)
    block.wrong(**{f"{name}Inv": not low <= ratio <= high})
    ratio = max(min(ratio, high), low)
    block.set(Ratio=ratio)
    if loop.program:
        block.set(RatioOper=block["RatioProg"])
    return ratio


def _set_point(loop: _PidLoop) -> None:
    """Set SP and the error, in units and in percent of the span of PV."""
    block = loop.block
    ratio = _set_ratio(loop)
    cascade = loop.mode == "CasRat"
    name = "SPCascade" if cascade else loop.of_control("SP")
    point = block.real(name) * (ratio if cascade and block["UseRatio"] else 1.0)
    if block["PVTracking"] and loop.mode == "Manual" and not loop.bad_pv:
        point = block.real("PV")
        block.set(SPProg=point, SPOper=point)
    low, high = block.real("SPLLimit"), block.real("SPHLimit")
    loop.setpoint_high, loop.setpoint_low = point > high, point < low
    block.wrong(**{f"{name}Inv": not low <= point <= high})
    point = max(min(point, high), low)
    block.set(SP=point, SPHAlarm=loop.setpoint_high, SPLAlarm=loop.setpoint_low)
    if loop.program or cascade:
        block.set(SPOper=point)
    if not block.wrong(PVSpanInv=not block["PVEUMin"] < block["PVEUMax"]):
        _set_error(loop, point)


def _set_error(loop: _PidLoop, point: float) -> None:
    """Set the error, SP and PV in percent of the span of PV, and E in units."""
    block = loop.block
    value, low = block.real("PV"), block.real("PVEUMin")
    span = block.real("PVEUMax") - low
    error = value - point if block["ControlAction"] else point - value
    loop.error = error * 100 / span
    block.set(E=error, EPercent=loop.error)
    block.set(SPPercent=(point - low) * 100 / span, PVPercent=(value - low) * 100 / span)


def _past_errors(loop: _PidLoop, present: dict[str, float]) -> dict[str, tuple[float, float]]:
    """Return the last two values of the error and of PV, newest first; store the present values.

    Args:
        present: present values of the error ("e") and of PV ("q"), in percent.
    """
    block = loop.block
    if block.first:
        block.set(**{f"~{name}{n}": value for name, value in present.items() for n in (1, 2)})
    past = {name: (block.real(f"~{name}1"), block.real(f"~{name}2")) for name in present}
    if block.delta_t > 0 and not loop.bad_pv and math.isfinite(loop.error):
        block.set(**{f"~{name}2": values[0] for name, values in past.items()})
        block.set(**{f"~{name}1": value for name, value in present.items()})
    return past


def _change(loop: _PidLoop) -> float:
    """Return the change of CV, in percent, due to the gains; store errors and PV for the next calls."""
    block, seconds = loop.block, loop.block.delta_t
    p_gain, i_gain, d_gain = (block.limited(f"{term}Gain", 0.0, math.inf) for term in "PID")
    signed_pv = block.real("PVPercent") * (1 if block["ControlAction"] else -1)  # rises as the error
    present = {"e": loop.error, "q": signed_pv}
    past = _past_errors(loop, present)
    in_deadband = _in_deadband(loop, past["e"][0])
    if seconds <= 0 or not loop.regulates or loop.initializing or in_deadband:
        return 0.0
    p_input, d_input = ("q" if block[f"PVE{term}"] else "e" for term in ("Proportional", "Derivative"))
    step = present[p_input] - past[p_input][0]
    last, second_last = past[d_input]
    bend = 60 * (present[d_input] - 2 * last + second_last) / seconds
    area = loop.error * seconds / 60
    if block["DependIndepend"]:
        return p_gain * (step + (area / i_gain if i_gain else 0.0) + d_gain * bend)
    return p_gain * step + i_gain * area + d_gain * bend


def _in_deadband(loop: _PidLoop, previous_error: float) -> bool:
    """Return whether the error is too small to change CV, and set ZCDeadbandOn accordingly.

    Without ZCOff, the error counts as too small only after it has crossed zero.
    """
    block = loop.block
    band = block.limited("ZCDeadband", 0.0, math.inf)
    inside = band > 0 and abs(block.real("E")) <= band
    crossed = loop.error * previous_error <= 0 or block.on("ZCDeadbandOn")
    in_deadband = inside and (block.on("ZCOff") or crossed) and not loop.bad_pv
    block.set(ZCDeadbandOn=in_deadband)
    return in_deadband


def _feed_forward(loop: _PidLoop) -> float:
    """Return the change in feedforward; if no time has passed, save it for the next call."""
    block = loop.block
    value = block.limited("FF", -100.0, 100.0)
    if block.delta_t <= 0 and not block.first:
        return 0.0
    previous_value = value if block.first else block.real("~ff")
    if block["FFSetPrevious"]:
        previous_value = block.limited("FFPrevious", -100.0, 100.0)
    block.set(**{"~ff": value})
    return value - previous_value


def _select_cv(loop: _PidLoop) -> tuple[float, float]:
    """Return CV for the mode, before limits, and the previous CV."""
    block = loop.block
    change = _change(loop) + _feed_forward(loop)
    previous_cv = block.real("CV")
    if loop.initializing:
        span = block.real("CVEUMax") - block.real("CVEUMin")
        cv = (block.real("CVInitValue") - block.real("CVEUMin")) * 100 / span
        return max(min(cv, 100.0), 0.0), previous_cv
    if loop.mode == "Hand":
        faulted = block.wrong(HandFBFaulted=block.on("HandFBFault"))
        return previous_cv if faulted else block.limited("HandFB", 0.0, 100.0), previous_cv
    if loop.mode == "Override":
        return block.limited("CVOverride", 0.0, 100.0), previous_cv
    if loop.mode == "Manual":
        return block.limited(loop.of_control("CV"), 0.0, 100.0), previous_cv
    if block["CVSetPrevious"]:
        previous_cv = block.limited("CVPrevious", 0.0, 100.0)
    cv = previous_cv + change if block.delta_t > 0 else previous_cv
    return previous_cv if block.forbids(cv - previous_cv, "WindupHIn", "WindupLIn") else cv, previous_cv


def _limit_change(loop: _PidLoop, cv: float, previous_cv: float) -> tuple[float, bool]:
    """Return CV limited by its rate of change, and whether it was limited."""
    block = loop.block
    rate = block.limited("CVROCLimit", 0.0, math.inf)
    limiting = loop.regulates or (loop.mode == "Manual" and block.on("CVManLimiting"))
    if not limiting or loop.initializing:
        return cv, False
    cv = max(min(cv, block.real("CVHLimit")), block.real("CVLLimit"))
    limit = rate * block.delta_t
    is_fast = rate > 0 and abs(cv - previous_cv) > limit and block.delta_t > 0
    return max(min(cv, previous_cv + limit), previous_cv - limit) if is_fast else cv, is_fast


def _show_cv(loop: _PidLoop, cv: float) -> None:
    """Set CVEU, and CVOper for a bumpless change to Operator Manual."""
    block = loop.block
    if loop.initializing:
        block.set(CVEU=block["CVInitValue"])
    elif not block.wrong(CVEUSpanInv=block["CVEUMax"] == block["CVEUMin"]):
        span = block.real("CVEUMax") - block.real("CVEUMin")
        block.set(CVEU=cv * span / 100 + block.real("CVEUMin"))
    if loop.program or loop.mode != "Manual":
        block.set(CVOper=block["CV"])


def _limit_cv(loop: _PidLoop) -> None:
    """Limit CV; set CV and CVEU, their alarms, and the bits for other loops."""
    block = loop.block
    cv, previous_cv = _select_cv(loop)
    low, high = block.real("CVLLimit"), block.real("CVHLimit")
    block.wrong(CVLimitsInv=not 0 <= low <= high <= 100)
    above, below = cv > high or cv > 100, cv < low or cv < 0
    if block.first:
        above = below = False
    cv, is_fast = _limit_change(loop, max(min(cv, 100.0), 0.0), previous_cv)
    if not math.isfinite(cv):
        cv = previous_cv
    block.set(CV=cv, CVROCAlarm=is_fast, CVInitializing=loop.initializing, CVHAlarm=above, CVLAlarm=below)
    _show_cv(loop, cv)
    above, below = (below, above) if block["ControlAction"] else (above, below)
    block.set(
        InitPrimary=loop.mode != "CasRat" or loop.initializing,
        WindupHOut=loop.setpoint_high or above,
        WindupLOut=loop.setpoint_low or below,
    )


def _deviation_limits(block: FunctionBlock) -> dict[str, float]:
    """Return the limits of the deviation by level; note a fault if they are not in order."""
    limits = {name: block.real(f"Dev{name}Limit") for name in ALARM_LEVELS}
    ordered = limits["HH"] >= limits["H"] >= 0 and limits["LL"] >= limits["L"] >= 0
    block.wrong(DevHLLimitsInv=not ordered)
    return limits


def _alarms(loop: _PidLoop) -> None:
    """Set the alarms of PV and of its deviation from SP.

    In the first scan or without a valid PV, clear them.
    """
    block = loop.block
    band, deviation_band = (block.limited(f"{name}Deadband", 0.0, math.inf) for name in ("PV", "Dev"))
    rates = [block.real(f"PVROC{name}") for name in ("PosLimit", "NegLimit", "Period")]
    block.wrong(PVROCLimitsInv=any(not rate >= 0 for rate in rates))
    deviations = _deviation_limits(block)
    value, point = block.real("PV"), block.real("SP")
    if block.first or loop.bad_pv:
        block.set(**dict.fromkeys(_ALARMS, False))
        rate_alarms(block, value, "PV", first=True)
        return
    level_alarms(
        block, value, "PV", {deviation: block.real(f"PV{deviation}Limit") for deviation in deviations}, band
    )
    around = {
        deviation: point + (limit if deviation.startswith("H") else -limit)
        for deviation, limit in deviations.items()
    }
    level_alarms(block, value, "Dev", around, deviation_band)
    rate_alarms(block, value, "PV", first=False)


def _regulate(block: FunctionBlock) -> float:
    """Run one call of PIDE; return CV."""
    loop = _PidLoop(block, block.control())
    _note_faults(loop)
    _choose_mode(loop)
    _set_point(loop)
    _limit_cv(loop)
    _alarms(loop)
    return block.real("CV")


PIDE = block_row("PIDE", _regulate)
