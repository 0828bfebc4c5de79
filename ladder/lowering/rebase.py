"""Move rung edits to a later version of their program, which other users have possibly edited."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from difflib import SequenceMatcher
from typing import NamedTuple

from .edited import BEFORE_FIRST, RungEdit
from .runnable import LadderLogic


class MovedEdits(NamedTuple):
    """Edits, moved to a later program."""

    edits: tuple[RungEdit, ...]
    conflicts: int  # edits of rungs that were changed or removed there


def moved(before: LadderLogic, after: LadderLogic, edits: Iterable[RungEdit]) -> MovedEdits:
    """Convert edits of a program to edits of a later version.

    An edit applies to its rung, or to the rung that replaced it. If the rung was removed, new rungs go after
    the rung before it. Changes that the later program already has are omitted.
    """
    old, new = _texts(before), _texts(after)
    texts_by_rung: dict[tuple[str, int], list[str]] = {}
    conflicts = 0
    for routine, number, replacement, _ in sorted(edits, key=lambda edit: edit.rung):
        old_rungs, rungs = old.get(routine.upper(), []), new.get(routine.upper(), [])
        later = _counterpart(old_rungs, rungs, number)
        texts = list(replacement)
        if later.exists:
            texts = _without_known(texts, old_rungs, rungs, number, later.number)
        keeps = number != BEFORE_FIRST and texts[:1] == [old_rungs[number]]
        if keeps:  # the rung stays, and new rungs follow it
            texts[:1] = _rung_at(rungs, later.number) if later.exists else []
        if later.exists:
            conflicts += not later.is_same and texts != [rungs[later.number]] and not keeps
        else:
            conflicts += bool(texts)
            texts = [*texts_by_rung.get((routine, later.number), _rung_at(rungs, later.number)), *texts]
        texts_by_rung[routine, later.number] = texts
    moved_edits = tuple(
        RungEdit(routine, number, tuple(texts))
        for (routine, number), texts in texts_by_rung.items()
        if texts != _rung_at(new.get(routine.upper(), []), number)
    )
    return MovedEdits(moved_edits, conflicts)


def _rung_at(rungs: list[str], number: int) -> list[str]:
    return rungs[number : number + 1] if number >= 0 else []


def _without_known(
    texts: list[str], old: list[str], rungs: list[str], number: int, later_number: int
) -> list[str]:
    """Return the texts of an edit, except new rungs that the later program already has."""
    end = _next(old, rungs, number)
    first = 0 if number == BEFORE_FIRST else 1
    return texts[:first] if end is not None and texts[first:] == rungs[later_number + 1 : end] else texts


def _texts(program: LadderLogic) -> dict[str, list[str]]:
    return {routine.name.upper(): [str(rung) for rung in routine.rungs] for routine in program.routines}


def _next(old: Sequence[str], new: Sequence[str], number: int) -> int | None:
    """Return the number of the next rung in a later routine; None if it was removed."""
    if number + 1 >= len(old):
        return len(new)
    later = _counterpart(old, new, number + 1)
    return later.number if later.exists else None


class _LaterRung(NamedTuple):
    """The counterpart of a rung in a later routine."""

    number: int  # its number; without a counterpart, the number of the rung before it
    exists: bool
    is_same: bool  # whether its text is unchanged


def _counterpart(old: Sequence[str], new: Sequence[str], number: int) -> _LaterRung:
    """Return the counterpart of a rung, which is the same rung or the rung that replaced it."""
    if number == BEFORE_FIRST:
        return _LaterRung(BEFORE_FIRST, True, True)
    for tag, first, end, start, stop in SequenceMatcher(None, old, new, autojunk=False).get_opcodes():
        if first <= number < end:
            later = start + number - first
            return (
                _LaterRung(later, True, tag == "equal")
                if later < stop
                else _LaterRung(stop - 1, False, False)
            )
    raise AssertionError(number)
