r"""RMPS: a profile of ramps and soaks, such as of a batch's temperature [1756-RM006K p. 110-126].

    Out   ____      ramp to SoakValue[n] in RampValue[n] min (TimeRate), or at RampValue[n] units/min,
         /    \     then soak for SoakTime[n] min, then segment n + 1
        /      \___

Guaranteed ramp and soak: Out, or the time, waits while PV is farther from Out than a deadband. Single: after
the last segment the mode is Operator Manual or Program Hold; cyclic: segment 0 follows.

Where the manual is silent: a soak begins in the call after the one in which Out reaches its value; a fault of
PV, of an array or of NumberOfSegs in Auto changes the mode as the end of a single profile does.
"""

from __future__ import annotations

import math

from .function_block import FunctionBlock, block_row

_MS_PER_MIN = 60_000


def _mode(block: FunctionBlock, *, program: bool, first: bool) -> str:
    """Return the mode by the requests of who has control."""
    mode = next((each for each in ("Auto", "Hold") if block[each]), "Manual")
    if program:
        for each in ("Auto", "Manual", "Hold"):  # the last one has precedence
            mode = each if block[f"Prog{each}Req"] else mode
    else:
        if block["OperAutoReq"]:
            mode = "Auto"
        if block["OperManualReq"] or mode == "Hold":
            mode = "Manual"
    return "Manual" if first and mode == "Hold" and not program else mode


def _begin_segment(block: FunctionBlock, segment: int, out: float) -> None:
    times = block.arrays[2]
    block.set(CurrentSeg=segment, **{"~soaking": False, "~origin": out, "~left": float(times[segment])})


def _ramp(block: FunctionBlock, out: float, target: float, minutes: float, rate: float) -> float:
    """Return Out after a time of ramping."""
    if block["TimeRate"]:
        rate = math.inf if rate == 0 else abs(target - block.real("~origin")) / rate
    step = rate * minutes if minutes > 0 else 0.0
    return min(out + step, target) if out < target else max(out - step, target)


def _automatic(block: FunctionBlock, count: int, minutes: float) -> bool:
    """Execute the profile; return whether it continues."""
    ramps, soaks, _ = block.arrays
    segment = int(block["CurrentSeg"])
    out, target = block.real("~exact"), float(soaks[segment])
    difference = abs(out - block.real("PV"))
    if not block["~soaking"]:
        waits = block.on("GuarRamp") and difference > block.limited("RampDeadband", 0.0, math.inf)
        block.set(GuarRampOn=waits)
        if not waits:
            out = _ramp(block, out, target, minutes, float(ramps[segment]))
            block.set(**{"~exact": out})
        block.set(**{"~soaking": out == target})
        return True
    block.set(GuarRampOn=False)
    waits = block.on("GuarSoak") and difference > block.limited("SoakDeadband", 0.0, math.inf)
    block.set(GuarSoakOn=waits)
    left = block.real("~left") - (0.0 if waits else minutes)
    block.set(**{"~left": max(left, 0.0)})
    if left > 1e-9:
        return True
    if segment + 1 < count or block["CyclicSingle"]:
        _begin_segment(block, (segment + 1) % count, out)
        return True
    return False


def _manual(block: FunctionBlock, who: str, count: int) -> None:
    """Take segment, Out and soak time from the inputs of who has control."""
    segment, left = int(block[f"CurrentSeg{who}"]), block.real(f"SoakTime{who}")
    wrong = block.wrong(**{f"CurrSeg{who}Inv": not 0 <= segment < count})
    invalid = block.wrong(**{f"SoakTime{who}Inv": not 0 <= left < math.inf})
    out = block.real(f"Out{who}")
    if not wrong:
        _begin_segment(block, segment, out)
        block.set(**{"~soaking": out == float(block.arrays[1][segment])})
    if not invalid:
        block.set(**{"~left": left})
    if math.isfinite(out):
        block.set(**{"~exact": out})


def _step(block: FunctionBlock) -> float:
    ramps, _, times = block.arrays
    least = min(map(len, block.arrays))
    if not block["~ran"] and 0 <= float(times[0]) < math.inf:
        block.set(CurrentSeg=0, SoakTimeProg=times[0], SoakTimeOper=times[0])
    new = not block["~ran"]
    first = block.starts()
    minutes = block.elapsed_ms(first=first) / _MS_PER_MIN
    program = block.control()
    mode = "Manual" if new else _mode(block, program=program, first=first)
    segments = int(block["NumberOfSegs"])
    few = block.wrong(NumberOfSegsInv=not 1 <= segments <= least)
    count = least if few else segments
    usable = range(count)
    bad = block.wrong(
        PVFaulted=block.on("PVFault"),
        RampValueInv=any(not 0 <= float(ramps[n]) < math.inf for n in usable),
        SoakTimeInv=any(not 0 <= float(times[n]) < math.inf for n in usable),
    )
    stopped = "Hold" if program else "Manual"
    if mode == "Auto" and (few or bad):
        mode = stopped
    if block["Initialize"] and mode == "Manual" and not few:
        for who in ("Prog", "Oper"):
            block.set(**{f"CurrentSeg{who}": 0, f"SoakTime{who}": times[0]})
        if block["ManHoldAftInit"]:
            mode = stopped
    block.set(Initialize=False)
    who = "Prog" if program else "Oper"
    if mode == "Manual":
        _manual(block, who, count)
    if mode != "Auto":
        block.set(GuarRampOn=False, GuarSoakOn=False)
    elif int(block["CurrentSeg"]) not in usable or not _automatic(block, count, minutes):
        mode = stopped
    block.set(**{each: each == mode for each in ("Auto", "Manual", "Hold")})
    block.set(Out=block["~exact"], SoakTimeLeft=block["~left"])
    if mode != "Manual" or program:  # for a change to Operator Manual without a bump
        block.set(
            OutOper=block["Out"], CurrentSegOper=block["CurrentSeg"], SoakTimeOper=block["SoakTimeLeft"]
        )
    block.clear_requests()
    return block.real("Out")


RMPS = block_row("RMPS", _step)
