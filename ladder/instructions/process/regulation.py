"""Function blocks for analog values and states that keep no history of samples [1756-RM006].

| block | function |
|---|---|
| SCL | scales raw units to engineering units; `Limiting` keeps the result in range |
| HLL | keeps a value within limits; SelectLimit: 0 both, 1 the high limit, 2 the low limit |
| SEL, SNEG | SEL: one of two values; SNEG: a value or its negative |
| SSUM | the sum of the selected values, each with its own gain |
| MAXC, MINC | the highest or lowest value since Reset |
| SETD, RESD | a latch that Set, or Reset, dominates |
| DFF, JKFF | on a rising Clock, DFF copies D to Q, and JKFF toggles Q |
| UPDN | adds InPlus and subtracts InMinus at each call, unless Hold |
| BTDT | Target with a field of bits of Source; bits beyond the width are lost |
| FGEN | a value on a piecewise linear curve of points (X, Y) in one of two tables |
| RLIM | follows a value by at most IncRate and DecRate units/s, in the time between calls |
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any

from ...model import arithmetic
from ...model.types import DINT
from .function_block import FunctionBlock, block_row


def _scale(block: FunctionBlock) -> Any:
    """Run one call of SCL; return Out, or None if the raw range is invalid."""
    in_min, in_max, eu_min, eu_max = (block[name] for name in ("InRawMin", "InRawMax", "InEUMin", "InEUMax"))
    if block.wrong(InRawRangeInv=in_max <= in_min):
        return None
    value = (block["In"] - in_min) * (eu_max - eu_min) / (in_max - in_min) + eu_min
    bottom, top = min(eu_min, eu_max), max(eu_min, eu_max)
    block.set(MaxAlarm=value > top, MinAlarm=value < bottom)
    block.set(Out=min(max(value, bottom), top) if block["Limiting"] else value)
    return block["Out"]


def _limit(block: FunctionBlock) -> None:
    """Run one call of HLL; if the limits cross, Out is the low limit."""
    value, high, low, select = (block[name] for name in ("In", "HighLimit", "LowLimit", "SelectLimit"))
    crossed = select == 0 and high < low
    block.wrong(LimitsInv=crossed, SelectLimitInv=select not in (0, 1, 2))
    if crossed:
        block.set(Out=low)
        return
    above, below = select != 2 and value >= high, select != 1 and value <= low
    if above or below:
        value = high if above else low
    block.set(HighAlarm=above, LowAlarm=below, Out=value)


def _select(block: FunctionBlock) -> None:
    block.set(Out=block["In2"] if block["SelectorIn"] else block["In1"])


def _negate(block: FunctionBlock) -> None:
    block.set(Out=-block["In"] if block["NegateEnable"] else block["In"])


def _add_selected(block: FunctionBlock) -> Any:
    """Run one call of SSUM; return Out."""
    total = block["Bias"]
    for number in range(1, 9):
        sum_ = total + block[f"In{number}"] * block[f"Gain{number}"]
        total = block.machine.chosen(block[f"Select{number}"], sum_, total)
    block.set(Out=total)
    return block["Out"]


def _keep_extreme(choose: Callable[[float, float], float]) -> Callable[[FunctionBlock], None]:
    """Return the step of MAXC or MINC; `choose` returns the value to keep."""

    def step(block: FunctionBlock) -> None:
        if block["Reset"]:
            block.set(Out=block["ResetValue"])
        else:
            block.set(Out=block["In"] if block.first else choose(block["Out"], block["In"]))

    return step


def _latch(*, set_dominates: bool) -> Callable[[FunctionBlock], None]:
    """Return the step of SETD or RESD, a latch in which Set or Reset dominates."""

    def step(block: FunctionBlock) -> None:
        sets, resets = block.on("Set"), block.on("Reset")
        out = set_dominates if sets and resets else sets or (block.on("Out") and not resets)
        block.set(Out=out, OutNot=not out)

    return step


def _flip_flop(value: Callable[[FunctionBlock], bool]) -> Callable[[FunctionBlock], None]:
    """Return the step of DFF or JKFF; `value` returns the new Q at a rising Clock."""

    def step(block: FunctionBlock) -> None:
        rises = block.on("Clock") and not block["~before"]
        block.set(**{"~before": block["Clock"]})
        out = block.on("Q")
        if block["Clear"]:
            out = False
        elif rises:
            out = value(block)
        block.set(Q=out, QNot=not out)

    return step


def _accumulate(block: FunctionBlock) -> Any:
    """Run one call of UPDN; return Out."""
    if block["Initialize"]:
        block.set(Out=block["InitialValue"])
    elif not block["Hold"]:
        block.set(Out=block["Out"] + block["InPlus"] - block["InMinus"])
    return block["Out"]


def _follow(block: FunctionBlock) -> float:
    """Run one call of RLIM; return Out.

    ByPass, the first scan and an In that is not finite set Out to In at once.
    """
    block.wrong(**{f"{name}Inv": block[name] < 0 for name in ("IncRate", "DecRate")})
    value = block.real("In")
    if not block["ByPass"] and not block.first and math.isfinite(value):
        previous_out = block.real("~exact")
        up, down = (max(block.real(name), 0.0) * block.delta_t for name in ("IncRate", "DecRate"))
        value = min(max(value, previous_out - down), previous_out + up)
    block.set(Out=value)
    if math.isfinite(value):  # an overflow is not stored
        block.set(**{"~exact": value})
    return value


def _distribute(block: FunctionBlock) -> None:
    """Run one call of BTDT; Dest is Target if a bit number or Length is out of range."""
    source, source_bit, length, target_bit, target = (
        block.machine.whole(block[name]) for name in ("Source", "SourceBit", "Length", "DestBit", "Target")
    )
    bits = DINT.bits
    if 0 <= source_bit < bits and 0 <= target_bit < bits and 1 <= length <= bits:
        pattern = source & (1 << bits) - 1
        target = arithmetic.distributed(pattern, source_bit, target, target_bit, length, bits)
    block.set(Dest=target)


def _generate(block: FunctionBlock) -> float:
    """Interpolate in the selected table; leave Out unchanged if the table is not usable [p. 60]."""
    table = 2 if block["Select"] else 1
    points = block.arrays[2 * table - 2 : 2 * table]  # of X1, Y1, X2, Y2
    size = int(block[f"XY{table}Size"])
    capacity = min(map(len, points)) if len(points) > 1 else 0
    if block.wrong(**{f"XY{table}SizeInv": not 1 <= size <= capacity}):
        return block.real("Out")
    xs, ys = ([float(point[n]) for n in range(size)] for point in points)
    if block.wrong(XisOutofOrder=any(not a <= b for a, b in pairwise(xs))):
        return block.real("Out")
    out = _interpolated(xs, ys, block.real("In"))
    block.set(Out=out)
    return out


def _interpolated(xs: list[float], ys: list[float], value: float) -> float:
    """Return y at x = `value`; beyond the ends, use the first or last point; for NaN, return NaN."""
    right = next((n for n, x in enumerate(xs) if value <= x), None)
    if right is None:
        return ys[-1] if value > xs[-1] else value
    if right == 0:
        return ys[0]
    left = right - 1
    slope = (ys[right] - ys[left]) / (xs[right] - xs[left])
    return slope * (value - xs[left]) + ys[left]


SCL = block_row("SCL", _scale)
BTDT = block_row("BTDT", _distribute)
FGEN = block_row("FGEN", _generate, optional=2)
RLIM = block_row("RLIM", _follow)
UPDN = block_row("UPDN", _accumulate)
SEL = block_row("SEL", _select)
SSUM = block_row("SSUM", _add_selected)
SNEG = block_row("SNEG", _negate)
HLL = block_row("HLL", _limit)
MAXC = block_row("MAXC", _keep_extreme(max))
MINC = block_row("MINC", _keep_extreme(min))
DFF = block_row("DFF", _flip_flop(lambda block: block.on("D")))
JKFF = block_row("JKFF", _flip_flop(lambda block: not block["Q"]))
RESD = block_row("RESD", _latch(set_dominates=False))
SETD = block_row("SETD", _latch(set_dominates=True))
