"""Variants of a compiled program that record power or apply forces.

They are compiled on demand, so they do not slow the plain program down.

Noting: a rung collects the power after its instructions in variables and stores them in a list at its end,
see `power_notes`, and `statements` for structured text.

Forcing: a line after every assignment to a forced variable forces it again. The value is still computed,
because the computation may record a fault. Lists are forced in memory, see `debug.forces.ForcedList`.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence
from typing import Any

from scanrack.io_images.dataclass import dataclass
from typing_extensions import override

from ..state.lowered import LoweredProgram

NOTED = "__noted"
"""Variable of the list of noted power."""

NOTES = "__notes"
"""Name of the list of noted power inside routines."""

LineKey = tuple[str, int]
"""A routine name in uppercase, and the number of a rung or line in it."""


@dataclass(frozen=True, slots=True)
class Observation:
    """The lines to note and the variables to force."""

    forced_variables: frozenset[tuple[str, bool]] = frozenset()  # True: only some bits of the variable
    noted: tuple[LineKey, ...] = ()  # noted lines in list order
    forced: bool = False  # whether anything is forced, including values in lists and bytes


UNOBSERVED = Observation()


Reading = tuple[tuple[int, int, tuple[tuple[int, int], ...]], ...]
"""Places with thresholds for each instruction; there is power after it if all thresholds are exceeded."""


class NoteList:
    """The list of noted power: one place per line, followed by additional places."""

    def __init__(self, lines: int) -> None:
        self.size = lines
        self.readings: list[Reading] = [()] * lines  # how to read the places of each line
        self._places: dict[tuple[int, int], int] = {}

    def extra_place(self, line: int, number: int) -> int:
        """Return an additional place for a line, from 1; every compilation gets the same place."""
        place = self._places.setdefault((line, number), self.size)
        self.size += place == self.size
        return place


@dataclass(frozen=True, slots=True)
class Notes:
    """The noted lines of one routine."""

    places: Mapping[int, int]  # place in the list by line number
    note_list: NoteList
    forced: bool = False  # see `Observation.forced`

    @staticmethod
    def of_routine(observation: Observation, note_list: NoteList, routine: str) -> Notes:
        """Return the notes for a routine; its name is in uppercase."""
        noted = enumerate(observation.noted)
        places = {number: place for place, (name, number) in noted if name == routine}
        return Notes(places, note_list, observation.forced)

    def place(self, number: int) -> str | None:
        """Return text for the place of a line; None if the line is not noted."""
        place = self.places.get(number)
        return None if place is None else f"{NOTES}[{place}]"

    def extra_place(self, number: int, extra_number: int) -> int:
        """Return an additional place of a noted line, from 1."""
        return self.note_list.extra_place(self.places[number], extra_number)

    def read(self, number: int, reading: Reading) -> None:
        """Set how to read the places of a line."""
        self.note_list.readings[self.places[number]] = reading


def truth_of(notes: Sequence[Any], line: int, reading: Reading) -> tuple[bool, ...] | None:
    """Return the noted power after each instruction of a line; None if the line did not run.

    >>> truth_of([2, True], 0, ((0, 0, ()), (0, 1, ()), (0, 2, ()), (0, 1, ((1, 0),))))
    (True, True, False, True)
    """
    first = notes[line]
    if first is None or isinstance(first, tuple):
        return first
    return tuple(
        [
            notes[place] > above and (not more or all(notes[other] > least for other, least in more))
            for place, above, more in reading
        ]
    )


def true_at_end(notes: Sequence[Any], line: int, reading: Reading) -> bool:
    """Return whether a line ran with power after its last instruction."""
    first = notes[line]
    if isinstance(first, tuple):
        return bool(first) and bool(first[-1])
    if first is None or not reading:
        return False
    place, above, more = reading[-1]
    return bool(notes[place] > above) and all(notes[other] > least for other, least in more)


def lines_of(lowered: LoweredProgram) -> tuple[LineKey, ...]:
    """Return all lines whose power can be noted."""
    routines = lowered.routines.values()
    lines = [(routine.name.upper(), line.number) for routine in routines for line in routine.lines]
    return tuple(dict.fromkeys(lines))


def force_variable(ident: str) -> str:
    """Return the variable of a forced value."""
    return f"__held_{ident}"


def free_mask_variable(ident: str) -> str:
    """Return the variable of the mask of unforced bits."""
    return f"__left_{ident}"


class ForceInserter(ast.NodeTransformer):
    """Adds a line that forces a variable after every assignment to it, see `Observation`."""

    def __init__(self, variables: frozenset[tuple[str, bool]]) -> None:
        self._force_lines = {ident: _force(ident, in_part=in_part) for ident, in_part in variables}

    @override
    def visit_Assign(self, node: ast.Assign) -> ast.AST | list[ast.stmt]:
        """Return the assignment, followed by a line that forces the variable if it is forced."""
        forced = [
            self._force_lines[target.id]
            for target in node.targets
            if isinstance(target, ast.Name) and target.id in self._force_lines
        ]
        return [node, *(_at_position_of(ast.parse(text).body[0], node) for text in forced)]


def _force(ident: str, *, in_part: bool) -> str:
    """Return the line that forces a variable, or `in_part` only some of its bits."""
    if in_part:
        return f"{ident} = {ident} & {free_mask_variable(ident)} | {force_variable(ident)}"
    return f"{ident} = {force_variable(ident)}"


def _at_position_of(line: ast.stmt, statement: ast.stmt) -> ast.stmt:
    """Return a line with a statement's source position, for error messages."""
    for node in ast.walk(line):
        if isinstance(node, (ast.expr, ast.stmt)):
            ast.copy_location(node, statement)
    return line
