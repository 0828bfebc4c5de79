"""Finds the values that an edit of a ladder program can change. Requires the solver and a small program."""

from __future__ import annotations

from scanrack.ladder import LadderLogic
from scanrack.ladder.model.errors import LadderError

MOST_INSTRUCTIONS = 1_500
"""Maximum number of instructions in a program to compare. The comparison takes a second or two."""

Group = tuple[str, tuple[str, ...]]
"""A kind of effect, and the names of the affected values."""


def effects_of(old: LadderLogic, new: LadderLogic) -> tuple[Group, ...]:
    """Return the values that can differ after an edit, outputs first, with the same inputs from power-up.

    All other values are equal in every run. The result is empty if no proof covers the programs.
    """
    from scanrack.ladder.prove.solving.solver import is_installed

    if not is_installed() or any(len(program.build().sites) > MOST_INSTRUCTIONS for program in (old, new)):
        return ()
    from scanrack.ladder.prove.difference import compare

    try:
        difference = compare(old, new)
    except LadderError:
        return ()
    layout = new.build().layout
    outputs: list[str] = []
    others: list[str] = []
    for change in difference.changed:
        path, index = change.key
        leaf = layout.leaf(path)
        names = outputs if leaf.output else others
        names.append(f"{leaf.path}[{index}]" if leaf.size > 1 else leaf.path)
    return (
        ("outputs that can differ, from power-up on", tuple(outputs) or ("none",)),
        ("other values that can differ, from power-up on", tuple(others) or ("none",)),
    )
