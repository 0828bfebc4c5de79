"""Edits rungs in the text of a program file; every other line stays as it was written.

A rung consists of whole lines, with its comment in the lines above. A changed rung keeps its comment; the
comment of a deleted rung is deleted, too.
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


class _Lines(NamedTuple):
    """Line numbers of a rung, from 0: the start of its comment, its first line, and the line after it."""

    comment: int
    first: int
    end: int


@dataclass(slots=True)
class _Places:
    """Line numbers of the parts of a file."""

    rungs: dict[str, list[_Lines]] = field(default_factory=dict)  # by routine in capitals
    heads: dict[str, int] = field(default_factory=dict)  # the line after the head of a routine
    tags: dict[str, int] = field(default_factory=dict)  # the line for a new tag, by program in capitals


def rewritten(text: str, edits: Iterable[RungEdit], tags: Sequence[NewTag] = ()) -> str:
    """Return the text of a `.rung` file after edits of rungs and with new tags.

    Args:
        text: the text of a valid program.
        edits: the edits, with rungs in the program's notation, see `EditedProgram`.

    Raises:
        LadderError: the file has no such rung or program.
    """
    lines = text.splitlines()
    places = _places(lines)
    changes = [_change(lines, places, edit) for edit in edits]
    for program in dict.fromkeys(tag.program for tag in tags):
        line = places.tags.get(program.upper())
        if line is None:
            raise LadderError(f"the file has no program {program}")
        tag_lines = [f"TAG {tag.name} : {tag.type}" for tag in tags if tag.program == program]
        changes.append((line, line, tag_lines))
    for first, end, new in sorted(changes, key=lambda change: change[:2], reverse=True):
        lines[first:end] = new
    newline = "\r\n" if "\r\n" in text else "\n"
    return newline.join(lines) + newline * text.endswith("\n")


def _change(lines: list[str], places: _Places, edit: RungEdit) -> tuple[int, int, list[str]]:
    """Return the line numbers that an edit replaces, and the new lines."""
    name = edit.routine.upper()
    if edit.rung == BEFORE_FIRST and name in places.heads:
        return places.heads[name], places.heads[name], list(edit.texts)
    rungs = places.rungs.get(name, [])
    if not 0 <= edit.rung < len(rungs):
        raise LadderError(f"routine {edit.routine} has no rung {edit.rung} in the file")
    rung = rungs[edit.rung]
    if not edit.texts:
        return rung.comment, rung.end, []
    indent = re.match(r"\s*", lines[rung.first])
    new = [f"{indent.group() if indent else ''}{text}" for text in edit.texts]
    return (rung.end, rung.end, new[1:]) if edit.keeps else (rung.first, rung.end, new)


def _places(lines: list[str]) -> _Places:
    """Find the routines of rungs, and the ends of declarations."""
    places, program, number, inside = _Places(), "", 0, False
    is_controller = False
    while number < len(lines):
        line = without_comment(lines[number])
        number += 1
        if INSTRUCTION_HEAD.fullmatch(line) or END_INSTRUCTION.fullmatch(line):
            inside = not END_INSTRUCTION.fullmatch(line)
        elif inside:
            continue
        elif CONTROLLER_HEAD.fullmatch(line):
            is_controller = True
        elif is_controller and (match := PROGRAM_HEAD.fullmatch(line)):
            program = match.group(1)
            places.tags[program.upper()] = number
        elif END_PROGRAM.fullmatch(line):
            program = ""
        elif TAG_LINE.fullmatch(line) or (PROGRAM_HEAD.fullmatch(line) and not is_controller):
            places.tags[program.upper()] = number
        elif match := ROUTINE_HEAD.fullmatch(line):
            name = scoped(program, match.group(1)).upper()
            places.heads[name] = number
            if not match.group(2):
                places.rungs[name] = list(_rungs(lines, number))
                number = places.rungs[name][-1].end if places.rungs[name] else number
    return places


def _rungs(lines: list[str], number: int) -> Iterator[_Lines]:
    """Yield the rungs of a routine, beginning with the line after its head."""
    comment = first = None
    for place in range(number, len(lines)):
        line = without_comment(lines[place])
        if first is None and line.upper() == "END":
            return
        if first is None and not line:
            comment = place if comment is None and lines[place].strip() else comment
            continue
        first = place if first is None else first
        if line.endswith(";"):
            yield _Lines(first if comment is None else comment, first, place + 1)
            comment = first = None
