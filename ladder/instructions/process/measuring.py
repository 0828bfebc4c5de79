"""Blocks that monitor, select, average and totalize measured values [1756-RM006K, the page of each].

| block | function |
|---|---|
| ALM | level alarms with a deadband, and rate alarms of samples ROCPeriod apart |
| ESEL | one of six values by number, or the highest, lowest, median or mean of values without a fault |
| MAVE, MSTD | the average, weighted or not, and the standard deviation of the last samples |
| TOT | the total of a flow by the trapezoidal rule in double precision, with targets and a low cutoff |
"""

from __future__ import annotations

import math
import struct

from ...interpreter.files import Elements
from ...model.types import ALARM_LEVELS
from .function_block import NS_PER_S, FunctionBlock, block_row


def level_alarms(
    block: FunctionBlock, value: float, prefix: str, limits: dict[str, float], band: float
) -> None:
    """Set the level alarms; each stays on until the value has returned by more than the deadband.

    Args:
        block: the block.
        value: the value.
        prefix: prefix of the alarms' names.
        limits: limits by level, HH to LL.
        band: the deadband, at least 0.
    """
    for name, limit in limits.items():
        alarm = f"{prefix}{name}Alarm"
        sign = 1 if name.startswith("H") else -1
        beyond = sign * value >= sign * limit
        block.set(**{alarm: beyond or (block.on(alarm) and sign * value >= sign * limit - band)})


def rate_alarms(block: FunctionBlock, value: float, prefix: str, *, first: bool) -> float | None:
    """Set the alarms of a rate, from samples ROCPeriod apart.

    Returns:
        The new rate in units/s, or None if no period has ended.
    """
    period, up, down = (block.real(f"{prefix}ROC{name}") for name in ("Period", "PosLimit", "NegLimit"))
    now = block.machine.now_ns
    if first or not 0 < period <= 32767.0:
        block.set(**{"~sampled_ns": now, "~sample": value})
        if first or period == 0:
            block.set(**{f"{prefix}ROCPosAlarm": False, f"{prefix}ROCNegAlarm": False})
        return None
    elapsed = (now - int(block["~sampled_ns"])) / NS_PER_S
    if elapsed < period:
        return None
    rate = (value - block.real("~sample")) / elapsed
    block.set(**{"~sampled_ns": now, "~sample": value})
    block.set(**{f"{prefix}ROCPosAlarm": rate >= up > 0, f"{prefix}ROCNegAlarm": -rate >= down > 0})
    return rate


def _alarm(block: FunctionBlock) -> float:
    """Run one call of ALM; return ROC."""
    value = block.real("In")
    band = block.limited("Deadband", 0.0, math.inf)
    level_alarms(block, value, "", {name: block.real(f"{name}Limit") for name in ALARM_LEVELS}, band)
    for name, limit in (("ROCPosLimit", math.inf), ("ROCNegLimit", math.inf), ("ROCPeriod", 32767.0)):
        block.limited(name, 0.0, limit)  # only notes a fault
    rate = rate_alarms(block, value, "", first=block.first)
    if rate is not None:
        block.set(ROC=rate)
    return block.real("ROC")


# --- ESEL

_MANUAL, _HIGH, _LOW, _MEDIAN, _AVERAGE = range(5)
_MOST_INPUTS = 6


def _select_input(block: FunctionBlock) -> float:
    """Run one call of ESEL; return Out, which stays the same if no input can be selected."""
    program = block.control()
    override = block.on("ProgOverrideReq")
    block.set(Override=override)
    mode, used = int(block["SelectorMode"]), int(block["InsUsed"])
    invalid = block.wrong(InsUsedInv=not 1 <= used <= _MOST_INPUTS)
    input_count = _MOST_INPUTS if invalid else used
    faulted = [block.on(f"In{number}Fault") for number in range(1, input_count + 1)]
    block.wrong(InsFaulted=any(faulted), SelectorModeInv=not _MANUAL <= mode <= _AVERAGE)
    chosen = {name: int(block[name]) for name in ("ProgSelector", "OperSelector")}
    block.wrong(**{f"{name}Inv": not 0 <= number <= input_count for name, number in chosen.items()})
    if override or mode == _MANUAL:
        number = chosen["ProgSelector" if program else "OperSelector"]
        if 1 <= number <= input_count:
            block.set(Out=block[f"In{number}"], SelectedIn=number)
    elif not invalid and _MANUAL < mode <= _AVERAGE:
        _select_by_mode(block, mode, faulted)
    return block.real("Out")


def _select_by_mode(block: FunctionBlock, mode: int, faulted: list[bool]) -> None:
    """Set Out and SelectedIn from any inputs without a fault; for a mean, SelectedIn is 0."""
    numbers = [number for number, bad in enumerate(faulted, start=1) if not bad]
    if not numbers:
        return
    values = {number: block.real(f"In{number}") for number in numbers}
    ranked = sorted(numbers, key=lambda number: (values[number], number))
    middle = len(ranked) // 2
    if mode == _AVERAGE:
        out, selected = sum(values.values()) / len(values), 0
    elif mode == _MEDIAN and len(ranked) % 2 == 0:
        out, selected = (values[ranked[middle - 1]] + values[ranked[middle]]) / 2, 0
    else:
        if mode == _MEDIAN:
            selected = ranked[middle]
        else:
            selected = (max if mode == _HIGH else min)(numbers, key=values.__getitem__)
        out = values[selected]
    block.set(Out=out, SelectedIn=selected)


# --- MAVE, MSTD


def _samples(block: FunctionBlock, capacity: int) -> list[float] | None:
    """Take a sample; return the samples, newest first, or None if they do not determine Out."""
    value, count = block.real("In"), int(block["NumberOfSamples"])
    faulted, invalid_count = block.on("InFault"), not 1 <= count <= capacity
    if block.wrong(InFaulted=faulted, NumberOfSampInv=invalid_count):
        block.set(**{"~held": 0})
        return None
    if block["Initialize"] or not math.isfinite(value):
        block.set(Out=value, **{"~held": 0})
        return None
    if block.first:
        block.set(**{"~held": 0})
    if not block["SampleEnable"]:
        return None
    storage = block.arrays[0]
    held = min(int(block["~held"]) + 1, count)
    if held > 1:
        storage.put(1, storage.take(0, held - 1), held - 1)
    storage[0] = block.rounded(value)
    block.set(**{"~held": held})
    return _reals(storage, held)


def _reals(array: Elements, count: int) -> list[float]:
    """Return the first `count` elements of an array of REAL, at least one."""
    return list(struct.unpack(f"<{count}f", array.take(0, count)))


def _average(block: FunctionBlock) -> float:
    """Run one call of MAVE; return Out, the mean of the samples, or with weights their weighted sum."""
    weighted = block.on("UseWeights") and len(block.arrays) > 1
    samples = _samples(block, min(map(len, block.arrays if weighted else block.arrays[:1])))
    if samples is not None:
        weights = _reals(block.arrays[1], len(samples)) if weighted else None
        if weights is None:
            block.set(Out=sum(samples) / len(samples))
        else:
            block.set(Out=sum(sample * weight for sample, weight in zip(samples, weights, strict=True)))
    return block.real("Out")


def _deviation(block: FunctionBlock) -> float:
    """Run one call of MSTD, which sets Average and Out; return Out, the standard deviation."""
    samples = _samples(block, len(block.arrays[0]))
    if samples is not None:
        mean = sum(samples) / len(samples)
        squares = sum((sample - mean) * (sample - mean) for sample in samples)
        block.set(Average=mean, Out=math.sqrt(squares / len(samples)) if math.isfinite(squares) else math.inf)
    return block.real("Out")


# --- TOT

_UNIT_S = (1, 60, 3600, 86_400)


def _total(block: FunctionBlock) -> float:
    """Run one call of TOT: read the requests, add the flow, and set the flags; return Total.

    The first call after a start adds nothing, because the flow needs a previous value.
    """
    if block.new:
        total = block.real("ResetValue")
        block.set(Total=total, OldTotal=0.0, **{"~exact": total})
    program = block.control()
    value, base = block.real("In"), int(block["TimeBase"])
    unusable = block.wrong(InFaulted=block.on("InFault"), TimeBaseInv=not 0 <= base < len(_UNIT_S))
    _reset_total(block, program=program)
    _start_and_stop(block, program=program)
    low = value <= block.real("LowInCutoff")
    block.set(LowInCutoffFlag=low)
    runs, ran_before = block.on("RunStop"), block.on("~running")
    if not unusable:
        if runs and ran_before and not low and block.delta_t > 0:
            _add_flow(block, value, block.delta_t / _UNIT_S[base])
        if math.isfinite(value):
            block.set(**{"~x1": 0.0 if low else value})
    block.set(**{"~running": runs})
    total, target = block.real("Total"), block.real("Target")
    block.set(TargetFlag=total >= target)
    block.set(**{f"{name}Flag": total >= target - block.real(name) for name in ("TargetDev1", "TargetDev2")})
    return total


def _add_flow(block: FunctionBlock, value: float, units: float) -> None:
    """Add the flow during a time, given in units of TimeBase, to the total."""
    total = block.real("~exact") + block.real("Gain") * units * (value + block.real("~x1")) / 2
    if math.isfinite(total):
        block.set(**{"~exact": total})
    block.set(Total=block.real("~exact"))


def _reset_total(block: FunctionBlock, *, program: bool) -> None:
    """Reset the total on a request from the side in control; a program request needs a rising edge."""
    requested = block.on("ProgResetReq")
    by_program = program and requested and not block["~asked"]
    block.set(**{"~asked": requested}, ProgResetDone=by_program or (requested and block.on("ProgResetDone")))
    if by_program or (not program and block["OperResetReq"]):
        value = block.real("ResetValue")
        block.set(OldTotal=block["Total"], Total=value, **{"~exact": value})


def _start_and_stop(block: FunctionBlock, *, program: bool) -> None:
    """Set RunStop by the requests of the side in control; a stop has precedence."""
    side = "Prog" if program else "Oper"
    if block[f"{side}StopReq"]:
        block.set(RunStop=False)
    elif block[f"{side}StartReq"]:
        block.set(RunStop=True)


ALM = block_row("ALM", _alarm)
ESEL = block_row("ESEL", _select_input)
MAVE = block_row("MAVE", _average, optional=1)
MSTD = block_row("MSTD", _deviation)
TOT = block_row("TOT", _total)
