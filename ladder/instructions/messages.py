"""MSG: a message to another controller, whose end a stub describes (`stubs`).

    rung    ____|‾‾‾‾|_____________
    EN, ST  ____|‾‾‾‾‾‾‾‾‾‾|_______     EN stays until the end and a false rung, ST until the end
    DN, ER  _______________|‾‾‾‾‾‾‾     until the next message

Nothing is sent or received: a program or a test writes the data of a read.
"""

from __future__ import annotations

from dataclasses import replace

from ..arithmetic import wrap
from ..interpreter import Interpreter
from ..operands import Constant, Group
from ..spec import Use, always
from ..stubs import Ending, stub_of
from ..types import DINT, MESSAGE_BITS

__all__ = ["MSG"]

TIMEOUT = 1
"""ERR of a message that the program has stopped by its TO bit: connection failure."""


class _Message:
    """A MESSAGE in a scan; its bits lie in FLAGS."""

    def __init__(self, machine: Interpreter, group: Group) -> None:
        self._machine, self._group = machine, group

    def __getitem__(self, name: str) -> bool:
        place = replace(self._group.member("FLAGS"), bit=Constant(MESSAGE_BITS[name], DINT))
        return bool(self._machine.get(place))

    def set(self, **bits: bool) -> None:
        for name, value in bits.items():
            place = replace(self._group.member("FLAGS"), bit=Constant(MESSAGE_BITS[name], DINT))
            self._machine.put(place, value)

    @property
    def elapsed_ns(self) -> int:
        return self._machine.now_ns - int(self._machine.get(self._group.member("~started_ns")))

    def start(self) -> None:
        self.set(EN=True, ST=True, EW=False, DN=False, ER=False, TO=False)
        self._fail(0)
        self._machine.put(self._group.member("~started_ns"), self._machine.now_ns)

    def finish(self, error: int) -> None:
        self.set(ST=False, EW=False, DN=not error, ER=bool(error))
        self._fail(error)

    def _fail(self, error: int) -> None:
        self._machine.put(self._group.member("ERR"), wrap(error, 16))


def _msg(machine: Interpreter, power: bool, group: Group) -> None:
    message = _Message(machine, group)
    if not message["EN"]:
        if power:
            message.start()
        return
    if not (message["DN"] or message["ER"]):
        _go_on(message, stub_of(machine.lowered.stubs, group.path))
    if not power and (message["DN"] or message["ER"]):
        message.set(EN=False)


def _go_on(message: _Message, stub: Ending | None) -> None:
    assert stub is not None  # `checks` refuses a program without one
    if message["TO"]:
        message.finish(TIMEOUT)
    elif message.elapsed_ns >= stub.after_ns:
        message.finish(stub.error)


MSG = always("MSG", Use.MESSAGE, run=_msg)
