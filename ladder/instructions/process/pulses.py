"""POSP and SRTP: an analog value as contact pulses, one per cycle [1756-RM006K p. 104-108, 131-133].

    POSP  timer     0 _/|_/|_/|      CycleTime
          OpenOut   |‾|_|‾‾‾|__      for OpenTime = (SP% - Position%)/OpenRate, computed at the cycle's begin
    SRTP  HeatOut   |‾‾|_|‾|___      for HeatTime = (In - MinHeatIn)/(MaxHeatIn - MinHeatIn) CycleTime

POSP: Deadtime is added to a pulse if the previous pulse was shorter than the cycle. A time above its maximum
    is limited; a time below its minimum gives no pulse.

The manual's equations are pictures, so the equations here are interpretations. The timers count whole ms, and
carry over the excess at the end of a cycle. They start in the first scan, and POSP pulses from its second
cycle. With a span of 0, the percentages of POSP stay, and there is no pulse. A maximum of 0 means CycleTime.
"""

from __future__ import annotations

import math

from .function_block import MS_PER_S, FunctionBlock, block_row

_MOST_S = 1e12


def _ms(seconds: float) -> int:
    return round(min(seconds, _MOST_S) * MS_PER_S) if seconds > 0 else 0


def _time(block: FunctionBlock, name: str, most: float) -> float:
    """Return a time in s; an invalid time is 0, and a maximum that is 0 or invalid is `most`."""
    value = block.real(name)
    invalid = block.wrong(**{f"{name}Inv": not 0 <= value <= most})
    if name.startswith("Max"):
        return most if invalid or value == 0 else value
    return 0.0 if invalid else value


def _cycle(block: FunctionBlock) -> tuple[float, int, bool]:
    """Advance the cycle timer.

    Returns:
        (CycleTime in s, the timer in ms, whether it has begun a cycle)
    """
    cycle = block.limited("CycleTime", 0.0, math.inf)
    passed = 0 if block.first or cycle <= 0 else int(block["~timer"]) + block.elapsed_ms
    period = max(_ms(cycle), 1)
    block.set(**{"~timer": passed % period})
    return cycle, passed % period, passed >= period


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
    if block.first:
        block.set(OpenTime=0.0, CloseTime=0.0)
    cycle, timer, begins = _cycle(block)
    valid = _percents(block) and cycle > 0
    most = _time(block, "MaxOnTime", cycle)
    least, dead = _time(block, "MinOnTime", most), _time(block, "Deadtime", most)
    position, target = block.real("PositionPercent"), block.real("SPPercent")
    for side, distance, ended in (
        ("Open", target - position, block.on("OpenedFB") or position >= 100),
        ("Close", position - target, block.on("ClosedFB") or position <= 0),
    ):
        rate = block.limited(f"{side}Rate", 0.0, math.inf)
        pulse = block.real(f"{side}Time")
        if ended or rate <= 0 or not valid:
            pulse = 0.0
        elif begins:
            pulse = _pulse(distance / rate, dead if pulse < cycle else 0.0, least, most)
        block.set(**{f"{side}Time": pulse, f"{side}Out": timer < _ms(pulse)})
    return position


def _pulse(needed: float, dead: float, least: float, most: float) -> float:
    """Return the time of a pulse in s; 0 if it is not needed or too short."""
    pulse = min(needed + dead, most) if needed > 0 else 0.0
    return pulse if pulse >= least else 0.0


# --- SRTP


def _split_range(block: FunctionBlock) -> float:
    cycle, timer, _ = _cycle(block)
    value, total = block.real("In"), 0.0
    for side in ("Heat", "Cool"):
        most = _time(block, f"Max{side}Time", cycle)
        least = _time(block, f"Min{side}Time", most)
        full, none = block.real(f"Max{side}In"), block.real(f"Min{side}In")
        pulse = 0.0
        if not block.wrong(**{f"{side}SpanInv": full == none}):
            pulse = (value - none) / (full - none) * cycle
        pulse = 0.0 if pulse < least or pulse < 0 else min(pulse, most)
        percent = pulse / cycle * 100 if cycle > 0 else 0.0
        block.set(**{f"{side}TimePercent": percent, f"{side}Out": timer < _ms(pulse)})
        total += percent
    return total


POSP = block_row("POSP", _position)
SRTP = block_row("SRTP", _split_range)
