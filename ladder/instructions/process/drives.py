r"""Drive function blocks [1756-RM006K p. 270-304; the pages of PI, PMUL and SOC were available].

| block | function |
|---|---|
| PI | Out = I + Kp In, I = I before + Kp Wld (In + In before)/2 DeltaT |
| SOC | Gain (1 + 2 ZetaLead s/WLead + (s/WLead)^2) / (s (1 + s/WLag)) |
| PMUL | Out = the change of In, or In itself, x Multiplier/100,000; the remainder is kept |
| SCRV | follows In; AccelRate and DecelRate limit the rate of Out, JerkRate its change |

                      ___________ In
    SCRV  Out      _/             Rate rises by JerkRate DeltaT a call up to AccelRate, and falls
          ________/               in time to arrive with Rate 0

The integral of PI and SOC is held while HoldHigh, HoldLow, or a limit of Out would wind it up. With the
nonlinear gains of PI, Kp becomes Kp ((Shape - 1) r + 1), where r = |In|/KpInRange up to 1, squared with
ParabolicLinear. Wld becomes the same function of WldInRange. SOC is the sum of an integral and a lag, by the
bilinear transform: with b = 1/WLead^2 and a = 2 ZetaLead/WLead - 1/WLag, its transfer function is
Gain (1/s + (a + b s)/(1 + s/WLag)). The steps of SCRV and the first scans of PMUL and SCRV are
interpretations. With a JerkRate of 0, Out of SCRV does not change.
"""

from __future__ import annotations

import math

from ...model.types import DINT, MIN_REAL
from .filters import frequency
from .function_block import FunctionBlock, block_row

_PARTS = 100_000
_MOST_PARTS = 10 * _PARTS
_MOST_EXACT = 1 << 24  # up to here, a REAL holds every integer
_MOST_SHAPE = 10.0


def _initial(block: FunctionBlock) -> float:
    """Return InitialValue, limited to Out's range."""
    low, high = block.real("LowLimit"), block.real("HighLimit")
    return min(max(block.real("InitialValue"), low), high)


def _with_limits(
    block: FunctionBlock, integral: float, last_integral: float, other_term: float
) -> tuple[float, float]:
    """Limit an integral, and Out, which is the integral plus `other_term` [p. 302-303]; set the alarms.

    Returns:
        (integral, out)
    """
    low, high = block.real("LowLimit"), block.real("HighLimit")
    crossed = block.wrong(HighLowLimsInv=not low < high)
    if not math.isfinite(integral + other_term):
        return integral, integral + other_term
    if block.forbids(integral - last_integral):
        integral = last_integral
    above, below = crossed or integral + other_term >= high, crossed or integral + other_term <= low
    block.set(HighAlarm=above, LowAlarm=below)
    if crossed:
        return low - other_term, low
    if above or below:
        return last_integral, high if above else low
    return integral, integral + other_term


def _set_out(block: FunctionBlock, out: float, **internal: float) -> float:
    """Set Out, and the internal values if they and Out are finite; return Out rounded to REAL."""
    rounded = block.rounded(out)
    block.set(Out=out)
    if all(map(math.isfinite, (rounded, *internal.values()))):
        block.set(**{f"~{name}": value for name, value in internal.items()})
    return rounded


# --- PI


def _shaped(block: FunctionBlock, name: str, gain: float, value: float) -> float:
    """Return the nonlinear gain for a value of In."""
    shapes = {
        sign: block.limited(f"Shape{name}{sign}", 0.1, _MOST_SHAPE, f"Shape{name}{sign}Inv")
        for sign in ("Plus", "Minus")
    }
    ratio = min(abs(value) / block.limited(f"{name}InRange", MIN_REAL, math.inf), 1.0)
    if block["ParabolicLinear"]:
        ratio *= ratio
    return gain * ((shapes["Minus" if value < 0 else "Plus"] - 1) * ratio + 1)


def _proportional_integral(block: FunctionBlock) -> float:
    """Run one call of PI; return Out, which stays the same if no time has passed."""
    if block.first:
        block.set(Out=0.0, **{"~x1": 0.0, "~exact": 0.0})
    value, previous_integral = block.real("In"), block.real("~exact")
    gain = block.limited("Kp", MIN_REAL, math.inf)
    lead = block.limited("Wld", MIN_REAL, 0.7 * math.pi / block.delta_t if block.delta_t > 0 else math.inf)
    if block["Initialize"]:
        initial = _initial(block)
        return _set_out(block, initial, x1=value, exact=initial)
    if block.delta_t <= 0:
        return block.real("Out")
    if block["NonLinearMode"]:
        gain, lead = _shaped(block, "Kp", gain, value), _shaped(block, "Wld", lead, value)
    integral = previous_integral + gain * lead * (value + block.real("~x1")) / 2 * block.delta_t
    integral, out = _with_limits(block, integral, previous_integral, gain * value)
    return _set_out(block, out, x1=value, exact=integral)


# --- SOC


def _second_order(block: FunctionBlock) -> float:
    """Run one call of SOC, as an integral plus a lag; return Out, unchanged if no time has passed."""
    if block.first:
        block.set(Out=0.0, **{"~x1": 0.0, "~y1": 0.0, "~exact": 0.0})
    value, previous_in, previous_integral = block.real("In"), block.real("~x1"), block.real("~exact")
    gain = block.limited("Gain", MIN_REAL, math.inf)
    lead, lag = (frequency(block, name) for name in ("WLead", "WLag"))
    zeta = block.limited("ZetaLead", 0.0, 10.0)
    if block["Initialize"]:
        initial = _initial(block)
        return _set_out(block, initial, x1=value, y1=0.0, exact=initial)
    if block.delta_t <= 0:
        return block.real("Out")
    b = 1 / (lead * lead)
    a, slope, pole = 2 * zeta / lead - 1 / lag, 2 * b / block.delta_t, 2 / (lag * block.delta_t)
    lag_term = gain * ((a + slope) * value + (a - slope) * previous_in) - (1 - pole) * block.real("~y1")
    lag_term /= 1 + pole
    integral = previous_integral + gain * (value + previous_in) / 2 * block.delta_t
    integral, out = _with_limits(block, integral, previous_integral, lag_term)
    return _set_out(block, out, x1=value, y1=lag_term, exact=integral)


# --- PMUL


def _pulses(block: FunctionBlock) -> float:
    """Run one call of PMUL; return Out.

    The change of In wraps at WordSize bits. Out is truncated toward 0, and the remainder is kept for the next
    call.
    """
    value = int(block["In"])
    size = int(block.limited("WordSize", 2, 32))
    parts = int(block.limited("Multiplier", -_MOST_PARTS, _MOST_PARTS))
    was_initializing, initialize = block.on("~initializing"), block.on("Initialize")
    block.set(**{"~initializing": initialize})
    if initialize:
        block.set(Out=0.0, **{"~before": 0, "~remainder": 0})
        return 0.0
    last_in = value if block.first else int(block["~before"])
    previous_in = int(block["InitialValue"]) if was_initializing else last_in
    remainder = 0 if block.first else int(block["~remainder"])
    half = 1 << (size - 1)
    difference = (value - previous_in + half) % (2 * half) - half if block["Mode"] else value
    total = difference * parts + remainder
    out = abs(total) // _PARTS * (1 if total >= 0 else -1)
    remainder = total - out * _PARTS
    within = min(max(out, DINT.lowest), DINT.highest)
    block.wrong(OutOverflow=out != within, LostPrecision=abs(within) > _MOST_EXACT)
    block.set(Out=float(within), **{"~before": value, "~remainder": remainder})
    return float(within)


# --- SCRV


def _highest_rate(rate: float, distance: float, limit: float, jerk: float, seconds: float) -> float:
    """Return the highest new rate, within its limits, from which Out can still reach In with rate 0.

    The next step moves (rate + new rate)/2 * seconds. From there, the stopping distance is (new rate)^2/(2
    jerk).
    """
    change = jerk * seconds
    root = seconds * seconds / 4 + 2 * (distance - rate * seconds / 2) / jerk
    fastest = jerk * (math.sqrt(root) - seconds / 2) if root > 0 else -math.inf
    return max(min(fastest, limit, rate + change), rate - change)


def _s_curve(block: FunctionBlock) -> float:
    """Run one call of SCRV: initialize or hold Out, or move it toward In; return Out."""
    target = block.real("In")
    up, down, jerk = (block.limited(f"{name}Rate", 0.0, math.inf) for name in ("Accel", "Decel", "Jerk"))
    if block.first:
        out = block.real("Out")
        block.set(**{"~exact": out if math.isfinite(out) else 0.0, "~rate": 0.0})
    if block["Initialize"]:
        return _set_out_and_rate(block, block.real("InitialValue"), 0.0)
    if block.delta_t <= 0:
        return block.real("Out")
    if not math.isfinite(target):
        return _set_out(block, target)
    if jerk <= 0 or (block["HoldEnable"] and block["HoldMode"]):
        return _set_out_and_rate(block, block.real("~exact"), 0.0)
    return _follow(block, target, up, down, jerk)


def _follow(block: FunctionBlock, target: float, up: float, down: float, jerk: float) -> float:
    """Move Out toward In, or to rest with HoldEnable; return Out.

    AccelRate limits a motion away from 0 with AbsAlgRamp, otherwise an upward motion. DecelRate limits all
    other motions.
    """
    out, rate, seconds = block.real("~exact"), block.real("~rate"), block.delta_t
    held = block.on("HoldEnable")
    sign = math.copysign(1, rate if held else target - out)
    speeds_up = out * sign >= 0 if block["AbsAlgRamp"] else sign > 0
    limit = up if speeds_up else down
    if held:
        step, new_rate = _braking_step(rate * sign, limit, jerk, seconds)
        out += sign * step
    else:
        distance = abs(target - out)
        step, new_rate = _step_toward(rate * sign, distance, limit, jerk, seconds)
        out = target if step == distance else out + sign * step
    block.set(S_Mode=jerk * seconds < limit and 0 < new_rate < limit)
    return _set_out_and_rate(block, out, new_rate * sign)


def _braking_step(rate: float, limit: float, jerk: float, seconds: float) -> tuple[float, float]:
    """Return the change of Out in a step with a falling rate, and the new rate."""
    if jerk * seconds >= limit:
        return 0.0, 0.0
    new_rate = max(rate - jerk * seconds, 0.0)
    return (rate + new_rate) / 2 * seconds, new_rate


def _step_toward(
    rate: float, distance: float, most: float, jerk: float, seconds: float
) -> tuple[float, float]:
    """Return the change of Out toward In in one step, and the new rate."""
    change = jerk * seconds
    if change >= most:
        step = min(most * seconds, distance)
        return step, most if step < distance else 0.0
    new_rate = _highest_rate(rate, distance, most, jerk, seconds)
    if new_rate <= 0 <= rate <= change:
        return distance, 0.0
    return (rate + new_rate) / 2 * seconds, new_rate


def _set_out_and_rate(block: FunctionBlock, value: float, rate: float) -> float:
    """Set Out and Rate; return Out."""
    block.set(Rate=rate)
    return _set_out(block, value, exact=value, rate=rate)


PI = block_row("PI", _proportional_integral)
PMUL = block_row("PMUL", _pulses)
SCRV = block_row("SCRV", _s_curve)
SOC = block_row("SOC", _second_order)
