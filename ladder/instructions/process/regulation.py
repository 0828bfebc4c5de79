"""Function blocks for analog values and states without a history of samples [1756-RM006].

| block | function |
|---|---|
| SCL | scales raw units to engineering units; `Limiting` keeps the result within them |
| HLL | keeps a value between limits; SelectLimit 0 both, 1 the high one, 2 the low one |
| SEL, SNEG | one of two values; a value with or without its sign changed |
| SSUM | the sum of selected values, each with a gain |
| MAXC, MINC | the highest, the lowest value since Reset |
| SETD, RESD | a latch that Set, or Reset, dominates |
| DFF, JKFF | on a rising Clock the value of D; the other value |
| UPDN | adds InPlus and subtracts InMinus at each call, unless Hold |
| RLIM | follows a value by IncRate and DecRate units/s at most, in the time from call to call |
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from .function_block import FunctionBlock, block_row


def _scale(block: FunctionBlock) -> Any:
    low, high, first, last = (block[name] for name in ("InRawMin", "InRawMax", "InEUMin", "InEUMax"))
    if block.wrong(InRawRangeInv=high <= low):
        return None
    value = (block["In"] - low) * (last - first) / (high - low) + first
    bottom, top = min(first, last), max(first, last)
    block.set(MaxAlarm=value > top, MinAlarm=value < bottom)
    block.set(Out=min(max(value, bottom), top) if block["Limiting"] else value)
    return block["Out"]


def _limit(block: FunctionBlock) -> None:
    value, high, low, select = (block[name] for name in ("In", "HighLimit", "LowLimit", "SelectLimit"))
    crossed = select == 0 and high < low
    block.wrong(LimitsInv=crossed, SelectLimitInv=select not in (0, 1, 2))
    if crossed:
        block.set(Out=low)
        return
    above, below = select != 2 and value >= high, select != 1 and value <= low
    block.set(HighAlarm=above, LowAlarm=below, Out=high if above else low if below else value)


def _select(block: FunctionBlock) -> None:
    block.set(Out=block["In2"] if block["SelectorIn"] else block["In1"])


def _negate(block: FunctionBlock) -> None:
    block.set(Out=-block["In"] if block["NegateEnable"] else block["In"])


def _add_selected(block: FunctionBlock) -> Any:
    total = block["Bias"]
    for number in range(1, 9):
        if block[f"Select{number}"]:
            total += block[f"In{number}"] * block[f"Gain{number}"]
    block.set(Out=total)
    return block["Out"]


def _capture(choose: Callable[[float, float], float]) -> Callable[[FunctionBlock], None]:
    def step(block: FunctionBlock) -> None:
        first = block.begins()
        if block["Reset"]:
            block.set(Out=block["ResetValue"])
        else:
            block.set(Out=block["In"] if first else choose(block["Out"], block["In"]))

    return step


def _latch(*, set_dominates: bool) -> Callable[[FunctionBlock], None]:
    def step(block: FunctionBlock) -> None:
        first, second = (True, False) if set_dominates else (False, True)
        asked = {True: block.on("Set"), False: block.on("Reset")}
        out = first if asked[first] else second if asked[second] else block.on("Out")
        block.set(Out=out, OutNot=not out)

    return step


def _flip_flop(value: Callable[[FunctionBlock], bool]) -> Callable[[FunctionBlock], None]:
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
    if block["Initialize"]:
        block.set(Out=block["InitialValue"])
    elif not block["Hold"]:
        block.set(Out=block["Out"] + block["InPlus"] - block["InMinus"])
    return block["Out"]


def _follow(block: FunctionBlock) -> float:
    first = block.begins()
    seconds = block.seconds(first=first)
    block.wrong(**{f"{name}Inv": block[name] < 0 for name in ("IncRate", "DecRate")})
    value = block.real("In")
    if not block["ByPass"] and not first and math.isfinite(value):
        before = block.real("~exact")
        up, down = (max(block.real(name), 0.0) * seconds for name in ("IncRate", "DecRate"))
        value = min(max(value, before - down), before + up)
    block.set(Out=value)
    if math.isfinite(value):  # of an overflow nothing is kept
        block.set(**{"~exact": value})
    return value


SCL = block_row("SCL", _scale)
RLIM = block_row("RLIM", _follow)
UPDN = block_row("UPDN", _accumulate)
SEL = block_row("SEL", _select)
SSUM = block_row("SSUM", _add_selected)
SNEG = block_row("SNEG", _negate)
HLL = block_row("HLL", _limit)
MAXC = block_row("MAXC", _capture(max))
MINC = block_row("MINC", _capture(min))
DFF = block_row("DFF", _flip_flop(lambda block: block.on("D")))
JKFF = block_row("JKFF", _flip_flop(lambda block: not block["Q"]))
RESD = block_row("RESD", _latch(set_dominates=False))
SETD = block_row("SETD", _latch(set_dominates=True))
