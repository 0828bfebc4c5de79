"""Files of test routines, which run beside a program and `ASSERT` its behavior.

    TEST feeder.toml FOR 12 s
    TAG Seen : BOOL
    ROUTINE test_it_strokes_to_and_fro
    XIC(Out.Done)OTL(Seen);
    XIC(Back.Done)ASSERT(Seen AND Strokes.ACC >= 1);
    END

The head names the rack, relative to the file's folder, and the time, which is 10 s by default. In a `.rung`
file, each routine whose name begins with `test_` is a test; other routines are called by JSR. A `.st` file is
a single test with the file's name. Declarations may follow the head. Tags, types and instructions of the
program are known.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import NamedTuple

from scanrack.io_images.input_files import read_input_text
from scanrack.io_images.site import Site
from scanrack.io_images.text_limits import TextKind

from ..lowering.controller import Controller
from ..lowering.program import Program
from ..lowering.runnable import LadderLogic
from ..lowering.text import parse_rung
from ..model.errors import LadderError
from ..model.routine import Routine
from ..model.schedule import TaskKind
from ..model.tags import scoped
from .rungreader import Reader
from .suffixes import STRUCTURED_SUFFIX

PREFIX = "test_"
"""Prefix of the names of test routines and of their files."""

DEFAULT_TIME = "10 s"

_HEAD = re.compile(r"\s*TEST\s+(\S+)(?:\s+FOR\s+(\S.*?))?\s*(?://.*)?", re.IGNORECASE)
_ROUTINE = re.compile(rf"^\s*ROUTINE\s+({PREFIX}\w+)", re.IGNORECASE | re.MULTILINE)
_MAIN = "Main__And_Test"


class TestFile(NamedTuple):
    """A file of test routines.

    Attributes:
        rack: the rack file.
        time: how long each routine runs, such as `12 s`.
        routines: names and lines of the routines.
        text: the declarations and routines, with a blank line in place of the head.
    """

    path: Path
    rack: Path
    time: str
    routines: dict[str, int]
    text: str


def read_test_file(path: Path) -> TestFile | None:
    """Read a file of test routines; return None if it has no head and so is not a test file.

    Raises:
        LadderError: the file has no test routine.
        OSError: the file can't be read.
    """
    flat = path.suffix == STRUCTURED_SUFFIX
    text = read_input_text(path, TextKind.STRUCTURED if flat else TextKind.RUNGS)
    lines = text.splitlines()
    number = next((line_number for line_number, line in enumerate(lines) if line.split("//")[0].strip()), 0)
    head = _HEAD.fullmatch(lines[number]) if lines else None
    if head is None:
        return None
    body = "\n".join([*lines[:number], "", *lines[number + 1 :]])
    headings = {match[1]: body.count("\n", 0, match.start(1)) + 1 for match in _ROUTINE.finditer(body)}
    routines = {path.stem: number + 1} if flat else headings
    if not routines:
        site = Site(file=str(path), line=number + 1)
        raise LadderError.at(site, f"no routine whose name begins with {PREFIX}")
    return TestFile(path, path.parent / head[1], head[2] or DEFAULT_TIME, routines, body)


def with_test(program: LadderLogic, file: TestFile, routine: str) -> tuple[LadderLogic, str]:
    """Return a copy of a program with a test file's routines, and the full name of the given routine.

    That routine is called after the main routine. In a controller, this is the main routine of the first
    program of the continuous task, and the test shares that program's tags.

    Raises:
        LadderError: the file has a mistake, or declares a name that the program has.
    """
    program_with_test = program.copied()
    owner = _cyclic(program_with_test) if isinstance(program_with_test, Controller) else program_with_test
    assert isinstance(owner, Program)
    first = owner.first
    if first is None:
        raise LadderError(f"program {owner.name} has no routine: there is nothing to test")
    flat = file.path.suffix == STRUCTURED_SUFFIX
    Reader(file.text, str(file.path)).add_to(owner, file.path.stem if flat else None)
    calls = (parse_rung(f"JSR({name},0);", specs=owner.specs) for name in (first, routine))
    owner.add_routine(Routine(_MAIN, tuple(calls)))
    owner.main = _MAIN
    return program_with_test, routine if owner is program_with_test else scoped(owner.name, routine)


def _cyclic(controller: Controller) -> Program:
    """Return the program of a controller to which tests are added."""
    names = [name for task in controller.tasks if task.kind is TaskKind.CONTINUOUS for name in task.programs]
    known = {program.name.upper(): program for program in controller.programs}
    programs = [known[name.upper()] for name in names if name.upper() in known] or controller.programs
    if not programs:
        raise LadderError(f"controller {controller.name} has no program: there is nothing to test")
    return programs[0]
