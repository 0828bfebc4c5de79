"""MSG: a message to another controller, with its result from a stub (`stubs`).

    rung    ____|‾‾‾‾|_____________
    EN, ST  ____|‾‾‾‾‾‾‾‾‾‾|_______     EN stays on until the end and a false rung; ST until the end
    DN, ER  _______________|‾‾‾‾‾‾‾     until the next message

In structured text, a call begins a message unless it is already under way. The message ends after a scan,
even without another call, and then clears EN.

Nothing is sent. The data of a read come from the stub's reply, if it has one. When DN is set, the data are in
the tag specified in the export or the stub.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from ...compiler.edges import write_message
from ...interpreter import Interpreter
from ...interpreter.files import Members
from ...model.operands import Group, subscripts_of
from ...model.spec import Use, always
from ...model.stubs import stub_of
from ...model.tags import Leaf
from ...model.types import MESSAGE
from ...run.partners import receive
from ...state.lowered import LoweredProgram

TIMEOUT = 1
"""ERR of a message that its TO bit stopped, "connection failure"."""


def run_message(machine: Interpreter, power: bool, message: Members, path: str) -> None:
    """Begin a message, or end it when its time has elapsed."""
    in_text = machine.lowered.sites[machine.site].unit != "rung"
    if not message["EN"]:
        if power or in_text:
            message.set(EN=True, ST=True, EW=False, DN=False, ER=False, TO=False, ERR=0)
            message.set(**{"~started_ns": machine.now_ns})
        if in_text:
            message.set(**{"~waiting": True})
    elif not in_text:
        if not (message["DN"] or message["ER"]):
            _end_if_due(machine, message, path)
        if not power and (message["DN"] or message["ER"]):
            message.set(EN=False)


def _end_if_due(machine: Interpreter, message: Members, path: str) -> None:
    """End an active message if its time has elapsed or its TO bit is set."""
    stub = stub_of(machine.lowered.stubs, path)
    assert stub is not None  # `checks` refuses a program without a stub
    if not message["TO"] and machine.now_ns - machine.whole(message["~started_ns"]) < stub.after_ns:
        return
    error = TIMEOUT if message["TO"] else stub.error
    if not message["TO"]:
        receive(machine.lowered, machine.memory, path, machine.now_ns)
    message.set(ST=False, EW=False, DN=not error, ER=bool(error), ERR=error)


# --- messages of structured text


def ends_of_messages(lowered: LoweredProgram) -> tuple[Callable[[Any], None], ...]:
    """Return the functions that end structured text messages after each scan."""
    texts = [routine for routine in lowered.routines.values() if routine.body is not None]
    if not any(step.name == "MSG" for routine in texts for line in routine.lines for step in line.all_steps):
        return ()
    return (partial(_end_messages, lowered.layout.leaves_ending_in("~waiting")),)


def _end_messages(waiting: Sequence[Leaf], engine: Any) -> None:
    """End the messages that are due, and clear their EN; `waiting` are the leaves of hidden bits."""
    machine: Interpreter = engine.interpreter
    machine.now_ns = engine.now_ns
    for leaf in waiting:
        path = leaf.path.rpartition(".")[0]
        for index in range(leaf.size):
            if engine.memory.read(leaf, index):
                subscripts = subscripts_of(leaf.dims, index)
                layout = machine.lowered.layout
                group = Group(MESSAGE, path, indices=subscripts, dims=(), layout=layout, text=path)
                message = Members(machine, group)
                _end_if_due(machine, message, path)
                if message["DN"] or message["ER"]:
                    message.set(EN=False, **{"~waiting": False})


MSG = always(
    "MSG",
    Use.MESSAGE,
    run=lambda machine, power, group: run_message(machine, power, Members(machine, group), group.path),
    write=write_message,
    partly=True,
)
