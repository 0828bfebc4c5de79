"""POSP and SRTP: an analog value as contact pulses, one per cycle [1756-RM006K p. 104-108, 131-133].

    POSP  timer     0 _/|_/|_/|      CycleTime
          OpenOut   |‾|_|‾‾‾|__      for OpenTime = (SP% - Position%)/OpenRate, computed at the cycle's start
    SRTP  HeatOut   |‾‾|_|‾|___      for HeatTime = (In - MinHeatIn)/(MaxHeatIn - MinHeatIn) CycleTime

POSP: Deadtime is added to a pulse if the previous pulse was shorter than the cycle. A time above its maximum
    is limited; a time below its minimum produces no pulse.

The manual's equations are pictures, so the equations here are interpretations. The timers count whole ms and
carry over the excess at the end of a cycle. They start in the first scan, and POSP pulses from its second
cycle. With a span of 0, POSP keeps its percentages and does not pulse. A maximum of 0 is CycleTime.
"""

from __future__ import annotations

import math

from .function_block import MS_PER_S, FunctionBlock, block_row

_MOST_S = 1e12


def _ms(seconds: float) -> int:
    return round(min(seconds, _MOST_S) * MS_PER_S) if seconds > 0 else 0


def _time(block: FunctionBlock, name: str, default: float) -> float:
    """Return a time of 0 to `default` s; an invalid time is 0, an invalid or zero maximum is `default`."""
    value = block.real(name)
    invalid = block.wrong(**{f"{name}Inv": not 0 <= value <= default})
    if name.startswith("Max"):
        return default if invalid or value == 0 else value
    return 0.0 if invalid else value


def _cycle(block: FunctionBlock) -> tuple[float, int, bool]:
    """Advance the cycle timer.

    Returns:
        (CycleTime in s, the timer in ms, whether a cycle begins)
    """
    cycle = block.limited("CycleTime", 0.0, math.inf)
    elapsed_ms = 0 if block.first or cycle <= 0 else int(block["~timer"]) + block.elapsed_ms
    period_ms = max(_ms(cycle), 1)
    block.set(**{"~timer": elapsed_ms % period_ms})
    return cycle, elapsed_ms % period_ms, elapsed_ms >= period_ms


# --- POSP


def _percents(block: FunctionBlock) -> bool:
    """Set the percentages of the span; return whether the percentage of SP is valid."""
    low, high = block.real("PositionEUMin"), block.real("PositionEUMax")
    if block.wrong(PositionSpanInv=low == high):
        return False
    for name, percent in (("Position", "PositionPercent"), ("SP", "SPPercent")):
        block.set(**{percent: (block.real(name) - low) / (high - low) * 100})
    block.wrong(PositionPctInv=not 0 <= block.real("PositionPercent") <= 100)
    return not block.wrong(SPPercentInv=not 0 <= block.real("SPPercent") <= 100)


def _position(block: FunctionBlock) -> float:
    """Run one call of POSP; return PositionPercent.

    Pulse lengths are computed when a cycle begins.
    """
    if block.first:
        block.set(OpenTime=0.0, CloseTime=0.0)
    cycle, timer, begins = _cycle(block)
    valid = _percents(block) and cycle > 0
    longest = _time(block, "MaxOnTime", cycle)
    shortest, deadtime = _time(block, "MinOnTime", longest), _time(block, "Deadtime", longest)
    position, target = block.real("PositionPercent"), block.real("SPPercent")
    for side, distance, at_end in (
        ("Open", target - position, block.on("OpenedFB") or position >= 100),
        ("Close", position - target, block.on("ClosedFB") or position <= 0),
    ):
        rate = block.limited(f"{side}Rate", 0.0, math.inf)
        pulse = block.real(f"{side}Time")
        if at_end or rate <= 0 or not valid:
            pulse = 0.0
        elif begins:
            pulse = _pulse(distance / rate, deadtime if pulse < cycle else 0.0, shortest, longest)
        block.set(**{f"{side}Time": pulse, f"{side}Out": timer < _ms(pulse)})
    return position


def _pulse(needed: float, deadtime: float, shortest: float, longest: float) -> float:
    """Return the time of a pulse in s; 0 if it is not needed or too short."""
    pulse = min(needed + deadtime, longest) if needed > 0 else 0.0
    return pulse if pulse >= shortest else 0.0


# --- SRTP


def _split_range(block: FunctionBlock) -> float:
    """Run one call of SRTP, which sets outputs and percentages; return the sum of the percentages.

    The sum shows whether one of them overflows.
    """
    cycle, timer, _ = _cycle(block)
    value, total = block.real("In"), 0.0
    for side in ("Heat", "Cool"):
        longest = _time(block, f"Max{side}Time", cycle)
        shortest = _time(block, f"Min{side}Time", longest)
        full_in, zero_in = block.real(f"Max{side}In"), block.real(f"Min{side}In")
        pulse = 0.0
        if not block.wrong(**{f"{side}SpanInv": full_in == zero_in}):
            pulse = (value - zero_in) / (full_in - zero_in) * cycle
        pulse = 0.0 if pulse < shortest or pulse < 0 else min(pulse, longest)
        percent = pulse / cycle * 100 if cycle > 0 else 0.0
        block.set(**{f"{side}TimePercent": percent, f"{side}Out": timer < _ms(pulse)})
        total += percent
    return total


POSP = block_row("POSP", _position)
SRTP = block_row("SRTP", _split_range)
