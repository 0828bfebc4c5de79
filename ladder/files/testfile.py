"""Files of test routines, which run alongside a program and `ASSERT` its behavior.

    TEST feeder.toml FOR 12 s
    TAG Seen : BOOL
    ROUTINE test_it_strokes_to_and_fro
    XIC(Out.Done)OTL(Seen);
    XIC(Back.Done)ASSERT(Seen AND Strokes.ACC >= 1);
    END

The head names the rack file, relative to the test file's folder, and the run time, which is 10 s by default.
In a `.rung` file, each routine with a name that begins with `test_` is a test; tests call other routines with
JSR. A `.st` file is a single test, named after the file. Declarations can follow the head. A test can use the
tags, types and instructions of the program.
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
    is_structured = path.suffix == STRUCTURED_SUFFIX
    text = read_input_text(path, TextKind.STRUCTURED if is_structured else TextKind.RUNGS)
    lines = text.splitlines()
    # the first line that is more than a comment
    head_index = next((index for index, line in enumerate(lines) if line.split("//")[0].strip()), 0)
    head = _HEAD.fullmatch(lines[head_index]) if lines else None
    if head is None:
        return None
    body = "\n".join([*lines[:head_index], "", *lines[head_index + 1 :]])
    headings = {match[1]: body.count("\n", 0, match.start(1)) + 1 for match in _ROUTINE.finditer(body)}
    routines = {path.stem: head_index + 1} if is_structured else headings
    if not routines:
        site = Site(file=str(path), line=head_index + 1)
        raise LadderError.at(site, f"no routine with a name that begins with {PREFIX}")
    return TestFile(path, path.parent / head[1], head[2] or DEFAULT_TIME, routines, body)


def with_test(program: LadderLogic, file: TestFile, routine: str) -> tuple[LadderLogic, str]:
    """Return a copy of a program with a test file's routines added, and the test routine's full name.

    The test routine is called after the main routine. In a controller, this is the main routine of the
    continuous task's first program, and the test has that program's tags.

    Raises:
        LadderError: the file has an error, or declares a name that the program already has.
    """
    extended = program.copied()
    tested = _program_for_test(extended) if isinstance(extended, Controller) else extended
    assert isinstance(tested, Program)
    first = tested.first
    if first is None:
        raise LadderError(f"program {tested.name} has no routine; nothing to test")
    is_structured = file.path.suffix == STRUCTURED_SUFFIX
    Reader(file.text, str(file.path)).add_to(tested, file.path.stem if is_structured else None)
    calls = (parse_rung(f"JSR({name},0);", specs=tested.specs) for name in (first, routine))
    tested.add_routine(Routine(_MAIN, tuple(calls)))
    tested.main = _MAIN
    return extended, routine if tested is extended else scoped(tested.name, routine)


def _program_for_test(controller: Controller) -> Program:
    """Return the controller's program that receives the test routines."""
    names = [name for task in controller.tasks if task.kind is TaskKind.CONTINUOUS for name in task.programs]
    by_key = {program.name.upper(): program for program in controller.programs}
    programs = [by_key[name.upper()] for name in names if name.upper() in by_key] or controller.programs
    if not programs:
        raise LadderError(f"controller {controller.name} has no program; nothing to test")
    return programs[0]
