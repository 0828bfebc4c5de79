"""Edits of rungs moved to a later version of their program, in which others may have edited rungs, too."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from difflib import SequenceMatcher
from typing import NamedTuple

from .edited import BEFORE_FIRST, RungEdit
from .runnable import LadderLogic


class MovedEdits(NamedTuple):
    """Edits of a later program."""

    edits: tuple[RungEdit, ...]
    conflicts: int  # edits of rungs that are others there, or are gone


def moved(before: LadderLogic, after: LadderLogic, edits: Iterable[RungEdit]) -> MovedEdits:
    """Return edits of a program as edits of a later one.

    An edit follows its rung. One of a rung that is another one there stands at that one; new rungs whose rung
    is gone stand behind the one before it. What the later program has already is left out.
    """
    old, new = _texts(before), _texts(after)
    found: dict[tuple[str, int], list[str]] = {}
    conflicts = 0
    for routine, number, given, _ in sorted(edits, key=lambda each: each.rung):
        rungs, texts = new.get(routine.upper(), []), list(given)
        at, is_there, is_same = _place(old.get(routine.upper(), []), rungs, number)
        if is_there and (end := _next(old.get(routine.upper(), []), rungs, number)) is not None:
            first = 0 if number == BEFORE_FIRST else 1
            if texts[first:] == rungs[at + 1 : end]:  # the same new rungs are there already
                texts = texts[:first]
        keeps = number != BEFORE_FIRST and texts[:1] == [old[routine.upper()][number]]
        if keeps:  # its rung stays, and rungs are new behind it
            texts[:1] = [rungs[at]] if is_there else []
        if is_there:
            conflicts += not is_same and texts != [rungs[at]] and not keeps
        else:
            conflicts += bool(texts)
            texts = [*found.get((routine, at), rungs[at : at + 1] if at >= 0 else []), *texts]
        found[routine, at] = texts
    moved_edits = tuple(
        RungEdit(routine, at, tuple(texts))
        for (routine, at), texts in found.items()
        if texts != (new.get(routine.upper(), [])[at : at + 1] if at >= 0 else [])
    )
    return MovedEdits(moved_edits, conflicts)


def _texts(program: LadderLogic) -> dict[str, list[str]]:
    return {each.name.upper(): [str(rung) for rung in each.rungs] for each in program.routines}


def _next(old: Sequence[str], new: Sequence[str], number: int) -> int | None:
    """Return where the rung behind one is in a later routine; None if it is not there."""
    if number + 1 >= len(old):
        return len(new)
    at, is_there, _ = _place(old, new, number + 1)
    return at if is_there else None


def _place(old: Sequence[str], new: Sequence[str], number: int) -> tuple[int, bool, bool]:
    """Return where a rung is in a later routine, whether one is in its place, and whether it is the same.

    Without one it is the place of the rung before it.
    """
    if number == BEFORE_FIRST:
        return BEFORE_FIRST, True, True
    for tag, first, end, start, stop in SequenceMatcher(None, old, new, autojunk=False).get_opcodes():
        if first <= number < end:
            at = start + number - first
            return (at, True, tag == "equal") if at < stop else (stop - 1, False, False)
    raise AssertionError(number)
