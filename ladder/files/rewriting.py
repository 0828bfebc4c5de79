"""Edits rungs in the text of a program file; all other lines are unchanged.

A rung consists of whole lines, with its comment in the lines above. A changed rung keeps its comment, and a
deleted rung loses it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from ..lowering.edited import BEFORE_FIRST, NewTag, RungEdit
from ..model.errors import LadderError
from ..model.tags import scoped
from .linereader import without_comment
from .rungreader import (
    CONTROLLER_HEAD,
    END_INSTRUCTION,
    END_PROGRAM,
    INSTRUCTION_HEAD,
    PROGRAM_HEAD,
    ROUTINE_HEAD,
    TAG_LINE,
)


class _RungLines(NamedTuple):
    """Line numbers of a rung, from 0: the start of its comment, its first line, and the line after it."""

    comment: int
    first: int
    end: int


@dataclass(slots=True)
class _Positions:
    """Line numbers of the parts of a file."""

    rungs: dict[str, list[_RungLines]] = field(default_factory=dict)  # by routine in capitals
    heads: dict[str, int] = field(default_factory=dict)  # the line after the head of a routine
    tags: dict[str, int] = field(default_factory=dict)  # the line for a new tag, by program in capitals


def rewritten(text: str, edits: Iterable[RungEdit], tags: Sequence[NewTag] = ()) -> str:
    """Return the text of a `.rung` file with edited rungs and new tags.

    Args:
        text: the text of a valid program.
        edits: the edits, with rungs in the program's notation, see `EditedProgram`.

    Raises:
        LadderError: the rung or program is not in the file.
    """
    lines = text.splitlines()
    positions = _positions_in(lines)
    changes = [_change(lines, positions, edit) for edit in edits]
    for program in dict.fromkeys(tag.program for tag in tags):
        line = positions.tags.get(program.upper())
        if line is None:
            raise LadderError(f"the file has no program {program}")
        tag_lines = [f"TAG {tag.name} : {tag.type}" for tag in tags if tag.program == program]
        changes.append((line, line, tag_lines))
    for first, end, new in sorted(changes, key=lambda change: change[:2], reverse=True):
        lines[first:end] = new
    newline = "\r\n" if "\r\n" in text else "\n"
    return newline.join(lines) + newline * text.endswith("\n")


def _change(lines: list[str], positions: _Positions, edit: RungEdit) -> tuple[int, int, list[str]]:
    """Return the first and end line numbers that an edit replaces, and the new lines."""
    name = edit.routine.upper()
    if edit.rung == BEFORE_FIRST and name in positions.heads:
        return positions.heads[name], positions.heads[name], list(edit.texts)
    rungs = positions.rungs.get(name, [])
    if not 0 <= edit.rung < len(rungs):
        raise LadderError(f"routine {edit.routine} has no rung {edit.rung} in the file")
    rung = rungs[edit.rung]
    if not edit.texts:
        return rung.comment, rung.end, []
    indent = re.match(r"\s*", lines[rung.first])
    new = [f"{indent.group() if indent else ''}{text}" for text in edit.texts]
    return (rung.end, rung.end, new[1:]) if edit.keeps else (rung.first, rung.end, new)


def _positions_in(lines: list[str]) -> _Positions:
    """Find the routines of rungs, and the ends of declarations."""
    positions = _Positions()
    program = ""  # of a controller, that the line is in
    is_controller = in_instruction = False
    number = 0
    while number < len(lines):
        line = without_comment(lines[number])
        number += 1  # now of the line after `line`
        if INSTRUCTION_HEAD.fullmatch(line):
            in_instruction = True
        elif END_INSTRUCTION.fullmatch(line):
            in_instruction = False
        elif in_instruction:
            continue
        elif CONTROLLER_HEAD.fullmatch(line):
            is_controller = True
        elif END_PROGRAM.fullmatch(line):
            program = ""
        elif match := PROGRAM_HEAD.fullmatch(line):
            program = match.group(1) if is_controller else ""
            positions.tags[program.upper()] = number
        elif TAG_LINE.fullmatch(line):
            positions.tags[program.upper()] = number
        elif match := ROUTINE_HEAD.fullmatch(line):
            name = scoped(program, match.group(1)).upper()
            positions.heads[name] = number
            if not match.group(2):
                positions.rungs[name] = list(_rungs(lines, number))
                number = positions.rungs[name][-1].end if positions.rungs[name] else number
    return positions


def _rungs(lines: list[str], number: int) -> Iterator[_RungLines]:
    """Yield the rungs of a routine, beginning with the line after its head."""
    comment = first = None
    for index in range(number, len(lines)):
        line = without_comment(lines[index])
        if first is None:
            if line.upper() == "END":
                return
            if not line:
                if comment is None and lines[index].strip():
                    comment = index
                continue
            first = index
        if line.endswith(";"):
            yield _RungLines(first if comment is None else comment, first, index + 1)
            comment = first = None
