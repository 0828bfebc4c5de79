"""D2SD and D3SD: a device of two or three states with feedback [1756-RM006K p. 28-50].

    mode                      commanded state
    Hand (ProgHandReq)        HandFB; with three states the only HandFB that is set
    Override                  OverrideState; by ProgOverrideReq, OverrideOnInit, an alarm with OverrideOnFault
    Program, Operator         the only command or request that is set, if the state's permissive is set

More than one command is a fault, and the state does not change. A commanded change starts the fault timer;
the feedback of the state stops it. Where the manual is silent: the first scan also starts the timer, and an
override by an alarm gives the operator control.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from .function_block import FunctionBlock, block_row

_NS_PER_S = 1_000_000_000


def _only_set_bit(block: FunctionBlock, names: list[str], fault: str) -> int | None:
    """Return the number of the one bit that is set; None if no bit or, with a fault, several bits are set."""
    numbers = [number for number, name in enumerate(names) if block[name]]
    block.wrong(**{fault: len(numbers) > 1})
    return numbers[0] if len(numbers) == 1 else None


def _mode_alarm(block: FunctionBlock, state: int, commands: Sequence[str]) -> None:
    """Set ModeAlarm if the program commands another state than the operator.

    Args:
        commands: inputs of the program, one for each state, or one for two states.
    """
    requested = sum(int(block[command]) << number for number, command in enumerate(commands))
    expected = 1 << state if len(commands) > 1 else state
    changed = requested ^ int(block["~asked"])
    alarm = block.on("ModeAlarm") or bool(changed & (requested ^ expected))
    free = not (block["ProgOper"] or block["Override"] or block["Hand"])
    block.set(ModeAlarm=alarm and free and requested != expected, **{"~asked": requested})


def _has_timed_out(block: FunctionBlock) -> bool:
    """Return whether a missing feedback is a fault: after FaultTime, or after it was there once."""
    limit = block.limited("FaultTime", 0.0, math.inf)
    late = (block.machine.now_ns - int(block["~since_ns"])) / _NS_PER_S >= limit
    return limit > 0 and (late or not block["~timing"])


def _device(states: int) -> Callable[[FunctionBlock], None]:
    """Return the function that runs a device with this number of states."""
    three = states == 3
    numbers = range(states)
    commands = [f"Prog{n}Command" for n in numbers] if three else ["ProgCommand"]
    feedbacks = ("FB0", "FB1", "FB2", "FB3") if three else ("FB0", "FB1")

    def commanded(block: FunctionBlock, *, program: bool) -> int | None:
        """Return the state that the program or the operator commands; None for no change."""
        requested = _only_set_bit(block, [f"Oper{n}Req" for n in numbers], "OperReqInv")
        by_program = _only_set_bit(block, commands, "ProgCommandInv") if three else int(block["ProgCommand"])
        state = by_program if program else requested
        return state if state is not None and block[f"State{state}Perm"] else None

    def overriding(block: FunctionBlock) -> bool:
        """Return whether the device must be in its override state; an alarm gives the operator control."""
        by_alarm = block.on("FaultAlarm") and block.on("OverrideOnFault")
        begins = block.first and block.on("OverrideOnInit")
        requested = block.on("ProgOverrideReq") or by_alarm or begins
        if by_alarm or begins:
            block.set(ProgOper=False)
        invalid = three and block.wrong(OverrideStateInv=not 0 <= block["OverrideState"] < states)
        return requested and not invalid and not block["ProgHandReq"]

    def choose_state(block: FunctionBlock, present_state: int) -> int:
        """Set the mode; return the commanded state."""
        program = block.control()
        hand, override = block.on("ProgHandReq"), overriding(block)
        block.set(Hand=hand, Override=override)
        state = commanded(block, program=program and block.on("ProgOper"))
        if override:
            state = int(block["OverrideState"])
        if three:
            state_by_hand = _only_set_bit(block, [f"HandFB{n}" for n in numbers], "HandCommandInv")
        else:
            state_by_hand = int(block["HandFB"])
        if hand:
            state = state_by_hand
        return present_state if state is None else state

    def show(block: FunctionBlock, state: int) -> bool:
        """Set the outputs of a state; return whether the feedback shows it."""
        switched = all(block[feedback] == block[f"{feedback}State{state}"] for feedback in feedbacks)
        block.set(**{f"Device{n}State": switched and n == state for n in numbers})
        if three:
            block.set(**{f"Command{n}Status": n == state for n in numbers})
            block.set(**{f"Out{n}": block[f"Out{n}State{state}"] for n in range(3)})
        else:
            block.set(CommandStatus=state == 1, Out=(state == 1) != block.on("OutReverse"))
        return switched

    def step(block: FunctionBlock) -> None:
        if block.first:
            block.set(ModeAlarm=False, FaultAlarm=False)
            _mode_alarm(block, 0, commands)
        previous_state = int(block["~state"])
        state = choose_state(block, previous_state)
        switched = show(block, state)
        if block.first or state != previous_state:
            block.set(**{"~timing": True, "~since_ns": block.machine.now_ns})
        if switched:
            block.set(**{"~timing": False})
        fault = _has_timed_out(block) and not switched
        latched = block.on("FaultAlarm") and block.on("FaultAlarmLatch") and not block["FaultAlmUnlatch"]
        block.set(FaultAlarm=fault or latched, FaultAlmUnlatch=False, **{"~state": state})
        _mode_alarm(block, state, commands)

    return step


D2SD = block_row("D2SD", _device(2))
D3SD = block_row("D3SD", _device(3))
