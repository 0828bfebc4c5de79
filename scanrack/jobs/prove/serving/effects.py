"""Finds what an edit of a ladder program can change, if the solver is installed and the program is small."""

from __future__ import annotations

from scanrack.ladder import LadderLogic
from scanrack.ladder.model.errors import LadderError

MOST_INSTRUCTIONS = 1_500
"""Largest number of instructions in a program that is compared: that takes a second or two."""

Group = tuple[str, tuple[str, ...]]
"""A kind of effect, and the names of the affected values."""


def effects_of(old: LadderLogic, new: LadderLogic) -> tuple[Group, ...]:
    """Return the values that can differ after an edit, outputs first, with the same inputs from power-up.

    All other values are equal in every run. Returns nothing if no proof covers the programs.
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
    names: dict[bool, list[str]] = {True: [], False: []}
    for change in difference.changed:
        leaf, index = layout.leaf(change.key[0]), change.key[1]
        names[leaf.output].append(f"{leaf.path}[{index}]" if leaf.size > 1 else leaf.path)
    return (
        ("outputs that can differ, from power-up on", tuple(names[True]) or ("none",)),
        ("other values that can differ, from power-up on", tuple(names[False]) or ("none",)),
    )
