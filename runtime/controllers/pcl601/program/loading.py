"""Loads a program from a file into a device's memory."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from scanrack.io_images.input_files import read_checked
from scanrack.io_images.pcl601.program import Program, ProgramError, parse_program
from scanrack.io_images.text_limits import TextKind, TextLimitError

from .machine import ProgramMachine

if TYPE_CHECKING:
    from ..controller import Pcl601Controller


def read_program(file: Path) -> Program:
    """Read a program in the text format.

    Raises:
        ValueError: the file is not a program, or can't be read; the message contains file, line and column.
    """
    try:
        return parse_program(read_checked(file, TextKind.STORED))
    except TextLimitError as error:
        raise ValueError(f"{file}:{error.line}: {error}") from error
    except ProgramError as error:
        raise ValueError(f"{file}: {error}") from error
    except OSError as error:
        raise ValueError(f"{file}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise ValueError(f"{file}: the file is not text: byte {error.start} is not UTF-8") from error


def load(controller: Pcl601Controller, program: Program) -> None:
    """Load a program and its `.autostart` flag into memory without starting the program."""
    controller.runner = ProgramMachine(program)
    if program.autostart is not None:
        controller.autorun = program.autostart
