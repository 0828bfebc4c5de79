"""Checks edited rungs against the running program. Only the edited rungs are read and resolved again.

    running    0 1 2 3 4            routine Main
    edits      Main 2 -> two rungs, Main 4 -> none
    edited     0 1 2 3 4            3 is new, the running 3 is now 4

In a program of 1,000 rungs, a check takes 5 ms; building the program takes half a second.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from ..model.errors import LadderError, Problem, RungTextError
from ..model.expressions import TAG_NAME
from ..model.predefined.structures import PREDEFINED_TYPES
from ..model.routine import Routine
from ..model.tags import STATUS_FLAGS, Layout, Tag, program_of, scoped
from ..model.tree import Address, Origin, Rung, Step, instructions_of
from ..model.types import DataType, Elementary
from ..state.lowered import LoweredLine, LoweredRoutine
from .checks import check_whole, exclusive_places, warnings_of
from .guess import type_at
from .runnable import LadderLogic
from .text import parse_rung

NUMBERS = ("DINT", "INT", "SINT", "LINT", "REAL")
"""Numeric types, between which an operand's uses can't distinguish."""

_JUMPS = ("JMP", "JSR", "FOR", "SBR", "RET", "JXR")
"""Instructions that name a label or a routine."""

BEFORE_FIRST = -1
"""Rung number for an edit before the first rung of a routine."""


class RungEdit(NamedTuple):
    """The replacement of a rung of the running program."""

    routine: str  # as in a controller, `\\Main.Step`
    rung: int  # its number in the running program, or `BEFORE_FIRST`
    texts: tuple[str, ...]  # the new rungs: (), to delete it; further texts are new rungs after it
    keeps: bool = False  # whether the first text is the unchanged running rung


def normalized(edit: RungEdit, program: LadderLogic) -> RungEdit:
    """Return an edit with its texts in printed form; raise a RungTextError if one is not a rung."""
    texts = tuple(str(parse_rung(text, specs=program.specs)) for text in edit.texts)
    routines = (routine for routine in program.routines if routine.name.upper() == edit.routine.upper())
    rungs = next((routine.rungs for routine in routines), ())
    keeps = 0 <= edit.rung < len(rungs) and texts[:1] == (str(rungs[edit.rung]),)
    return edit._replace(texts=texts, keeps=keeps)


class NewTag(NamedTuple):
    """A tag that an edit declares."""

    name: str
    type: str
    program: str = ""  # a controller's program; "" for the program itself, or the controller's own tags

    @property
    def full_name(self) -> str:
        """Its name, after the name of a controller's program."""
        return scoped(self.program, self.name)


class FileChange(NamedTuple):
    """An element that edits changed in a program's file."""

    element: str  # `\\Main.Step rung 3`
    why: str


class Rewritten(NamedTuple):
    """The bytes of a program's file after edits, and its changes."""

    data: bytes
    changes: tuple[FileChange, ...]


def changes_of(edits: Iterable[RungEdit], tags: Iterable[NewTag]) -> Iterator[FileChange]:
    """Yield the changes that edits make to a file that has no rung numbers."""
    for edit in edits:
        if edit.rung != BEFORE_FIRST and not edit.keeps:
            change = "its text is edited" if edit.texts else "it is deleted"
            yield FileChange(f"{edit.routine} rung {edit.rung}", change)
        new = edit.texts if edit.rung == BEFORE_FIRST else edit.texts[1:]
        neighbor = "the first rung" if edit.rung == BEFORE_FIRST else f"rung {edit.rung}"
        yield from (FileChange(name, f"it is new at {neighbor} of {edit.routine}") for name in new)
    yield from (FileChange(f"tag {tag.name}", "it is new") for tag in tags)


class Mistake(NamedTuple):
    """A mistake in an edited rung, or a warning."""

    text: str
    element: int | None = None  # the instruction, in order of execution
    column: int | None = None  # of an unreadable text, from 1


class MissingTag(NamedTuple):
    """An undeclared tag, and its possible types."""

    name: str
    program: str
    types: tuple[str, ...]  # most likely type first; several if its use does not decide


@dataclass(slots=True)
class CheckedRung:
    """An edited rung."""

    edit: RungEdit
    text: str  # as written; the program's notation once it can be read
    rung: Rung | None = None  # None = it can't be read
    number: int = 0  # in the edited program
    mistakes: list[Mistake] = field(default_factory=list)
    warnings: list[Mistake] = field(default_factory=list)


def _exclusive_places_in(line: LoweredLine) -> Iterator[object]:
    """Yield the places in a line that only one instruction of a program should use."""
    return (place for step in line.steps for _, _, place in exclusive_places(step))


class RungIndex:
    """Rungs of a running program that edits of other rungs can affect; built once for many edits."""

    def __init__(self, program: LadderLogic) -> None:
        # routines in capitals and lines, by exclusive place
        self.places: dict[object, list[tuple[str, int]]] = {}
        self.jumps: dict[str, list[int]] = {}  # lines that jump or call, by routine in capitals
        for name, routine in program.build().routines.items():
            for number, line in enumerate(routine.lines):
                self.jumps.setdefault(name, []).extend(number for step in line.steps if step.name in _JUMPS)
                for place in _exclusive_places_in(line):
                    self.places.setdefault(place, []).append((name, number))
        self.warnings = {(warning.text, warning.rung) for warning in program.warnings}


class EditedProgram:
    """The rungs of an edit.

    Args:
        program: the running program, which is not changed.
        edits: at most one per rung.
        tags: the new tags.
        index: index of the program; None to build one.

    Attributes:
        rungs: the edited rungs, in order.
        missing: undeclared tags that they use.
        mistakes: mistakes in other rungs and in the whole program, with their places.

    Raises:
        LadderError: an edited rung does not exist, or a new tag can't be declared.
    """

    def __init__(
        self,
        program: LadderLogic,
        edits: Iterable[RungEdit],
        tags: Sequence[NewTag] = (),
        index: RungIndex | None = None,
    ) -> None:
        self._program, self._running = program, program.build()
        self._index = index or RungIndex(program)
        # lines of edited routines: the unedited ones by their old numbers, and the edited ones
        self._unedited_lines: dict[str, dict[int, LoweredLine]] = {}
        self._edited_lines: dict[str, list[LoweredLine]] = {}
        self.rungs: list[CheckedRung] = []
        self.mistakes: list[str] = []
        layout = self._running.layout
        declared = [*layout.declarations.values(), *map(self._new_tag, tags)]
        self._layout = Layout(declared, files=layout.files, modules=layout.modules)
        self._edited_routines: dict[str, LoweredRoutine] = {}
        self._lowering = program.lowering(self._layout, self._running.main)
        by_routine: dict[str, dict[int, RungEdit]] = {}
        for edit in edits:
            by_routine.setdefault(edit.routine.upper(), {})[edit.rung] = edit
        for name, numbered in by_routine.items():
            self._edit_routine(name, numbered)
        self.missing = (
            list(self._missing()) if any(problem.site.tag for problem in self._lowering.problems) else []
        )
        self._check_whole()

    @property
    def is_right(self) -> bool:
        """Whether no mistake was found."""
        return not (self.mistakes or self.missing or any(rung.mistakes for rung in self.rungs))

    def _new_tag(self, new: NewTag) -> Tag:
        """Return the declaration of a new tag; raise a LadderError for an invalid name or type."""
        full_name = new.full_name
        if not re.fullmatch(TAG_NAME, new.name) or len(new.name) > 40:
            raise LadderError(f"{new.name!r} is not a tag name; use a letter, then letters, digits and _")
        if full_name.upper() in self._running.layout.declarations:
            raise LadderError(f"tag {full_name} already exists")
        kind = types_of(self._program).get(new.type.upper())
        if kind is None:
            raise LadderError(f"no type {new.type}; choose from {', '.join(NUMBERS)}, BOOL, TIMER, COUNTER")
        return Tag(full_name, kind)

    def _edit_routine(self, name: str, edits: dict[int, RungEdit]) -> None:
        """Read and resolve the edited rungs of a routine, and renumber the others."""
        routine = next(
            (candidate for candidate in self._program.routines if candidate.name.upper() == name), None
        )
        if routine is None or routine.chart is not None or routine.statements is not None:
            raise LadderError(f"no routine {name} of rungs")
        last = len(routine.rungs) - 1
        for number in edits:
            if not BEFORE_FIRST <= number <= last:
                raise LadderError(
                    f"routine {routine.name} has no rung {number}; must be {BEFORE_FIRST} to {last}"
                )
        program = program_of(routine.name)
        self._lowering.enter(program)
        self._lowering.begin(routine)
        lines: list[LoweredLine] = []
        unedited = self._unedited_lines.setdefault(name, {})
        edited = self._edited_lines.setdefault(name, [])
        running = self._running.routines[name]
        for number in range(BEFORE_FIRST, last + 1):
            if number in edits:
                new = list(self._lines(edits[number], len(lines)))
                lines += new
                edited += new
            elif number >= 0:
                line = running.lines[number]
                unedited[number] = line if line.number == len(lines) else replace(line, number=len(lines))
                lines.append(unedited[number])
        labels = self._labels(routine.name, lines)
        self._edited_routines[name] = replace(running, lines=tuple(lines), labels=labels)

    def _labels(self, name: str, lines: Iterable[LoweredLine]) -> dict[str, int]:
        """Return the rung numbers of a routine's labels; add a mistake for a duplicate label."""
        labels: dict[str, int] = {}
        for line in lines:
            first = next(iter(line.steps), None)
            if first is not None and first.name == "LBL" and first.operands:
                if first.operands[0] in labels:
                    self.mistakes.append(f"label {first.operands[0]} is in {name} twice; rename one")
                labels[first.operands[0]] = line.number
        return labels

    def _lines(self, edit: RungEdit, start: int) -> Iterator[LoweredLine]:
        """Yield the lines of an edit, numbered from `start`; add each rung with its mistakes."""
        for text in edit.texts:
            checked = CheckedRung(edit, text, number=start)
            self.rungs.append(checked)
            start += 1
            try:
                rung = parse_rung(text, rung=checked.number, specs=self._program.specs)
            except RungTextError as error:
                checked.mistakes.append(Mistake(error.reason, column=error.site.column))
                yield LoweredLine(checked.number, (), Origin(), text, "")
                continue
            checked.rung, checked.text = rung, str(rung)
            problem_count = len(self._lowering.problems)
            line = self._lowering.line(checked.number, rung)
            for problem in self._lowering.problems[problem_count:]:
                checked.mistakes.append(
                    Mistake(f"{problem.text}; {problem.remedy}", element_of(rung, problem))
                )
            yield line

    def _check_whole(self) -> None:
        """Check jumps, routines and coils across rungs; skip warnings that the running program has."""
        edited = replace(self._running, layout=self._layout, routines=self._affected_routines())
        for problem in check_whole(edited):
            self._add_mistake(problem, warns=False)
        for problem in warnings_of(edited, self._program.allowed):
            if (problem.text, problem.rung) not in self._index.warnings:
                self._add_mistake(problem, warns=True)

    def _affected_routines(self) -> dict[str, LoweredRoutine]:
        """Return all routines, with edited lines and other lines that an edit can invalidate."""
        lines = {name: list(rungs) for name, rungs in self._edited_lines.items()}
        places = {
            place
            for rungs in self._edited_lines.values()
            for line in rungs
            for place in _exclusive_places_in(line)
        }
        # running lines that use the same places, and jumps and calls of edited routines
        affected = {index for place in places for index in self._index.places.get(place, ())}
        for name in self._edited_lines:
            affected.update((name, number) for number in self._index.jumps.get(name, ()))
        for name, number in affected:
            unedited = self._unedited_lines.get(name)
            line = self._running.routines[name].lines[number] if unedited is None else unedited.get(number)
            if line is not None:  # None for a line that is edited
                lines.setdefault(name, []).append(line)
        return {
            name: replace(
                self._edited_routines.get(name, routine),
                lines=tuple(sorted(lines.get(name, ()), key=lambda line: line.number)),
            )
            for name, routine in self._running.routines.items()
        }

    def _add_mistake(self, problem: Problem, *, warns: bool) -> None:
        """Add a problem to its edited rung; in other rungs, add only mistakes."""
        text = f"{problem.text}; {problem.remedy}"
        for rung in self.rungs:
            rung_key = rung.edit.routine.upper(), rung.number
            if (problem.site.routine.upper(), problem.site.rung) == rung_key:
                mistake = Mistake(text, None if rung.rung is None else element_of(rung.rung, problem))
                (rung.warnings if warns else rung.mistakes).append(mistake)
                return
        if not warns:
            self.mistakes.append(f"{problem.where}: {text}")

    def _missing(self) -> Iterator[MissingTag]:
        """Yield the undeclared tags with their possible types, from their uses in the edited rungs."""
        declared = self._layout.declarations

        def scoped_key(program: str, name: str) -> str:
            scoped_name = scoped(program, name).upper()
            return scoped_name if scoped_name in declared else name.upper()

        def missing(program: str, address: Address) -> tuple[str, tuple[Step, ...]] | None:
            name = address.name
            is_known = scoped_key(program, name) in declared or name.upper() in STATUS_FLAGS or ":" in name
            return None if is_known or not re.fullmatch(TAG_NAME, name) else (name, address.steps)

        def known(program: str, address: Address) -> DataType | None:
            return type_at(declared.get(scoped_key(program, address.name)), address)

        program = self._program
        guesses = program.guesses(missing, known)
        owned: dict[str, str] = {}
        for rung in self.rungs:
            if rung.rung is not None:
                scope = program_of(rung.edit.routine)
                guesses.read_all([(scope, Routine("Edited", (rung.rung,)))])
                owned |= {name: scope for name in guesses.found if name not in owned}
        for name, guess in guesses.found.items():
            kind = guess.type(f"{guess.name}_type")
            if guess.dims or kind.name.upper() not in types_of(program):
                continue  # an array or a structure: declared in the text
            decided = guess.root.votes or guess.root.members or not isinstance(kind, Elementary)
            types = (kind.name, *(number_type for number_type in NUMBERS if number_type != kind.name))
            yield MissingTag(
                guess.name, owned[name], types if not decided and kind.name in NUMBERS else types[:1]
            )


def types_of(program: LadderLogic) -> dict[str, DataType]:
    """Return the possible types of a new tag, by name in capitals."""
    structures = {structure.name: structure for structure in program.structures()}
    blocks = {add_on.name: add_on.structure for add_on in program.add_ons.values()}
    return {name.upper(): kind for name, kind in {**PREDEFINED_TYPES, **structures, **blocks}.items()}


def element_of(rung: Rung, problem: Problem) -> int | None:
    """Return the number of the instruction with the problem; None for the whole rung."""
    for number, instruction in enumerate(instructions_of(rung.series)):
        if problem.site.instruction and str(instruction) == problem.site.instruction:
            return number
    return None
