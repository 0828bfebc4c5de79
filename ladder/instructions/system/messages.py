"""MSG: a message to another controller, with its result from a stub (`stubs`).

    rung    ____|‾‾‾‾|_____________
    EN, ST  ____|‾‾‾‾‾‾‾‾‾‾|_______     EN stays until the end and a false rung, ST until the end
    DN, ER  _______________|‾‾‾‾‾‾‾     until the next message

In structured text, a call begins a message unless it is already under way. The message ends after a scan,
whether or not it is called again, and EN ends with it.

Nothing is sent. The data of a read come from the stub's reply, if it has one. When DN is set, they are in the
tag that the export or the stub names.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

from scanrack.io_images.dataclass import dataclass

from ...compiler.edges import write_message
from ...interpreter import Interpreter
from ...interpreter.files import Members
from ...model.arithmetic import wrap
from ...model.operands import Group
from ...model.spec import Use, always
from ...model.stubs import stub_of
from ...model.tags import Leaf
from ...model.types import MESSAGE_BITS, count_of
from ...run.partners import receive
from ...state.lowered import LoweredProgram
from ...state.memory import Memory

TIMEOUT = 1
"""ERR of a message that its TO bit stopped: connection failure."""


def _msg(machine: Interpreter, power: bool, group: Group) -> None:
    message = Members(machine, group)
    in_text = machine.lowered.sites[machine.site].unit != "rung"
    if not message["EN"]:
        if power or in_text:
            message.set(EN=True, ST=True, EW=False, DN=False, ER=False, TO=False, ERR=0)
            message.set(**{"~waiting": in_text, "~started_ns": machine.now_ns})
        return
    if in_text:
        return
    if not (message["DN"] or message["ER"]):
        _go_on(machine, message, group.path)
    if not power and (message["DN"] or message["ER"]):
        message.set(EN=False)


def _go_on(machine: Interpreter, message: Members, path: str) -> None:
    stub = stub_of(machine.lowered.stubs, path)
    assert stub is not None  # `checks` refuses a program without one
    if not message["TO"] and machine.now_ns - machine.whole(message["~started_ns"]) < stub.after_ns:
        return
    error = TIMEOUT if message["TO"] else stub.error
    if not message["TO"]:
        receive(machine.lowered, machine.memory, path, machine.now_ns)
    message.set(ST=False, EW=False, DN=not error, ER=bool(error), ERR=error)


# --- messages of structured text


@dataclass(frozen=True, slots=True)
class _MessagePlaces:
    """Leaves of one tag's messages that structured text may have begun."""

    path: str
    waiting: Leaf
    flags: Leaf
    error: Leaf
    started: Leaf


def ends_of_messages(lowered: LoweredProgram) -> tuple[Callable[[Any], None], ...]:
    """Return functions that end structured text messages after a scan."""
    texts = [each for each in lowered.routines.values() if each.body is not None]
    if not any(step.name == "MSG" for each in texts for line in each.lines for step in line.all_steps):
        return ()
    return (partial(_end_messages, tuple(_waiting_in(lowered))),)


def _waiting_in(lowered: LoweredProgram) -> Iterator[_MessagePlaces]:
    layout = lowered.layout
    for leaf in layout.ending("~waiting"):
        path = leaf.path.rpartition(".")[0]
        parts = (layout.leaf(f"{path}.{name}") for name in ("FLAGS", "ERR", "~started_ns"))
        yield _MessagePlaces(path, leaf, *parts)


def _end_messages(tags: tuple[_MessagePlaces, ...], engine: Any) -> None:
    """End the messages whose time has elapsed."""
    memory: Memory = engine.memory
    for tag in tags:
        for index in range(count_of(tag.waiting.dims)):
            if memory.read(tag.waiting, index):
                _end_if_over(engine.lowered, memory, tag, index, engine.now_ns)


def _end_if_over(
    lowered: LoweredProgram, memory: Memory, tag: _MessagePlaces, index: int, now_ns: int
) -> None:
    stub = stub_of(lowered.stubs, tag.path)
    assert stub is not None  # `checks` refuses a program without one
    flags = int(memory.read(tag.flags, index))
    stopped = bool(flags >> MESSAGE_BITS["TO"] & 1)
    if not stopped and now_ns - int(memory.read(tag.started, index)) < stub.after_ns:
        return
    if not stopped:
        receive(lowered, memory, tag.path, now_ns)
    error = TIMEOUT if stopped else stub.error
    ended = 1 << MESSAGE_BITS["ER" if error else "DN"]
    over = sum(1 << MESSAGE_BITS[name] for name in ("EN", "ST", "EW"))
    memory.write(tag.waiting, index, False)
    memory.write(tag.flags, index, flags & ~over | ended)
    memory.write(tag.error, index, wrap(error, 16))


MSG = always("MSG", Use.MESSAGE, run=_msg, write=write_message, partly=True)
