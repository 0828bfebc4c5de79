"""Function blocks of structured text for analog values and states [1756-RM006].

| block | function |
|---|---|
| SCL | scales raw units to engineering units; `Limiting` keeps the result within them |
| HLL | keeps a value between limits; SelectLimit 0 both, 1 the high one, 2 the low one |
| SEL, SNEG | one of two values; a value with or without its sign changed |
| MAXC, MINC | the highest, the lowest value since Reset |
| SETD, RESD | a latch that Set, or Reset, dominates |
| DFF, JKFF | on a rising Clock the value of D; the other value |
| UPDN | adds InPlus and subtracts InMinus at each call, unless Hold |
| RLIM | follows a value by IncRate and DecRate units/s at most, in the time from call to call |
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

from ...interpreter import Interpreter
from ...interpreter.files import Members
from ...model.operand_checks import require_type
from ...model.operands import Group
from ...model.predefined.block_types import BLOCKS
from ...model.spec import Spec, Use, action

FAULT = 1
"""Bit 0 of Status: InstructFault."""


def _row(name: str, step: Callable[[Interpreter, Members], None]) -> Spec:
    kind = BLOCKS[name]

    def run(machine: Interpreter, block: Group) -> None:
        members = Members(machine, block)
        members.set(EnableOut=True)
        step(machine, members)

    def prescan(machine: Interpreter, block: Group) -> None:
        begins = {"begun": False, "before": True}  # a clock that is on in the first scan is not an edge
        named = (each.name for each in kind.hidden)
        Members(machine, block).set(**{f"~{name}": begins[name] for name in named if name in begins})

    return action(
        name, Use.BLOCK, run=run, prescan=prescan, check=partial(require_type, kind=kind), in_rungs=False
    )


def _scale(_machine: Interpreter, block: Members) -> None:
    low, high, first, last = (block[name] for name in ("InRawMin", "InRawMax", "InEUMin", "InEUMax"))
    wrong = high <= low
    block.set(InstructFault=wrong, InRawRangeInv=wrong, Status=FAULT | 2 if wrong else 0)
    if wrong:
        return
    value = (block["In"] - low) * (last - first) / (high - low) + first
    bottom, top = min(first, last), max(first, last)
    block.set(MaxAlarm=value > top, MinAlarm=value < bottom)
    block.set(Out=min(max(value, bottom), top) if block["Limiting"] else value)


def _limit(_machine: Interpreter, block: Members) -> None:
    value, high, low, select = (block[name] for name in ("In", "HighLimit", "LowLimit", "SelectLimit"))
    crossed = select == 0 and high < low
    wrong = crossed or select not in (0, 1, 2)
    block.set(InstructFault=wrong, LimitsInv=crossed, SelectLimitInv=select not in (0, 1, 2))
    block.set(Status=FAULT if wrong else 0)
    if crossed:
        block.set(Out=low)
        return
    above, below = select != 2 and value >= high, select != 1 and value <= low
    block.set(HighAlarm=above, LowAlarm=below, Out=high if above else low if below else value)


def _select(_machine: Interpreter, block: Members) -> None:
    block.set(Out=block["In2"] if block["SelectorIn"] else block["In1"])


def _negate(_machine: Interpreter, block: Members) -> None:
    block.set(Out=-block["In"] if block["NegateEnable"] else block["In"])


def _capture(choose: Callable[[float, float], float]) -> Callable[[Interpreter, Members], None]:
    def step(_machine: Interpreter, block: Members) -> None:
        if block["Reset"]:
            block.set(Out=block["ResetValue"])
        elif not block["~begun"]:
            block.set(Out=block["In"])
        else:
            block.set(Out=choose(block["Out"], block["In"]))
        block.set(**{"~begun": True})

    return step


def _latch(*, set_dominates: bool) -> Callable[[Interpreter, Members], None]:
    def step(_machine: Interpreter, block: Members) -> None:
        first, second = (True, False) if set_dominates else (False, True)
        asked = {True: bool(block["Set"]), False: bool(block["Reset"])}
        out = first if asked[first] else second if asked[second] else bool(block["Out"])
        block.set(Out=out, OutNot=not out)

    return step


def _flip_flop(value: Callable[[Members], bool]) -> Callable[[Interpreter, Members], None]:
    def step(_machine: Interpreter, block: Members) -> None:
        rises = bool(block["Clock"]) and not block["~before"]
        block.set(**{"~before": block["Clock"]})
        out = bool(block["Q"])
        if block["Clear"]:
            out = False
        elif rises:
            out = value(block)
        block.set(Q=out, QNot=not out)

    return step


def _accumulate(_machine: Interpreter, block: Members) -> None:
    if block["Initialize"]:
        block.set(Out=block["InitialValue"])
    elif not block["Hold"]:
        block.set(Out=block["Out"] + block["InPlus"] - block["InMinus"])


def _follow(machine: Interpreter, block: Members) -> None:
    wrong = {f"{name}Inv": block[name] < 0 for name in ("IncRate", "DecRate")}
    seconds = (machine.now_ns - int(block["~last_ns"])) / 1e9 if block["~begun"] else 0.0
    block.set(**wrong, InstructFault=any(wrong.values()), Status=FAULT if any(wrong.values()) else 0)
    value = float(block["In"])
    if not block["ByPass"] and block["~begun"] and math.isfinite(value):
        before = float(block["~exact"])
        up, down = (max(float(block[name]), 0.0) * seconds for name in ("IncRate", "DecRate"))
        value = min(max(value, before - down), before + up)
    block.set(DeltaT=seconds, Out=value)
    block.set(**{"~begun": True, "~last_ns": machine.now_ns, "~exact": value})


SCL = _row("SCL", _scale)
RLIM = _row("RLIM", _follow)
UPDN = _row("UPDN", _accumulate)
SEL = _row("SEL", _select)
SNEG = _row("SNEG", _negate)
HLL = _row("HLL", _limit)
MAXC = _row("MAXC", _capture(max))
MINC = _row("MINC", _capture(min))
DFF = _row("DFF", _flip_flop(lambda block: bool(block["D"])))
JKFF = _row("JKFF", _flip_flop(lambda block: not block["Q"]))
RESD = _row("RESD", _latch(set_dominates=False))
SETD = _row("SETD", _latch(set_dominates=True))
