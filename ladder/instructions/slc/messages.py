"""MSG of SLC 500 and MicroLogix, with its result from a stub [1747-RM001, "Communication Instructions"].

Its control block is an element of a file MG, or words of a file N. Bits of word 0 are EN 15, ST 14, DN 13, ER
12, EW 10 and TO 8; the low byte is the error code. Other operands are not used.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from ...interpreter import Interpreter
from ...model.operand_checks import OperandError
from ...model.operands import Constant, Group, Place
from ...model.spec import InstructionKind, Spec, Use
from ...model.stubs import Ending, stub_of
from ...model.tree import Address, Operand
from ...model.types import DINT, INT, MESSAGE
from ...state.lowered import OperandResolver
from ..system.messages import MSG as LOGIX_MSG
from ..system.messages import TIMEOUT

BITS = {"EN": 15, "ST": 14, "DN": 13, "ER": 12, "EW": 10, "TO": 8}
"""Bits of word 0 of a control block."""


class _Block:
    """A control block of words in a scan."""

    def __init__(self, machine: Interpreter, word: Place) -> None:
        self._machine, self._word = machine, word

    def __getitem__(self, name: str) -> bool:
        return self._machine.truth(self._machine.get(replace(self._word, bit=Constant(BITS[name], DINT))))

    def set(self, **bits: bool) -> None:
        for name, value in bits.items():
            self._machine.put(replace(self._word, bit=Constant(BITS[name], DINT)), value)

    def fail(self, code: int) -> None:
        word = self._machine.whole(self._machine.get(self._word))
        self._machine.put(self._word, word & ~0xFF | code & 0xFF)


def _words(machine: Interpreter, power: bool, word: Place, started: Place) -> None:
    block = _Block(machine, word)
    if not block["EN"]:
        if power:
            block.set(EN=True, ST=True, DN=False, ER=False, EW=False, TO=False)
            block.fail(0)
            machine.put(started, machine.now_ns)
        return
    over = block["DN"] or block["ER"]
    stub = stub_of(machine.lowered.stubs, word.text)
    assert isinstance(stub, Ending)  # a MSG is resolved only with a stub
    waited = machine.now_ns - machine.whole(machine.get(started)) >= stub.after_ns
    if not over and (block["TO"] or waited):
        error = TIMEOUT if block["TO"] else stub.error
        block.set(ST=False, DN=not error, ER=bool(error))
        block.fail(error)
        over = True
    if over and not power:
        block.set(EN=False)


def _run(machine: Interpreter, power: bool, control: Place | Group, *started: Place) -> None:
    if isinstance(control, Group):
        LOGIX_MSG.run(machine, power, control)
    else:
        _words(machine, power, control, *started)


def _resolve(resolver: OperandResolver, given: tuple[Operand, ...]) -> tuple[Any, ...]:
    for each in given:
        found = resolver.any(each) if isinstance(each, Address) else None
        if isinstance(found, Group) and found.type == MESSAGE:
            return (found,)
        if isinstance(found, Place) and found.type == INT:
            if stub_of(resolver.stubs, found.text) is None:
                text = f"nothing says how the message {found.text} ends"
                raise OperandError(text, 'describe its end in [stubs]: MSG = "done after 20 ms"')
            return found, resolver.hidden("message")
    raise OperandError("MSG has no control block", "name an element of a file MG, or the first word of it")


MSG = Spec("MSG", InstructionKind.BOTH, (Use.ANYTHING,), run=_run, resolve=_resolve)
