"""Reads program files, see `rungfile`, and libraries, line by line."""

from __future__ import annotations

import json
import re
from bisect import bisect_right
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from difflib import get_close_matches
from functools import cache
from importlib.resources import files
from itertools import accumulate

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.doors import json_value
from scanrack.io_images.site import Site
from scanrack.io_images.times import TIME, parse_time

from ..lowering.addon import ROUTINES, AddOn, Parameter, ParameterMode, specs_of
from ..lowering.calls import model_number
from ..lowering.controller import Controller
from ..lowering.dialects import DIALECTS, LOGIX
from ..lowering.program import Program
from ..lowering.text import parse_rung
from ..model.chart import DEFAULT_OPTIONS, ChartOptions, ExecutionControl, LastScan, RestartPosition
from ..model.errors import LadderError, RungTextError
from ..model.expressions import TAG_NAME, parse_address
from ..model.predefined.structures import PREDEFINED_TYPES
from ..model.routine import Routine
from ..model.schedule import Task, TaskKind
from ..model.stubs import NO_STUBS, Stubs
from ..model.tags import Alias, SlotAlias, Tag
from ..model.tree import Rung
from ..model.types import DataType, Elementary, Member, Structure
from .chartreader import ChartReader
from .drive_blocks import for_drives
from .linereader import LineReader, cut_comment, without_comment

LIBRARIES = ("axis3601",)
"""Libraries of add-on instructions that come with scanrack; `USE name` includes one."""


@dataclass(frozen=True)
class Library:
    """Shared types by name, and add-on instructions by uppercase name."""

    types: Mapping[str, DataType]
    add_ons: Mapping[str, AddOn]


def load_library(name: str, *, drives: bool = False) -> Library:
    """Read a scanrack library; raise a LadderError if the name is unknown.

    Args:
        drives: whether the library is for a rack with a networked drive, see `drive_blocks`.
    """
    if name.lower() not in LIBRARIES:
        raise LadderError(f"no library {name}; choose from {', '.join(LIBRARIES)}")
    return _library(f"{name.lower()}.rung", drives)


@cache
def _library(file: str, drives: bool) -> Library:
    text = (files(__package__.rpartition(".")[0]) / "blocks" / file).read_text(encoding="utf-8")
    return Reader(for_drives(text) if drives else text, file).library()


def is_of_library(definition: AddOn, name: str) -> bool:
    """Return whether an add-on instruction belongs to a library, with or without changes for drives."""
    key = definition.name.upper()
    return any(load_library(name, drives=drives).add_ons.get(key) == definition for drives in (False, True))


_NAME = r"[A-Za-z_]\w*"
_LIBRARY = re.compile(rf"LIBRARY\s+({_NAME})", re.IGNORECASE)
PROGRAM_HEAD = re.compile(
    rf"PROGRAM\s+({_NAME})(?:\s+MAIN\s+({_NAME}))?(?:\s+FAULT\s+({_NAME}))?", re.IGNORECASE
)
CONTROLLER_HEAD = re.compile(rf"CONTROLLER\s+({_NAME})", re.IGNORECASE)
_TASK = re.compile(
    rf"TASK\s+({_NAME})\s*:\s*(?:(CONTINUOUS|EVENT)|PERIODIC\s+({TIME}))"
    rf"(?:\s+PRIORITY\s+(\d+))?(\s+PREEMPT)?(?:\s+RUNS\s+({_NAME}(?:\s*,\s*{_NAME})*+))?",
    re.IGNORECASE,
)
END_PROGRAM = re.compile(r"END\s+PROGRAM", re.IGNORECASE)
_DIALECT = re.compile(r"DIALECT\s+(\w+)", re.IGNORECASE)
_ALLOW = re.compile(r"ALLOW\s+(.+)", re.IGNORECASE)
_CHARTS = re.compile(r"CHARTS\s+(\w+)\s+(\w+)\s+(\w+)", re.IGNORECASE)
_TYPE = re.compile(rf"TYPE\s+({_NAME})\s*\((.*)\)", re.IGNORECASE)
TAG_LINE = re.compile(
    rf"TAG\s+([IO]:\d{{1,3}}|{TAG_NAME})\s*:\s*({_NAME})\s*(?:\[([\d,\s]+)\])?\s*(?::=\s*(.+))?",
    re.IGNORECASE,
)
_SLOT = re.compile(rf"SLOT\s+({_NAME})\s*:\s*(\d{{1,5}})", re.IGNORECASE)
_ALIAS = re.compile(rf"ALIAS\s+({TAG_NAME})\s*:\s*(\S+)(?:\s+AS\s+({_NAME}))?", re.IGNORECASE)
_STUB = re.compile(rf"STUB\s+(\\?{_NAME}(?:\.{_NAME})*+)\s*:\s*(\S.*)", re.IGNORECASE)
_USE = re.compile(rf"USE\s+({_NAME})", re.IGNORECASE)
INSTRUCTION_HEAD = re.compile(rf"INSTRUCTION\s+({_NAME})", re.IGNORECASE)
_PARAMETER = re.compile(
    rf"({'|'.join(mode.value for mode in ParameterMode)})\s+({_NAME})\s*:\s*({_NAME})\s*"
    r"(?:\[([\d,\s]+)\])?(\s+REQUIRED)?(?:\s+AT\s+([^\s:=]+))?\s*(?::=\s*(.+))?",
    re.IGNORECASE,
)
END_INSTRUCTION = re.compile(r"END\s+INSTRUCTION", re.IGNORECASE)
ROUTINE_HEAD = re.compile(rf"ROUTINE\s+({_NAME})(?:\s+(ST|SFC))?", re.IGNORECASE)
_DECLARES = re.compile(r"(?:USE|TYPE|INSTRUCTION|TAG|SLOT|ALIAS|STUB)\s+[A-Za-z_]", re.IGNORECASE)
"""The beginning of a declaration line; no statement begins this way."""

_COMMENTS = re.compile(r"(?:\s+|//[^\n]*|\(\*.*?\*\)|/\*.*?\*/)*+", re.DOTALL)
"""White space and comments of structured text."""

MAIN = "Main"
"""Name of the routine in a file of structured text."""

_MEMBER = re.compile(
    rf"({_NAME})\s*:\s*({_NAME})\s*(?:\[([\d,\s]+)\])?(?:\s+AT\s+(\S+))?(\s+HIDDEN)?", re.IGNORECASE
)

_DIGITS = 9  # maximum digits of an array length

_MARK = "\0"  # begins a JSON string that replaces a number with a radix

_RADIX = re.compile(r'"(?:[^"\\]++|\\.)*+"|(?P<number>\b(?:16#[0-9A-Fa-f_]+|8#[0-7_]+|2#[01_]+))')
"""A JSON string, or a number with a radix."""


class Reader(LineReader):
    """Reads a program line by line."""

    def __init__(self, text: str, file: str, stubs: Stubs = NO_STUBS) -> None:
        lines = text.splitlines()
        super().__init__(lines, 0, len(lines), file, DIALECTS[LOGIX])
        self._text = "\n".join(self._lines)
        # offsets of the lines in the text
        self._starts = [0, *accumulate(len(line) + 1 for line in self._lines)]
        self._types = dict(PREDEFINED_TYPES)
        self._add_ons: dict[str, AddOn] = {}
        self._rack_stubs = stubs
        self._stubs = dict(stubs.by_name)
        self._builtin = DIALECTS[LOGIX]
        self._update_specs()
        self._in_program = False

    def _update_specs(self) -> None:
        self._specs = specs_of(self._add_ons, self._stubs, self._builtin)

    def library(self) -> Library:
        """Read a library."""
        self._next(_LIBRARY, "LIBRARY name")
        while (line := self._peek()) is not None:
            if not self._definition(line):
                self._fail("TYPE or INSTRUCTION")
        types = {key: kind for key, kind in self._types.items() if key not in PREDEFINED_TYPES}
        return Library(types, self._add_ons)

    def program(self) -> Program | Controller:
        """Read a program or a controller."""
        if CONTROLLER_HEAD.fullmatch(self._peek() or ""):
            return self._controller()
        head = self._next(PROGRAM_HEAD, "PROGRAM name or CONTROLLER name")
        dialect = self._dialect()
        program = Program(
            head.group(1), main=head.group(2), fault=head.group(3), allow=self._allowed(), dialect=dialect
        )
        program.chart_options = self._chart_options()
        while self._peek() is not None:
            self._declaration(program)
        program.take_stubs(self._rack_stubs)
        return program

    def _dialect(self) -> str:
        """Read the DIALECT line; return the dialect, or the default without a line."""
        line = self._peek() or ""
        match = _DIALECT.fullmatch(line)
        if match is None:
            return LOGIX
        if match.group(1).lower() not in DIALECTS:
            self._fail(f"a dialect ({', '.join(DIALECTS)})", match.group(1))
        self._line_index += 1
        self._builtin = DIALECTS[match.group(1).lower()]
        self._update_specs()
        return match.group(1).lower()

    def _allowed(self) -> tuple[str, ...]:
        """Read ALLOW lines; return the allowed warnings."""
        allowed = []
        while (line := self._peek()) and (match := _ALLOW.fullmatch(line)):
            allowed.append(match.group(1).strip())
            self._line_index += 1
        return tuple(allowed)

    def _chart_options(self) -> ChartOptions:
        """Read the CHARTS line; return the options, or the default without a line."""
        match = _CHARTS.fullmatch(self._peek() or "")
        if match is None:
            return DEFAULT_OPTIONS
        kinds = (ExecutionControl, RestartPosition, LastScan)
        for word, kind in zip(match.groups(), kinds, strict=True):
            if word.upper() not in kind.__members__:
                self._fail(f"CHARTS with one of {', '.join(kind.__members__)}", word)
        self._line_index += 1
        control, restart, last_scan = map(str.upper, match.groups())
        return ChartOptions(ExecutionControl(control), RestartPosition(restart), LastScan(last_scan))

    def _controller(self) -> Controller:
        """Read a controller with its declarations, tasks and programs."""
        head = self._next(CONTROLLER_HEAD, "CONTROLLER name")
        controller = Controller(head.group(1), allow=self._allowed())
        controller.chart_options = self._chart_options()
        while (line := self._peek()) is not None:
            if match := PROGRAM_HEAD.fullmatch(line):
                self._line_index += 1
                self._block(controller.program(match.group(1), main=match.group(2), fault=match.group(3)))
            elif match := _TASK.fullmatch(line):
                controller.add_task(self._task(match, _comment_of(self._lines[self._line_index])))
                self._line_index += 1
            elif ROUTINE_HEAD.fullmatch(line):
                self._fail("PROGRAM: in a controller a routine is in a program")
            else:
                self._declaration(controller)
        controller.take_stubs(self._rack_stubs)
        return controller

    def _block(self, program: Program) -> None:
        """Read a program of a controller, up to END PROGRAM."""
        self._in_program = True
        while (line := self._peek()) and not END_PROGRAM.fullmatch(line):
            self._declaration(program)
        self._next(END_PROGRAM, "END PROGRAM")
        self._in_program = False

    def _task(self, match: re.Match[str], comment: str) -> Task:
        """Return the task that a TASK line declares."""
        name, kind_word, rate, priority, preempt, programs = match.groups()
        kind = TaskKind[kind_word.upper()] if kind_word else TaskKind.PERIODIC
        try:
            rate_ns = parse_time(rate.lower()) if rate else 0
        except ValueError as error:
            raise LadderError(str(error)) from None
        return Task(
            name=name,
            kind=kind,
            programs=tuple(program.strip() for program in programs.split(",")) if programs else (),
            rate_ns=rate_ns,
            priority=int(priority or 10),
            preempt=bool(preempt),
            comment=comment,
        )

    def structured(self, name: str) -> Program:
        """Read structured text after optional declarations; `name` is the default program name."""
        start = self._skip_comments(0)
        head = PROGRAM_HEAD.fullmatch(self._line_at(start))
        program = Program(head.group(1) if head else re.sub(r"\W", "_", name))
        self._structured_routine(program, start + 1 if head else start, MAIN)
        program.take_stubs(self._rack_stubs)
        return program

    def _structured_routine(self, program: Program, start: int, name: str) -> None:
        """Read declarations that begin at a line, and the statements after them as a routine."""
        self._line_index = start
        while _DECLARES.match(self._line_at(self._skip_comments(start))):
            self._line_index = self._skip_comments(start)
            self._declaration(program)
            start = self._line_index
        # blank lines replace the declarations, so that statements keep their line numbers
        self._lines[:start] = [""] * start
        program.add_routine(Routine(name, (), statements=self._statements(0, self._end)))

    def add_to(self, program: Program, routine: str | None = None) -> None:
        """Read more declarations and routines into a program.

        Args:
            routine: name of the single routine if statements follow the declarations.
        """
        self._add_ons, self._stubs, self._builtin = dict(program.add_ons), program.stubs, program.builtin
        self._types |= {structure.name: structure for structure in program.structures()}
        self._specs = program.specs
        if routine is not None:
            self._structured_routine(program, 0, routine)
            return
        while self._peek() is not None:
            self._declaration(program)

    def _line_at(self, number: int) -> str:
        """Return a line without its comment; "" after the last line."""
        return without_comment(self._lines[number]) if number < self._end else ""

    def _skip_comments(self, number: int) -> int:
        """Return the first line at or after `number` that is neither blank nor inside a comment."""
        match = _COMMENTS.match(self._text, self._starts[number])
        assert match is not None, "the pattern also matches nothing"
        return max(number, bisect_right(self._starts, match.end()) - 1)

    def _next(self, pattern: re.Pattern[str], expected: str) -> re.Match[str]:
        """Read a line that matches a pattern; if it does not match, fail with the expected text."""
        line = self._peek()
        match = pattern.fullmatch(line) if line else None
        if match is None:
            self._fail(expected)
        self._line_index += 1
        return match

    @contextmanager
    def _at_line(self, number: int) -> Iterator[None]:
        """Add the file and line to declaration errors in the body of a `with` statement."""
        try:
            yield
        except LadderError as error:
            raise LadderError.at(Site(file=self._file, line=number + 1), str(error)) from None

    def _declaration(self, program: Program | Controller) -> None:
        """Read a declaration, definition or routine into a program; fail for any other line."""
        line = self._peek() or ""
        comment = _comment_of(self._lines[self._line_index])
        if self._definition(line):
            program.use(*self._add_ons.values())
            return
        if match := TAG_LINE.fullmatch(line):
            kind, dims = self._type(match.group(2)), self._dims(match.group(3))
            program.add(Tag(match.group(1), kind, dims, self._initial(match.group(4), kind), comment))
        elif match := _SLOT.fullmatch(line):
            program.add(SlotAlias(match.group(1), int(match.group(2)), comment))
        elif match := _STUB.fullmatch(line):
            if self._in_program:
                self._fail("STUB before the programs of a controller")
            with self._at_line(self._line_index):
                program.stub(match.group(1), match.group(2))
            self._stubs = {**program.stubs, **self._rack_stubs.by_name}
            self._update_specs()
        elif match := _ALIAS.fullmatch(line):
            bound = self._structure(match.group(3)) if match.group(3) else None
            program.add(Alias(match.group(1), parse_address(match.group(2)), comment, bound))
        elif isinstance(program, Program) and (match := ROUTINE_HEAD.fullmatch(line)):
            program.add_routine(self._routine(match))
            return
        else:
            sections = "ROUTINE" if isinstance(program, Program) else "TASK, PROGRAM"
            self._fail(f"USE, TYPE, INSTRUCTION, TAG, SLOT, ALIAS, STUB or {sections}")
        self._line_index += 1

    def _definition(self, line: str) -> bool:
        """Read a definition of types or instructions; return whether there was a definition."""
        if match := _USE.fullmatch(line):
            self._use(match.group(1))
        elif match := _TYPE.fullmatch(line):
            members = tuple(self._member(member) for member in _split_members(match.group(2)))
            with self._at_line(self._line_index):
                self._types[match.group(1)] = Structure(match.group(1), members)
        elif match := INSTRUCTION_HEAD.fullmatch(line):
            self._instruction(match.group(1))
            return True
        else:
            return False
        self._line_index += 1
        return True

    def _use(self, name: str) -> None:
        """Add the types and instructions of a library, in the version for the modules in the rack."""
        try:
            library = load_library(name, drives=any(map(model_number, self._rack_stubs.modules.values())))
        except LadderError:
            self._fail(f"a library ({', '.join(LIBRARIES)})", name)
        self._types.update(library.types)
        self._add_ons.update(library.add_ons)
        self._update_specs()

    def _instruction(self, name: str) -> None:
        """Read an add-on instruction, up to END INSTRUCTION; add it and its type."""
        start = self._line_index
        comment = _comment_of(self._lines[start])
        self._line_index += 1
        parameters: list[Parameter] = []
        routines: list[Routine] = []
        while (line := self._peek()) and not END_INSTRUCTION.fullmatch(line):
            if match := ROUTINE_HEAD.fullmatch(line):
                if match.group(1).upper() not in map(str.upper, ROUTINES):
                    self._fail(f"one of the routines {', '.join(ROUTINES)}", match.group(1))
                routines.append(self._routine(match))
            else:
                parameters.append(self._parameter(line))
        if line is None:
            self._fail("END INSTRUCTION")
        self._line_index += 1
        with self._at_line(start):
            definition = AddOn(name, tuple(parameters), tuple(routines), comment)
        self._add_ons[name.upper()] = definition
        self._update_specs()
        self._types[name] = definition.structure

    def _parameter(self, line: str) -> Parameter:
        """Read the line of a parameter."""
        match = _PARAMETER.fullmatch(line)
        if match is None:
            self._fail("INPUT, OUTPUT, INOUT or LOCAL name : TYPE, ROUTINE, or END INSTRUCTION")
        mode, name, kind_name, dims, required, overlay, initial = match.groups()
        kind = self._type(kind_name)
        comment = _comment_of(self._lines[self._line_index])
        parameter = Parameter(
            name=name,
            type=kind,
            mode=ParameterMode(mode.upper()),
            dims=self._dims(dims),
            required=bool(required),
            comment=comment,
            initial=self._initial(initial, kind),
            at=overlay or "",
        )
        self._line_index += 1
        return parameter

    def _member(self, text: str) -> Member:
        """Return the member of a structure that a part of a TYPE line declares."""
        match = _MEMBER.fullmatch(text.strip())
        if match is None:
            self._fail("members as name : TYPE", repr(text.strip()))
        name, kind, dims, overlay, hidden = match.groups()
        return Member(name, self._type(kind), self._dims(dims), at=overlay or "", hidden=bool(hidden))

    def _type(self, name: str) -> DataType:
        """Return the type with a name, in any case; fail with a hint if there is none."""
        for known_name, kind in self._types.items():
            if known_name.upper() == name.upper():
                return kind
        return self._fail(f"a type ({self._type_hint(name)})", name)

    def _type_hint(self, name: str) -> str:
        """Return a hint for an unknown type: its library, a close name, or the known types."""
        for library in LIBRARIES:
            if any(known.upper() == name.upper() for known in load_library(library).types):
                return f"{name} is in library {library}: write USE {library} above"
        close = get_close_matches(name.upper(), [known.upper() for known in self._types], 2, 0.7)
        return f"did you mean {' or '.join(close)}?" if close else ", ".join(self._types)

    def _structure(self, name: str) -> Structure:
        kind = self._type(name)
        return kind if isinstance(kind, Structure) else self._fail("a structure", name)

    def _dims(self, text: str | None) -> tuple[int, ...]:
        """Return the dimensions in brackets; () without brackets."""
        lengths = text.split(",") if text is not None else []
        if not all(length.strip().isdecimal() and len(length) <= _DIGITS for length in lengths):
            self._fail("the length of each dimension, as in [4] or [2,3]", repr(f"[{text}]"))
        return tuple(map(int, lengths))

    def _initial(self, text: str | None, kind: DataType) -> object:
        """Return an initial value from JSON, with the bits of numbers such as 16#FF; None without a text."""
        if text is None:
            return None
        try:
            return _patterns(json_value(_RADIX.sub(_quoted, text)), kind)
        except ValueError:
            self._fail("an initial value in JSON after :=, integers also as 16#843C", text)

    def _routine(self, head: re.Match[str]) -> Routine:
        """Read a routine up to END: rungs, structured text or a chart."""
        self._line_index += 1
        if not head.group(2):
            return Routine(head.group(1), tuple(self._rungs()))
        start = self._line_index
        while self._line_index < self._end and self._line_at(self._line_index).upper() != "END":
            self._line_index += 1
        if self._line_index == self._end:
            self._fail("END of the routine")
        self._line_index += 1
        if head.group(2).upper() == "SFC":
            reader = ChartReader(self._lines, start, self._line_index - 1, self._file, self._specs)
            return Routine(head.group(1), (), chart=reader.chart())
        return Routine(head.group(1), (), statements=self._statements(start, self._line_index - 1))

    def _rungs(self) -> Iterator[Rung]:
        """Read rungs up to END, and yield them with their comments."""
        number = 0
        while True:
            comment = self._comments()
            line = self._peek()
            if line is None:
                self._fail("END of the routine")
            if line.upper() == "END":
                self._line_index += 1
                return
            yield self._rung(number, comment)
            number += 1

    def _comments(self) -> str:
        """Skip blank lines and comments; return the text of the comments."""
        comments = []
        while self._line_index < self._end:
            line = self._lines[self._line_index].strip()
            if line and not line.startswith("//"):
                break
            if line:
                comments.append(line[2:].strip())
            self._line_index += 1
        return "\n".join(comments)

    def _rung(self, number: int, comment: str) -> Rung:
        """Read a rung up to its semicolon; END before the semicolon is an error."""
        start = self._line_index
        texts: list[str] = []
        while self._line_index < self._end:
            code = cut_comment(self._lines[self._line_index])
            if texts and code.strip().upper() == "END":
                break
            texts.append(code)
            self._line_index += 1
            if code.rstrip().endswith(";"):
                break
        text = "\n".join(texts)
        rung = parse_rung(
            text, file=self._file, line=start + 1, rung=number, comment=comment, specs=self._specs
        )
        if not text.rstrip().endswith(";"):
            site = Site(file=self._file, line=self._line_index, column=len(texts[-1]) + 1, rung=number)
            raise RungTextError("; at the end of the rung", "END", site)
        return rung


def _comment_of(line: str) -> str:
    return line[len(cut_comment(line)) :].removeprefix("//").strip()


def _quoted(match: re.Match[str]) -> str:
    """Quote a number with a radix as a marked JSON string; leave strings alone."""
    return json.dumps(_MARK + match.group("number")) if match.group("number") else match.group()


def _patterns(value: object, kind: DataType | None) -> object:
    """Replace each marked number with the value that has the same bits in the type `kind`."""
    if isinstance(value, list):
        return [_patterns(element, kind) for element in value]
    if isinstance(value, dict):
        return {name: _patterns(element, _member_type(kind, name)) for name, element in value.items()}
    if not isinstance(value, str) or not value.startswith(_MARK):
        return value
    radix, digits = value.removeprefix(_MARK).split("#")
    number = int(digits, int(radix))
    if isinstance(kind, Elementary) and kind.is_integer and kind.highest < number < 1 << kind.bits:
        number -= 1 << kind.bits
    return number


def _member_type(kind: DataType | None, name: str) -> DataType | None:
    member = kind.member(name) if isinstance(kind, Structure) else None
    return member.type if member else None


def _split_members(text: str) -> list[str]:
    # not at the commas of dimensions, as in `Grid : DINT[2,3]`
    return [member for member in re.split(r",(?![^\[]*\])", text) if member.strip()]
