"""What a compiled program does for its observer: it notes power and holds forces.

Each is a variant of the compiled text, made on demand; the plain program has no cost.

Noted: a rung keeps the power after its instructions in variables and, at its end, puts them into a list; see
`noted`, and `statements` for structured text.

Held: after every line that assigns to a forced variable there is one that forces it again. The value is
computed all the same, since that may record a fault. Lists are held by the memory, see
`debug.forces.HeldList`.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from typing_extensions import override

from ..state.lowered import LoweredProgram

NOTED = "__noted"
"""Variable of the list with the power that was noted."""

NOTES = "__notes"
"""What a routine calls that list."""

LineKey = tuple[str, int]
"""A routine, in capitals, and the number of a rung or of a line in it."""


@dataclass(frozen=True, slots=True)
class Observation:
    """What a compiled program notes and holds.

    Attributes:
        held: variables that are forced, each with whether that means some of its bits only.
        noted: the lines whose power is noted, in the order in which the list has them.
    """

    held: frozenset[tuple[str, bool]] = frozenset()
    noted: tuple[LineKey, ...] = ()


UNOBSERVED = Observation()


Reading = tuple[tuple[int, int, tuple[tuple[int, int], ...]], ...]
"""For each instruction of a rung: there is power after it if the value at the place in the list is greater
than the number, and so on for further places and numbers."""


class NoteList:
    """The list with the power that is noted: a place for each line in their order, then further ones.

    Attributes:
        size: how many places.
        readings: for each line how its places are read.

    Args:
        lines: how many lines are noted.
    """

    def __init__(self, lines: int) -> None:
        self.size = lines
        self.readings: list[Reading] = [()] * lines
        self._places: dict[tuple[int, int], int] = {}

    def further(self, line: int, number: int) -> int:
        """Return a further place of a line, from 1; the same one whenever the line is written."""
        found = self._places.setdefault((line, number), self.size)
        self.size += found == self.size
        return found


@dataclass(frozen=True, slots=True)
class Notes:
    """The lines of one routine whose power is noted.

    Attributes:
        places: where in the list, by number of the line.
        listed: the list.
    """

    places: Mapping[int, int]
    listed: NoteList

    @staticmethod
    def of(observation: Observation, listed: NoteList, routine: str) -> Notes:
        """Return those of a routine, named in capitals."""
        noted = enumerate(observation.noted)
        return Notes({number: place for place, (name, number) in noted if name == routine}, listed)

    def place(self, number: int) -> str | None:
        """Return text for the place of a line in the list, None if the line is not noted."""
        place = self.places.get(number)
        return None if place is None else f"{NOTES}[{place}]"

    def further(self, number: int, which: int) -> int:
        """Return a further place of a line that is noted, from 1."""
        return self.listed.further(self.places[number], which)

    def read(self, number: int, reading: Reading) -> None:
        """Take note of how the places of a line are read."""
        self.listed.readings[self.places[number]] = reading


def truth_of(notes: Sequence[Any], line: int, reading: Reading) -> tuple[bool, ...] | None:
    """Return the truth of a line from what was noted; None if it did not run.

    >>> truth_of([2, True], 0, ((0, 0, ()), (0, 1, ()), (0, 2, ()), (0, 1, ((1, 0),))))
    (True, True, False, True)
    """
    first = notes[line]
    if first is None or isinstance(first, tuple):
        return first
    return tuple(
        [
            notes[place] > above and (not further or all(notes[at] > least for at, least in further))
            for place, above, further in reading
        ]
    )


def true_at_end(notes: Sequence[Any], line: int, reading: Reading) -> bool:
    """Return whether a line ran and there was power after its last instruction."""
    first = notes[line]
    if isinstance(first, tuple):
        return bool(first) and bool(first[-1])
    if first is None or not reading:
        return False
    place, above, further = reading[-1]
    return bool(notes[place] > above) and all(notes[at] > least for at, least in further)


def lines_of(lowered: LoweredProgram) -> tuple[LineKey, ...]:
    """Return all lines whose power can be noted."""
    found = {
        (routine.name.upper(), line.number): None
        for routine in lowered.routines.values()
        for line in routine.lines
    }
    return tuple(found)


def held_name(ident: str) -> str:
    """Return the name of the value that a variable is forced to."""
    return f"__held_{ident}"


def kept_name(ident: str) -> str:
    """Return the name of the mask of the bits that are not forced."""
    return f"__left_{ident}"


class ForceInserter(ast.NodeTransformer):
    """Puts a line that forces a variable after every line that assigns to it.

    Args:
        held: see `Observation`.
    """

    def __init__(self, held: frozenset[tuple[str, bool]]) -> None:
        self._again = {ident: _force(ident, in_part=in_part) for ident, in_part in held}

    @override
    def visit_Assign(self, node: ast.Assign) -> ast.AST | list[ast.stmt]:
        """Return the line and the one after it."""
        forced = [
            self._again[target.id]
            for target in node.targets
            if isinstance(target, ast.Name) and target.id in self._again
        ]
        return [node, *(_placed(ast.parse(text).body[0], node) for text in forced)]


def _force(ident: str, *, in_part: bool) -> str:
    if in_part:
        return f"{ident} = {ident} & {kept_name(ident)} | {held_name(ident)}"
    return f"{ident} = {held_name(ident)}"


def _placed(line: ast.stmt, where: ast.stmt) -> ast.stmt:
    """Return a line with the source position of another one, for error messages."""
    for node in ast.walk(line):
        if isinstance(node, (ast.expr, ast.stmt)):
            ast.copy_location(node, where)
    return line
