"""Ladder logic: checks, compiles, interprets, draws and debugs rungs that are written in Python or text.

A program consists of declared tags and routines (`Program`). A controller consists of tags that its programs
share, and of tasks (`Controller`). Both run in a scan. A package imports only from the packages above it in
this table:

| package | content |
|---|---|
| `model` | types, tags, the tree, expressions, operands, specs of instructions |
| `state` | a program ready to run: lowered, its memory, its tasks, its faults |
| `interpreter` | the reference back end |
| `run`, `compiler` | one running program, its tags, online edits; the fast back end |
| `instructions` | each instruction in both back ends: one file per family, one row each |
| `st`, `lowering` | structured text; from rungs in Python or text to a lowered program |
| `python` | logic in plain Python: sequences, and the axis of a 3601 |
| `files`, `blocks` | `.rung`, `.st` and `.steps` files; the motion blocks of `USE axis3601` |
| `debug`, `draw` | breakpoints, forces, causes, cross reference; rungs as characters and SVG |
| `prove` | properties of a program, for every input: a scan on terms, verdicts, monitors |

CONTRIBUTING.md has the steps that add an instruction.
"""

from __future__ import annotations

from typing import Any

from scanrack.io_images.front_door import homes_in, imported_from

from .model import hooks

TYPE_CHECKING = False  # type checkers assume that it is true

if TYPE_CHECKING:  # type checkers import these lines, `_HOMES` reads them
    from . import instructions
    from .files.rungfile import read_program, write_program
    from .instructions import *  # noqa: F403
    from .lowering.checks import REPEATED_COILS, REPEATED_TIMERS
    from .lowering.controller import Controller
    from .lowering.program import Program
    from .lowering.runnable import LadderLogic
    from .lowering.text import parse_rung
    from .model.errors import BuildError, LadderError, LadderFault, MinorFault, RungTextError
    from .model.tree import Rung
    from .model.types import (
        BOOL,
        CONTROL,
        COUNTER,
        DINT,
        INT,
        LINT,
        LREAL,
        REAL,
        SINT,
        STRING,
        TIMER,
        UDINT,
        UINT,
        ULINT,
        USINT,
        Member,
        Structure,
    )
    from .run.engine import Engine

    __all__ = [
        "BOOL",
        "CONTROL",
        "COUNTER",
        "DINT",
        "INT",
        "LINT",
        "LREAL",
        "REAL",
        "REPEATED_COILS",
        "REPEATED_TIMERS",
        "SINT",
        "STRING",
        "TIMER",
        "UDINT",
        "UINT",
        "ULINT",
        "USINT",
        "BuildError",
        "Controller",
        "Engine",
        "LadderError",
        "LadderFault",
        "LadderLogic",
        "Member",
        "MinorFault",
        "Program",
        "RungTextError",
        "Structure",
        "parse_rung",
        "read_program",
        "write_program",
        *instructions.NAMES,
    ]

_HOMES = homes_in(__spec__)


def _rung_svg(rung: Rung) -> str:
    from .draw import routines_svg
    from .model.routine import Routine

    return routines_svg([(Routine("", (rung,)), [0])])


def _ask(program: LadderLogic, **parameters: Any) -> object:
    from .prove.answers import ask

    return ask(program, **parameters)


hooks.rung_svg, hooks.ask = _rung_svg, _ask


def __getattr__(name: str) -> object:
    """Import a name when it is first used, since a program in Python needs no rungs."""
    if name == "__all__":
        return __dir__()
    value = imported_from(_HOMES.get(name, ".instructions" if name.isupper() else f".{name}"), name, __name__)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    from .instructions import NAMES

    return sorted({*_HOMES, *NAMES})
