"""Moves edits of rungs to a later version of their program, whose rungs others may have edited."""

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
    """Return edits of a program as edits of a later one.

    An edit follows its rung, or the rung that replaced it. If the rung was removed, new rungs follow the rung
    before it. Changes that the later program already has are left out.
    """
    old, new = _texts(before), _texts(after)
    by_place: dict[tuple[str, int], list[str]] = {}
    conflicts = 0
    for routine, number, replacement, _ in sorted(edits, key=lambda each: each.rung):
        old_rungs, rungs = old.get(routine.upper(), []), new.get(routine.upper(), [])
        place, is_there, is_same = _place(old_rungs, rungs, number)
        texts = list(replacement)
        if is_there:
            texts = _without_known(texts, old_rungs, rungs, number, place)
        keeps = number != BEFORE_FIRST and texts[:1] == [old_rungs[number]]
        if keeps:  # the rung stays, and new rungs follow it
            texts[:1] = rungs[place : place + 1] if is_there else []
        if is_there:
            conflicts += not is_same and texts != [rungs[place]] and not keeps
        else:
            conflicts += bool(texts)
            texts = [*by_place.get((routine, place), _rung_at(rungs, place)), *texts]
        by_place[routine, place] = texts
    moved_edits = tuple(
        RungEdit(routine, position, tuple(texts))
        for (routine, position), texts in by_place.items()
        if texts != _rung_at(new.get(routine.upper(), []), position)
    )
    return MovedEdits(moved_edits, conflicts)


def _rung_at(rungs: list[str], at: int) -> list[str]:
    return rungs[at : at + 1] if at >= 0 else []


def _without_known(texts: list[str], own: list[str], rungs: list[str], number: int, at: int) -> list[str]:
    """Return the texts of an edit without its new rungs if the later program has the same rungs."""
    end = _next(own, rungs, number)
    first = 0 if number == BEFORE_FIRST else 1
    return texts[:first] if end is not None and texts[first:] == rungs[at + 1 : end] else texts


def _texts(program: LadderLogic) -> dict[str, list[str]]:
    return {routine.name.upper(): [str(rung) for rung in routine.rungs] for routine in program.routines}


def _next(old: Sequence[str], new: Sequence[str], number: int) -> int | None:
    """Return the number of the next rung in a later routine; None if it was removed."""
    if number + 1 >= len(old):
        return len(new)
    place, is_there, _ = _place(old, new, number + 1)
    return place if is_there else None


def _place(old: Sequence[str], new: Sequence[str], number: int) -> tuple[int, bool, bool]:
    """Return a rung's number in a later routine, whether a rung is in its place, and whether it is the same.

    Without one, the number is that of the rung before it.
    """
    if number == BEFORE_FIRST:
        return BEFORE_FIRST, True, True
    for tag, first, end, start, stop in SequenceMatcher(None, old, new, autojunk=False).get_opcodes():
        if first <= number < end:
            place = start + number - first
            return (place, True, tag == "equal") if place < stop else (stop - 1, False, False)
    raise AssertionError(number)
