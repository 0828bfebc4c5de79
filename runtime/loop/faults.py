"""CPU faults: their text, and the line of user code that caused them."""

from __future__ import annotations

import os
import sys
import traceback
from collections.abc import Mapping
from enum import Enum
from functools import cache
from opcode import opmap
from pathlib import Path

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.site import NOWHERE, Site
from scanrack.io_images.text_limits import shortened
from scanrack.io_images.times import seconds

from .events import JsonValue


class Cause(Enum):
    """The part of the system that caused a fault."""

    PROGRAM = "program"
    WATCHDOG = "watchdog"
    MODULE = "module"
    LISTENER = "listener"


@dataclass(frozen=True, slots=True)
class Fault:
    """The cause of a CPU stop."""

    scan: int
    now_ns: int
    cause: Cause
    where: str  # file:line of the user's code, or of the innermost code without any
    text: str  # kind and message of the exception, or the watchdog's message
    site: Site = NOWHERE  # routine and rung of a ladder program

    def __str__(self) -> str:
        instant = f"scan {self.scan} (t = {seconds(self.now_ns)} s)"
        return f"{instant}: {_BLAME[self.cause]} {self.text} [{self.where}]"

    @property
    def fields(self) -> Mapping[str, JsonValue]:
        """The fault's fields on the topic /faults."""
        fields: dict[str, JsonValue] = {"cause": self.cause.value, "where": self.where, "text": self.text}
        if self.site.rung is not None:
            fields |= {"routine": self.site.routine, "rung": self.site.rung}
        return fields


_BLAME = {
    Cause.PROGRAM: "the program raised",
    Cause.WATCHDOG: "the watchdog ended the program:",
    Cause.MODULE: "a module failed:",
    Cause.LISTENER: "a listener failed:",
}


class CpuFault(Exception):  # noqa: N818 - the usual term of PLCs
    """A CPU fault: outputs are zero, modules are stopped, and listeners are closed."""

    def __init__(self, fault: Fault) -> None:
        super().__init__(str(fault))
        self.fault = fault


class Ending(BaseException):
    """Ends the command that runs scans. It is never a fault, no matter where it is raised."""


def ends_the_run(error: BaseException) -> bool:
    """Return whether an error ends the run without being a fault: an `Ending`, or a real Ctrl-C.

    A `raise KeyboardInterrupt` in the program is a fault. A real Ctrl-C is raised by one of our signal
    handlers, or between two instructions of the program.
    """
    if not isinstance(error, KeyboardInterrupt):
        return isinstance(error, Ending)
    trace = error.__traceback__
    while trace is not None and trace.tb_next is not None:
        trace = trace.tb_next
    if trace is None:
        return True
    code = trace.tb_frame.f_code
    by_statement = code.co_code[trace.tb_lasti] == opmap["RAISE_VARARGS"]
    return not (by_statement and is_the_users(code.co_filename))


def words_of(error: BaseException) -> str:
    """Return an exception's type and message; a long message is shortened.

    >>> words_of(ValueError("no such bit")), words_of(ZeroDivisionError())
    ('ValueError: no such bit', 'ZeroDivisionError')
    """
    text = shortened(str(error))
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


def place_of(error: BaseException) -> str:
    """Return file:line of the innermost user code in an exception's traceback.

    User code comes from a file that is neither ours nor installed. The constructor of a dataclass comes from
    "<string>". If there is no user code, the innermost frame is used.
    """
    lines = [(frame.f_code.co_filename, line) for frame, line in traceback.walk_tb(error.__traceback__)]
    user_lines = [(file_name, line) for file_name, line in lines if is_the_users(file_name)]
    file_name, line = (user_lines or lines)[-1]
    return f"{file_name}:{line}"


def is_the_users(file_name: str) -> bool:
    """Return whether a file is the user's: neither ours nor installed, in this or another environment."""
    is_installed = any(folder in file_name for folder in _INSTALLATION_FOLDERS)
    return not is_installed and not file_name.startswith(_other_prefixes())


_PACKAGE_FOLDERS = (
    f"{sys.modules[__name__.partition('.')[0]].__path__[0]}{os.sep}",  # contains the others if installed
    *(
        f"{Path(__file__).parents[2] / package}{os.sep}"
        for package in ("io_images", "ladder", "rockwell", "runtime", "traces")
    ),
)
_GENERATED = "<"
"""Prefix of the file name of code without a file: "<string>", "<frozen importlib>", "<attrs generated ...>".
"""


@cache
def _other_prefixes() -> tuple[str, ...]:
    import sysconfig  # imported here, since most runs have no fault

    kinds = ("stdlib", "platstdlib", "purelib", "platlib")
    return (*_PACKAGE_FOLDERS, *(f"{sysconfig.get_path(kind)}{os.sep}" for kind in kinds), _GENERATED)


_INSTALLATION_FOLDERS = tuple(f"{os.sep}{kind}-packages{os.sep}" for kind in ("site", "dist"))
