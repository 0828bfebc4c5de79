"""MSG of SLC 500 and MicroLogix, with its result from a stub [1747-RM001, "Communication Instructions"].

Its control block is an element of a file MG, or words of a file N. Bits of word 0 are EN 15, ST 14, DN 13, ER
12, EW 10 and TO 8; the low byte is the error code. Other operands are not used.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from ...interpreter import Interpreter
from ...interpreter.files import Members
from ...model.operand_checks import OperandError
from ...model.operands import Constant, Group, Place
from ...model.spec import InstructionKind, Spec, Use
from ...model.stubs import stub_of
from ...model.tree import Address, Operand
from ...model.types import DINT, INT, MESSAGE
from ...state.lowered import OperandResolver
from ...state.memory import Value
from ..system.messages import run_message

BITS = {"EN": 15, "ST": 14, "DN": 13, "ER": 12, "EW": 10, "TO": 8}
"""Bits of word 0 of a control block."""


class _Words(Members):
    """A control block of words in a scan, with the members of a MESSAGE."""

    def __init__(self, machine: Interpreter, word: Place, started: Place) -> None:
        self._machine, self._word, self._started = machine, word, started

    def _bit(self, name: str) -> Place:
        return replace(self._word, bit=Constant(BITS[name], DINT))

    def __getitem__(self, name: str) -> Value:
        """Return a bit, or `~started_ns`."""
        return self._machine.get(self._bit(name) if name in BITS else self._started)

    def set(self, **members: Value) -> None:
        """Set bits, ERR, or `~started_ns`."""
        for name, value in members.items():
            if name in BITS:
                self._machine.put(self._bit(name), value)
            elif name == "ERR":
                word = self._machine.whole(self._machine.get(self._word))
                self._machine.put(self._word, word & ~0xFF | self._machine.whole(value) & 0xFF)
            elif name == "~started_ns":
                self._machine.put(self._started, value)


def _run(machine: Interpreter, power: bool, control: Place | Group, *started: Place) -> None:
    """Run MSG; its control block is a MESSAGE, or words with a hidden tag for the time of the start."""
    block = Members(machine, control) if isinstance(control, Group) else _Words(machine, control, *started)
    run_message(machine, power, block, control.path if isinstance(control, Group) else control.text)


def _resolve(resolver: OperandResolver, operands: tuple[Operand, ...]) -> tuple[Any, ...]:
    """Return the control block, and its hidden tag if it is words; raise an OperandError if it is missing.

    A control block of words also needs a stub.
    """
    for operand in operands:
        message = resolver.any_operand(operand) if isinstance(operand, Address) else None
        if isinstance(message, Group) and message.type == MESSAGE:
            return (message,)
        if isinstance(message, Place) and message.type == INT:
            if stub_of(resolver.stubs, message.text) is None:
                text = f"nothing says how the message {message.text} ends"
                raise OperandError(text, 'describe its end in [stubs]: MSG = "done after 20 ms"')
            return message, resolver.hidden("message")
    raise OperandError("MSG has no control block", "name an element of a file MG, or the first word of it")


MSG = Spec("MSG", InstructionKind.BOTH, (Use.ANYTHING,), run=_run, resolve=_resolve)
