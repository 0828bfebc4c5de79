"""The values of a program that can be set and forced."""

from __future__ import annotations

from scanrack.ladder.debug import Debugger
from scanrack.ladder.python.online.fields import Fields
from scanrack.ladder.python.sequences import Logic
from scanrack.runtime.loop.scan import ScanLogic

from .logic_wrapper import unwrapped


def settable_tags(logic: ScanLogic) -> Debugger | Fields | None:
    """Return the debugger of a ladder program, or the fields of a `Logic`; None for other logic."""
    program = unwrapped(logic)
    if isinstance(program, Logic):
        return Fields(lambda: program)
    return program if isinstance(program, Debugger) else None
