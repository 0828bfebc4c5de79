"""Programs as neutral text: `.rung` files with tags and routines, read and written.

    PROGRAM line
    TYPE Step (Time : DINT, Valve : BOOL)
    TAG Run : BOOL
    TAG Recipe : Step[10] := [{"Time": 100}]      // what a tag starts with is JSON
    SLOT axis : 1
    ALIAS Go : Local:1:I.Data[1].2
    ROUTINE Main
    // said of the rung below
    [XIC(Go),XIC(Run)]XIO(axis.status.INPUT_ERROR)OTE(Run);
    END

The first routine is the main one unless PROGRAM says `MAIN name`. A rung ends with
its semicolon and may take several lines; `//` starts a comment.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import NoReturn

from .errors import LadderError, RungTextError
from .logic import Program
from .tags import Alias, SlotAlias, Tag
from .text import parse_address, parse_rung
from .tree import Routine, Rung
from .types import TYPES, DataType, Elementary, Member, Structure

SUFFIX = ".rung"
"""How the name of a program file ends."""

_NAME = r"[A-Za-z_]\w*"
_PROGRAM = re.compile(rf"PROGRAM\s+({_NAME})(?:\s+MAIN\s+({_NAME}))?", re.IGNORECASE)
_ALLOW = re.compile(r"ALLOW\s+(.+)", re.IGNORECASE)
_TYPE = re.compile(rf"TYPE\s+({_NAME})\s*\((.*)\)", re.IGNORECASE)
_TAG = re.compile(rf"TAG\s+({_NAME})\s*:\s*({_NAME})\s*(?:\[([\d,\s]+)\])?\s*(?::=\s*(.+))?", re.IGNORECASE)
_SLOT = re.compile(rf"SLOT\s+({_NAME})\s*:\s*(\d+)", re.IGNORECASE)
_ALIAS = re.compile(rf"ALIAS\s+({_NAME})\s*:\s*(\S+)", re.IGNORECASE)
_ROUTINE = re.compile(rf"ROUTINE\s+({_NAME})", re.IGNORECASE)
_MEMBER = re.compile(rf"({_NAME})\s*:\s*({_NAME})\s*(?:\[([\d,\s]+)\])?")


def read_program(path: Path | str) -> Program:
    """Read a program from a file.

    Raises:
        RungTextError: something in it is not what was expected; file, rung, line and column.
        LadderError: a declaration that is not allowed.
        OSError: the file can't be read.
    """
    file = Path(path)
    return parse_program(file.read_text(encoding="utf-8"), file=str(file))


def parse_program(text: str, *, file: str = "") -> Program:
    """Read a program from text, see `read_program`."""
    return _Reader(text, file).read()


def write_program(program: Program, path: Path | str) -> None:
    """Write a program to a file.

    Raises:
        LadderError: it has routines in Python, which are no text.
    """
    Path(path).write_text(program_text(program), encoding="utf-8")


def program_text(program: Program) -> str:
    """Return a program as text that reads as the same program.

    Raises:
        LadderError: it has routines in Python, which are no text.
    """
    if program.functions:
        names = ", ".join(program.functions)
        raise LadderError(f"program {program.name} has routines in Python ({names}): they are no rung text")
    lines = [f"PROGRAM {program.name}" + (f" MAIN {program.main}" if program.main else "")]
    lines += [f"ALLOW {name}" for name in sorted(program.allowed)]
    lines += ["", *_types(program), *_declarations(program)]
    for routine in program.routines:
        lines += ["", f"ROUTINE {routine.name}"]
        for rung in routine.rungs:
            lines += [f"// {line}" for line in rung.comment.splitlines()] + [str(rung)]
        lines.append("END")
    return "\n".join(lines) + "\n"


def _types(program: Program) -> Iterator[str]:
    """Structures, those first that others are made of."""
    seen = dict(TYPES)

    def walk(kind: DataType) -> Iterator[str]:
        if isinstance(kind, Elementary) or kind.name in seen:
            return
        for member in kind.members:
            yield from walk(member.type)
        seen[kind.name] = kind
        yield f"TYPE {kind.name} ({', '.join(_member_text(member) for member in kind.members)})"

    for declaration in program.declarations:
        if isinstance(declaration, Tag):
            yield from walk(declaration.type)


def _member_text(member: Member) -> str:
    return f"{member.name} : {member.type.name}{_dims_text(member.dims)}"


def _dims_text(dims: tuple[int, ...]) -> str:
    return f"[{','.join(map(str, dims))}]" if dims else ""


def _declarations(program: Program) -> Iterator[str]:
    for each in program.declarations:
        if isinstance(each, Tag):
            initial = "" if each.initial is None else f" := {json.dumps(each.initial)}"
            text = f"TAG {each.name} : {each.type.name}{_dims_text(each.dims)}{initial}"
        elif isinstance(each, SlotAlias):
            text = f"SLOT {each.name} : {each.slot}"
        else:
            text = f"ALIAS {each.name} : {each.target}"
        yield text + (f"  // {each.comment}" if each.comment else "")


class _Reader:
    """Reads a program line by line."""

    def __init__(self, text: str, file: str) -> None:
        self._lines = text.splitlines()
        self._file = file
        self._at = 0
        self._types = dict(TYPES)

    def read(self) -> Program:
        head = self._next(_PROGRAM, "PROGRAM name")
        allowed = []
        while (line := self._peek()) and (found := _ALLOW.fullmatch(line)):
            allowed.append(found.group(1).strip())
            self._at += 1
        program = Program(head.group(1), main=head.group(2), allow=allowed)
        while self._peek() is not None:
            self._declaration(program)
        return program

    def _peek(self) -> str | None:
        """Return the next line that says something, without its comment."""
        while self._at < len(self._lines):
            line = _without_comment(self._lines[self._at])
            if line:
                return line
            self._at += 1
        return None

    def _next(self, pattern: re.Pattern[str], expected: str) -> re.Match[str]:
        line = self._peek()
        found = pattern.fullmatch(line) if line else None
        if found is None:
            self._fail(expected)
        self._at += 1
        return found

    def _fail(self, expected: str, line: str | None = None) -> NoReturn:
        text = self._lines[self._at] if self._at < len(self._lines) else ""
        column = len(text) - len(text.lstrip()) + 1
        shown = repr(text.strip()) if text.strip() else "the end of the file"
        raise RungTextError(
            expected, line or shown, file=self._file, line=self._at + 1, column=column, rung=None
        )

    def _declaration(self, program: Program) -> None:
        line = self._peek() or ""
        comment = _comment_of(self._lines[self._at])
        if found := _TYPE.fullmatch(line):
            members = tuple(self._member(each) for each in _split(found.group(2)))
            self._types[found.group(1)] = Structure(found.group(1), members)
        elif found := _TAG.fullmatch(line):
            kind, dims = self._type(found.group(2)), _dims(found.group(3))
            program.add(Tag(found.group(1), kind, dims, self._initial(found.group(4)), comment))
        elif found := _SLOT.fullmatch(line):
            program.add(SlotAlias(found.group(1), int(found.group(2)), comment))
        elif found := _ALIAS.fullmatch(line):
            program.add(Alias(found.group(1), parse_address(found.group(2)), comment))
        elif found := _ROUTINE.fullmatch(line):
            self._at += 1
            program.add_routine(Routine(found.group(1), tuple(self._rungs())))
            return
        else:
            self._fail("TYPE, TAG, SLOT, ALIAS or ROUTINE")
        self._at += 1

    def _member(self, text: str) -> Member:
        found = _MEMBER.fullmatch(text.strip())
        if found is None:
            self._fail("members as name : TYPE", repr(text.strip()))
        return Member(found.group(1), self._type(found.group(2)), _dims(found.group(3)))

    def _type(self, name: str) -> DataType:
        for known, kind in self._types.items():
            if known.upper() == name.upper():
                return kind
        return self._fail(f"a type ({', '.join(self._types)})", name)

    def _initial(self, text: str | None) -> object:
        if text is None:
            return None
        try:
            return json.loads(text)
        except ValueError:
            self._fail("an initial value in JSON after :=", text)

    def _rungs(self) -> Iterator[Rung]:
        """Yield the rungs up to END."""
        number = 0
        while True:
            comment = self._comments()
            line = self._peek()
            if line is None:
                self._fail("END of the routine")
            if line.upper() == "END":
                self._at += 1
                return
            yield self._rung(number, comment)
            number += 1

    def _comments(self) -> str:
        said = []
        while self._at < len(self._lines):
            line = self._lines[self._at].strip()
            if line and not line.startswith("//"):
                break
            if line:
                said.append(line[2:].strip())
            self._at += 1
        return "\n".join(said)

    def _rung(self, number: int, comment: str) -> Rung:
        start = self._at
        texts: list[str] = []
        while self._at < len(self._lines):
            line = self._lines[self._at]
            kept = _cut_comment(line)
            if texts and kept.strip().upper() == "END":
                break
            texts.append(kept)
            self._at += 1
            if kept.rstrip().endswith(";"):
                break
        text = "\n".join(texts)
        rung = parse_rung(text, file=self._file, line=start + 1, rung=number, comment=comment)
        if not text.rstrip().endswith(";"):
            raise RungTextError(
                "; at the end of the rung",
                "END",
                file=self._file,
                line=self._at,
                column=len(texts[-1]) + 1,
                rung=number,
            )
        return rung


def _cut_comment(line: str) -> str:
    """Cut off `//` and what follows, unless it stands in quotes."""
    quoted = ""
    for at, mark in enumerate(line):
        if mark in "'\"" and quoted in ("", mark):
            quoted = "" if quoted else mark
        elif not quoted and line.startswith("//", at):
            return line[:at]
    return line


def _without_comment(line: str) -> str:
    return _cut_comment(line).strip()


def _comment_of(line: str) -> str:
    return line[len(_cut_comment(line)) :].removeprefix("//").strip()


def _dims(text: str | None) -> tuple[int, ...]:
    return tuple(int(each) for each in text.split(",")) if text else ()


def _split(text: str) -> list[str]:
    """Split at commas outside of brackets."""
    return [each for each in re.split(r",(?![^\[]*\])", text) if each.strip()]
