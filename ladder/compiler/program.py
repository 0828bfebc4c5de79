"""A lowered program as Python code, with one function per routine; the main function is `scan`."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence, Set
from functools import partial

from scanrack.io_images.dataclass import dataclass

from ..state.lowered import LoweredLine, LoweredProgram, LoweredRoutine
from .calls import function_name, parameters_of
from .observed import NOTED, NOTES, UNOBSERVED, NoteList, Notes, Observation
from .power_notes import write_rung
from .rungs import RungWriter
from .statements import StatementWriter
from .writer import INDENT, Writer

_NAMES = re.compile(r"[^\W\d]\w*")


@dataclass(frozen=True, slots=True)
class FunctionText:
    """The Python code of a routine's function: lines with their line numbers in the source file."""

    name: str
    routine: LoweredRoutine
    lines: Sequence[tuple[str, int]]

    def used(self) -> set[str]:
        """Return all names in the code."""
        return set(_NAMES.findall("\n".join([text for text, _ in self.lines])))

    def unit(self, idents: Set[str]) -> tuple[str, list[int]]:
        """Return the code to compile, without comments, and the source line number of each line."""
        head = f"def program({', '.join(sorted(self.used() & idents))}):"
        body = [(text, line) for text, line in self.lines if text and not text.lstrip().startswith("#")]
        texts = [head, f"{INDENT}global {self.name}", *(INDENT + text for text, _ in body)]
        return "\n".join(texts) + "\n", [1, 1, *(line for _, line in body)]


@dataclass(frozen=True, slots=True)
class ProgramText:
    """The Python code of a program."""

    idents: Sequence[str]  # its variables
    parts: Sequence[FunctionText]  # its functions, add-on routines included
    file: str  # the rungs' file
    functions: dict[str, str]  # name of the function by routine in capitals, except add-on routines
    noted: NoteList  # the list of noted power

    @property
    def text(self) -> str:
        """The code as one function, for people to read."""
        used = {name for part in self.parts for name in part.used()}
        lines = [f"def program({', '.join(ident for ident in self.idents if ident in used)}):"]
        if self.parts:
            lines.append(f"{INDENT}global {', '.join(part.name for part in self.parts)}")
        for part in self.parts:
            lines += [INDENT + text if text else "" for text, _ in part.lines]
        return "\n".join(lines) + f"\n{INDENT}return\n"


def text_of(lowered: LoweredProgram, observation: Observation = UNOBSERVED) -> ProgramText:
    """Return the Python code of a program, including lines that note the power of observed rungs."""
    note_list = NoteList(len(observation.noted))
    notes = partial(Notes.of_routine, observation, note_list)
    functions = _function_names(lowered)
    called: set[tuple[str, bool]] = set()
    parts = []
    for key, name in functions.items():
        routine = lowered.routines[key]
        lines = _function_lines(lowered, routine, functions, name, called, notes(key))
        parts.append(FunctionText(name, routine, lines))
    written: set[tuple[str, bool]] = set()
    while waiting := sorted(called - written):  # an add-on routine may call others
        for key, based in waiting:
            name = function_name(key, based=based)
            routine = lowered.routines[key]
            lines = _function_lines(lowered, routine, functions, name, called, notes(key), based=based)
            parts.append(FunctionText(name, routine, lines))
        written.update(waiting)
    file = next((line.origin.file for owner in lowered.routines.values() for line in owner.lines), "")
    idents = tuple(lowered.layout.idents)
    return ProgramText(idents, parts, file or f"<ladder {lowered.name}>", functions, note_list)


def _function_names(lowered: LoweredProgram) -> dict[str, str]:
    """Return function names by uppercase routine name, except for add-on routines.

    Underscores are added to names that variables or other functions use.
    """
    used_names = set(lowered.layout.idents)
    names: dict[str, str] = {}
    for key, routine in lowered.routines.items():
        if routine.frame:
            continue
        name = "scan" if key == lowered.main else f"jsr_{re.sub(r'[^0-9A-Za-z_]', '_', routine.name)}"
        while name != "scan" and name in used_names:
            name += "_"
        names[key] = name
        used_names.add(name)
    return names


def _function_lines(
    lowered: LoweredProgram,
    routine: LoweredRoutine,
    functions: dict[str, str],
    name: str,
    called: set[tuple[str, bool]],
    notes: Notes,
    *,
    based: bool = False,
) -> list[tuple[str, int]]:
    """Return the lines of a function; add the add-on routines that it calls to `called`."""
    writer = Writer(lowered, routine.frame, based=based, routine=routine.name)
    rungs = RungWriter(writer, functions, notes)
    if routine.name.upper() == lowered.main and lowered.override:
        rungs.set_override("False")
    if routine.body is not None:
        StatementWriter(rungs).body(routine.body)
    elif routine.labels:
        _write_sections(writer, rungs, routine)
    else:
        for line in routine.lines:
            _write_rung(writer, rungs, line, preempted=lowered.is_preempted(routine.name))
    called |= writer.called
    parameters = ["now", "given"]
    if routine.frame:
        parameters = parameters_of(rungs.values, tuple(lowered.frames[routine.frame].layout.inouts))
    head = [f"def {name}({', '.join(parameters)}):"]
    names = ", ".join(sorted(writer.written))
    wrapped = textwrap.wrap(names, 100, break_long_words=False, break_on_hyphens=False)
    head += [f"{INDENT}nonlocal {names_part.rstrip(',')}" for names_part in wrapped]
    head += [f"{INDENT}{ident}_ = {ident}.tolist()" for ident in sorted(writer.inputs)]
    if notes.places:
        head.append(f"{INDENT}{NOTES} = {NOTED}")
    writer.fill()
    return [*((text, 1) for text in head), *writer.lines, ("", 1)]


def _write_rung(writer: Writer, rungs: RungWriter, line: LoweredLine, *, preempted: bool) -> None:
    """Write a rung, followed by a call to the scheduler if the program can be preempted."""
    writer.begin(line)
    power = f"not {rungs.override}" if writer.lowered.override else "True"
    write_rung(rungs, line, power)
    if preempted:
        writer.line("rung_done()")


def _write_sections(writer: Writer, rungs: RungWriter, routine: LoweredRoutine) -> None:
    """Write the sections between labels; a jump sets `at` and restarts the loop."""
    preempted = writer.lowered.is_preempted(routine.name)
    starts = sorted({0, *routine.labels.values()})
    rungs.sections = {label: starts.index(number) for label, number in routine.labels.items()}
    writer.line("at = 0")
    with writer.block("while True:"):
        for section, start in enumerate(starts):
            end = starts[section + 1] if section + 1 < len(starts) else len(routine.lines)
            rungs.section = section
            with writer.block(f"if at == {section}:"):
                for line in routine.lines[start:end]:
                    _write_rung(writer, rungs, line, preempted=preempted)
                writer.line(f"at = {section + 1}")
        writer.line("break")
