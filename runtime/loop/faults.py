"""Faults of a CPU: their report, and the line of the user's code where they began."""

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
    """The responsible part."""

    PROGRAM = "program"
    WATCHDOG = "watchdog"
    MODULE = "module"
    LISTENER = "listener"


@dataclass(frozen=True, slots=True)
class Fault:
    """The cause of a stopped CPU."""

    scan: int
    now_ns: int
    cause: Cause  # the responsible part
    where: str  # file:line of the user's code, or of the innermost code known
    text: str
    site: Site = NOWHERE  # routine and rung of a ladder program

    def __str__(self) -> str:
        instant = f"scan {self.scan} (t = {seconds(self.now_ns)} s)"
        return f"{instant}: {_BLAME[self.cause]} {self.text} [{self.where}]"

    @property
    def fields(self) -> Mapping[str, JsonValue]:
        """The fault as the topic /faults reports it."""
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


class CpuFault(Exception):  # noqa: N818 - the usual term
    """The CPU has faulted: outputs are zero, modules stopped, listeners closed."""

    def __init__(self, fault: Fault) -> None:
        super().__init__(str(fault))
        self.fault = fault


class Ending(BaseException):
    """Ends the command that runs scans; it is never a fault, wherever it is raised."""


def ends_the_run(error: BaseException) -> bool:
    """Return whether an error of a program is no fault: an `Ending`, or a real Ctrl-C.

    A `raise KeyboardInterrupt` in the program is a fault like any other. A real Ctrl-C is raised by a
    signal handler of ours, or between two instructions of the program.
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
    """Return an exception's kind and message, a long one shortened.

    >>> words_of(ValueError("no such bit")), words_of(ZeroDivisionError())
    ('ValueError: no such bit', 'ZeroDivisionError')
    """
    text = shortened(str(error))
    return f"{type(error).__name__}: {text}" if text else type(error).__name__


def place_of(error: BaseException) -> str:
    """Return file:line of the user's innermost code that an exception came from.

    User code comes from a file that is neither ours nor installed (the constructor of a dataclass
    comes from "<string>"). If there is none, this is the innermost frame.
    """
    steps = [(frame.f_code, line) for frame, line in traceback.walk_tb(error.__traceback__)]
    user_steps = [step for step in steps if is_the_users(step[0].co_filename)]
    code, line = (user_steps or steps)[-1]
    return f"{code.co_filename}:{line}"


def is_the_users(file_name: str) -> bool:
    """Return whether code is the user's: neither ours nor installed, here or in an environment below."""
    return not file_name.startswith(_not_the_users()) and not any(folder in file_name for folder in _PACKAGES)


_ROOMS = (
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
def _not_the_users() -> tuple[str, ...]:
    import sysconfig  # most runs have no fault

    kinds = ("stdlib", "platstdlib", "purelib", "platlib")
    return (*_ROOMS, *(f"{sysconfig.get_path(kind)}{os.sep}" for kind in kinds), _GENERATED)


_PACKAGES = tuple(f"{os.sep}{kind}-packages{os.sep}" for kind in ("site", "dist"))
