"""A program into a unit's memory, as if it had been saved earlier."""

from __future__ import annotations

from .....io_images.pcl601.program import Program
from ..controller import Controller
from .machine import ProgramMachine


def load(controller: Controller, program: Program) -> None:
    """Put a program into program memory, and its `.autostart` into the autorun flag.

    It does not start by that; with autorun on it does when power comes on.
    """
    controller.runner = ProgramMachine(program)
    if program.autostart is not None:
        controller.autorun = program.autostart
