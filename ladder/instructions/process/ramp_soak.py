r"""RMPS: a profile of ramps and soaks, such as the temperature of a batch [1756-RM006K p. 110-126].

    Out   ____      ramp to SoakValue[n] in RampValue[n] min (TimeRate), or at RampValue[n] units/min,
         /    \     then soak for SoakTime[n] min, then segment n + 1
        /      \___

With guaranteed ramp, Out waits while PV is farther from Out than a deadband; with guaranteed soak, the soak
time does. In a single profile, the mode after the last segment is Operator Manual or Program Hold. In a
cyclic profile, segment 0 follows.

Where the manual is silent: a soak begins in the call after Out reaches its value. In Auto, a fault of PV, an
array or NumberOfSegs changes the mode as the end of a single profile does.
"""

from __future__ import annotations

import math

from .function_block import FunctionBlock, block_row

_MS_PER_MIN = 60_000


_SIDES = {True: ("Prog", "Hold"), False: ("Oper", "Manual")}
"""Prefix of inputs, and mode after the end or a fault, for program control (True) and operator control."""


def _is_usable(value: float) -> bool:
    return 0 <= float(value) < math.inf


def _mode(block: FunctionBlock, *, program: bool) -> str:
    """Return the mode that the side in control requests; a new block is in Manual."""
    if block.new:
        return "Manual"
    mode = next((name for name in ("Auto", "Hold") if block[name]), "Manual")
    if program:  # the first has precedence
        return next((name for name in ("Hold", "Manual", "Auto") if block[f"Prog{name}Req"]), mode)
    if block["OperManualReq"]:
        return "Manual"
    return "Auto" if mode == "Auto" or block["OperAutoReq"] else "Manual"


def _begin_segment(block: FunctionBlock, segment: int, out: float) -> None:
    """Begin a segment: its ramp starts at `out`, and its full soak time remains."""
    times = block.arrays[2]
    block.set(CurrentSeg=segment, **{"~soaking": False, "~origin": out, "~left": float(times[segment])})


def _ramp(block: FunctionBlock, out: float, target: float, minutes: float, rate: float) -> float:
    """Return Out after `minutes` of a ramp; `rate` is in units/min, or with TimeRate, a time in min."""
    if block["TimeRate"]:
        rate = math.inf if rate == 0 else abs(target - block.real("~origin")) / rate
    step = rate * minutes if minutes > 0 else 0.0
    return min(out + step, target) if out < target else max(out - step, target)


def _automatic(block: FunctionBlock, count: int) -> bool:
    """Execute one call of the profile; return whether it continues.

    Out ramps until it equals the soak value. The next calls soak, and then the next segment begins.
    """
    minutes = block.elapsed_ms / _MS_PER_MIN
    ramps, soaks, _ = block.arrays
    segment = int(block["CurrentSeg"])
    if segment not in range(count):
        return False
    out, target = block.real("~exact"), float(soaks[segment])
    deviation = abs(out - block.real("PV"))
    if not block["~soaking"]:
        waits = block.on("GuarRamp") and deviation > block.limited("RampDeadband", 0.0, math.inf)
        block.set(GuarRampOn=waits)
        if not waits:
            out = _ramp(block, out, target, minutes, float(ramps[segment]))
            block.set(**{"~exact": out})
        block.set(**{"~soaking": out == target})
        return True
    block.set(GuarRampOn=False)
    waits = block.on("GuarSoak") and deviation > block.limited("SoakDeadband", 0.0, math.inf)
    block.set(GuarSoakOn=waits)
    soak_left = block.real("~left") - (0.0 if waits else minutes)
    block.set(**{"~left": max(soak_left, 0.0)})
    if soak_left > 1e-9:  # min; anything less is a rounding error
        return True
    if segment + 1 < count or block["CyclicSingle"]:
        _begin_segment(block, (segment + 1) % count, out)
        return True
    return False


def _manual(block: FunctionBlock, side: str, count: int) -> None:
    """Set segment, Out and soak time from the inputs of the side in control."""
    segment, soak_time = int(block[f"CurrentSeg{side}"]), block.real(f"SoakTime{side}")
    out_of_range = block.wrong(**{f"CurrSeg{side}Inv": not 0 <= segment < count})
    invalid = block.wrong(**{f"SoakTime{side}Inv": not 0 <= soak_time < math.inf})
    out = block.real(f"Out{side}")
    if not out_of_range:
        _begin_segment(block, segment, out)
        block.set(**{"~soaking": out == float(block.arrays[1][segment])})
    if not invalid:
        block.set(**{"~left": soak_time})
    if math.isfinite(out):
        block.set(**{"~exact": out})


def _initialize(block: FunctionBlock) -> bool:
    """On Initialize, reset the segment and soak time inputs; return whether Manual ends."""
    if not block["Initialize"]:
        return False
    for side in ("Prog", "Oper"):
        block.set(**{f"CurrentSeg{side}": 0, f"SoakTime{side}": block.arrays[2][0]})
    return block.on("ManHoldAftInit")


def _check(block: FunctionBlock) -> tuple[int, bool, bool]:
    """Note the faults of the profile and of PV.

    Returns:
        The number of usable segments, whether NumberOfSegs is valid, and whether Auto is possible.
    """
    ramps, _, times = block.arrays
    segments, most = int(block["NumberOfSegs"]), min(map(len, block.arrays))
    valid = not block.wrong(NumberOfSegsInv=not 1 <= segments <= most)
    count = segments if valid else most
    faulted = block.wrong(
        PVFaulted=block.on("PVFault"),
        RampValueInv=not all(_is_usable(ramps[n]) for n in range(count)),
        SoakTimeInv=not all(_is_usable(times[n]) for n in range(count)),
    )
    return count, valid, valid and not faulted


def _show(block: FunctionBlock, mode: str, *, program: bool) -> None:
    """Set the mode bits, Out and SoakTimeLeft, and let the operator's inputs follow."""
    block.set(**{name: name == mode for name in ("Auto", "Manual", "Hold")})
    block.set(Out=block["~exact"], SoakTimeLeft=block["~left"])
    if mode != "Manual" or program:  # for a bumpless change to Operator Manual
        block.set(
            OutOper=block["Out"], CurrentSegOper=block["CurrentSeg"], SoakTimeOper=block["SoakTimeLeft"]
        )


def _step(block: FunctionBlock) -> float:
    """Run one call of RMPS: choose the mode, then execute and show it; return Out."""
    times = block.arrays[2]
    if block.new and _is_usable(times[0]):
        block.set(CurrentSeg=0, SoakTimeProg=times[0], SoakTimeOper=times[0])
    program = block.control()
    side, stopped = _SIDES[program]
    mode = _mode(block, program=program)
    count, valid, runnable = _check(block)
    if mode == "Auto" and not runnable:
        mode = stopped
    if mode == "Manual" and valid and _initialize(block):
        mode = stopped
    block.set(Initialize=False)
    if mode == "Manual":
        _manual(block, side, count)
    if mode != "Auto":
        block.set(GuarRampOn=False, GuarSoakOn=False)
    elif not _automatic(block, count):
        mode = stopped
    _show(block, mode, program=program)
    return block.real("Out")


RMPS = block_row("RMPS", _step)
