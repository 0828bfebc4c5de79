"""D2SD and D3SD: a device with feedback and two or three states [1756-RM006K p. 28-50].

    mode                      commanded state
    Hand (ProgHandReq)        HandFB; with three states the only HandFB that is set
    Override                  OverrideState; by ProgOverrideReq, OverrideOnInit, an alarm with OverrideOnFault
    Program, Operator         the only command or request that is set, if the state's permissive is set

More than one command is a fault, and the state does not change. A commanded change starts the fault timer;
the feedback of the state stops it. Where the manual is silent: the first scan also starts the timer, and an
override by an alarm switches to operator control.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from .function_block import FunctionBlock, block_row

_NS_PER_S = 1_000_000_000


def _only_set_bit(block: FunctionBlock, names: list[str], fault: str) -> int | None:
    """Return the number of the only set bit; None if no bits or, with a fault, several bits are set."""
    numbers = [number for number, name in enumerate(names) if block[name]]
    block.wrong(**{fault: len(numbers) > 1})
    return numbers[0] if len(numbers) == 1 else None


def _mode_alarm(block: FunctionBlock, state: int, commands: Sequence[str]) -> None:
    """Set ModeAlarm if the program commands a different state than the operator.

    Args:
        commands: the program's inputs: one for each state, or a single input for two states.
    """
    requested = sum(int(block[command]) << number for number, command in enumerate(commands))
    expected = 1 << state if len(commands) > 1 else state
    changed = requested ^ int(block["~asked"])
    alarm = block.on("ModeAlarm") or bool(changed & (requested ^ expected))
    free = not (block["ProgOper"] or block["Override"] or block["Hand"])
    block.set(ModeAlarm=alarm and free and requested != expected, **{"~asked": requested})


def _has_timed_out(block: FunctionBlock) -> bool:
    """Return whether missing feedback is a fault: after FaultTime, or once the feedback has been on."""
    limit = block.limited("FaultTime", 0.0, math.inf)
    late = (block.machine.now_ns - int(block["~since_ns"])) / _NS_PER_S >= limit
    return limit > 0 and (late or not block["~timing"])


class _Device:
    """A device with two states (D2SD) or three (D3SD)."""

    def __init__(self, states: int) -> None:
        self._numbers = range(states)
        self._has_three = states == 3
        self._commands = [f"Prog{n}Command" for n in self._numbers] if self._has_three else ["ProgCommand"]
        self._feedbacks = [f"FB{n}" for n in range(4 if self._has_three else 2)]

    def step(self, block: FunctionBlock) -> None:
        """Choose the mode and the state, set the outputs, and update both alarms."""
        if block.first:
            block.set(ModeAlarm=False, FaultAlarm=False)
            _mode_alarm(block, 0, self._commands)
        previous_state = int(block["~state"])
        chosen = self._choose_state(block)
        state = previous_state if chosen is None else chosen
        switched = self._show(block, state)
        if block.first or state != previous_state:
            block.set(**{"~timing": True, "~since_ns": block.machine.now_ns})
        if switched:
            block.set(**{"~timing": False})
        fault = _has_timed_out(block) and not switched
        latched = block.on("FaultAlarm") and block.on("FaultAlarmLatch") and not block["FaultAlmUnlatch"]
        block.set(FaultAlarm=fault or latched, FaultAlmUnlatch=False, **{"~state": state})
        _mode_alarm(block, state, self._commands)

    def _choose_state(self, block: FunctionBlock) -> int | None:
        """Set the mode; return the state that it commands, or None for no change."""
        program = block.control()
        hand, override = block.on("ProgHandReq"), self._is_overridden(block)
        block.set(Hand=hand, Override=override)
        commanded = self._commanded(block, program=program and block.on("ProgOper"))
        if self._has_three:
            by_hand = _only_set_bit(block, [f"HandFB{n}" for n in self._numbers], "HandCommandInv")
        else:
            by_hand = int(block["HandFB"])
        if hand:
            return by_hand
        return int(block["OverrideState"]) if override else commanded

    def _commanded(self, block: FunctionBlock, *, program: bool) -> int | None:
        """Return the state that the program or operator commands; None for no change."""
        by_operator = _only_set_bit(block, [f"Oper{n}Req" for n in self._numbers], "OperReqInv")
        if self._has_three:
            by_program = _only_set_bit(block, self._commands, "ProgCommandInv")
        else:
            by_program = int(block["ProgCommand"])
        state = by_program if program else by_operator
        return state if state is not None and block[f"State{state}Perm"] else None

    def _is_overridden(self, block: FunctionBlock) -> bool:
        """Return whether the device must be in override; an alarm also switches to operator control."""
        by_alarm = block.on("FaultAlarm") and block.on("OverrideOnFault")
        at_start = block.first and block.on("OverrideOnInit")
        requested = block.on("ProgOverrideReq") or by_alarm or at_start
        if by_alarm or at_start:
            block.set(ProgOper=False)
        if self._has_three and block.wrong(OverrideStateInv=block["OverrideState"] not in self._numbers):
            return False
        return requested and not block["ProgHandReq"]

    def _show(self, block: FunctionBlock, state: int) -> bool:
        """Set the outputs of a state; return whether the feedback shows it."""
        switched = all(block[feedback] == block[f"{feedback}State{state}"] for feedback in self._feedbacks)
        block.set(**{f"Device{n}State": switched and n == state for n in self._numbers})
        if self._has_three:
            block.set(**{f"Command{n}Status": n == state for n in self._numbers})
            block.set(**{f"Out{n}": block[f"Out{n}State{state}"] for n in range(3)})
        else:
            block.set(CommandStatus=state == 1, Out=(state == 1) != block.on("OutReverse"))
        return switched


D2SD = block_row("D2SD", _Device(2).step)
D3SD = block_row("D3SD", _Device(3).step)
