"""Outputs that exclude each other: two command bits of a 3601, or two directions of a drive."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import combinations

from scanrack.io_images.amci3601.rules import RULES

from ..facts import OutputWrite, Violation
from ..logic import INPUT, Bit, Condition, Term, alternatives, is_impossible
from ..subject import Subject

OPPOSITES = (
    ("forward", "reverse"),
    ("forward", "backward"),
    ("fwd", "rev"),
    ("up", "down"),
    ("open", "close"),
    ("left", "right"),
    ("extend", "retract"),
    ("raise", "lower"),
    ("advance", "return"),
    ("cw", "ccw"),
    ("clamp", "unclamp"),
    ("star", "delta"),
    ("plus", "minus"),
    ("lift", "sink"),
    ("lock", "unlock"),
)
"""Opposite words in the names of outputs that must not be on together."""


def opposite_outputs(subject: Subject) -> Iterator[Violation]:
    """Find outputs with opposite names that inputs can switch on together."""
    own = [output for output in subject.facts.outputs if not output.commands]
    for first, other in combinations(own, 2):
        if _are_opposite(first.name, other.name) and _meet(first, other):
            text = (
                f"{other.name} is switched on here while {first.name} of line {first.place.line} may be on: "
                "their inputs do not exclude each other"
            )
            yield Violation(other.place, text)


def both_commands(subject: Subject) -> Iterator[Violation]:
    """Find command bits of a 3601 that inputs can set together."""
    row = RULES["CMD-02"]
    for first, other in combinations([output for output in subject.facts.outputs if output.commands], 2):
        if first.commands == other.commands and first.name != other.name and _meet(first, other):
            text = (
                f"{other.name} is set here while {first.name} of line {first.place.line} may be set: "
                f"{row.text.rstrip('.')} [{row.section}]: let each exclude the other"
            )
            yield Violation(other.place, text)


def _are_opposite(one: str, other: str) -> bool:
    """Whether two names differ only in opposite words.

    >>> _are_opposite("DoorOpen", "DoorClose"), _are_opposite("open_valve_1", "close_valve_2")
    (True, False)
    """
    words, others = _words(one), _words(other)
    if len(words) != len(others):
        return False
    differing = [pair for pair in zip(words, others, strict=True) if pair[0] != pair[1]]
    return len(differing) == 1 and any(set(differing[0]) == set(pair) for pair in OPPOSITES)


def _words(name: str) -> list[str]:
    """Return the words of a name: `DoorOpen_1` has door, open and 1."""
    words = re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+", name.rpartition(".")[2])
    return [word.lower() for word in words]


def _meet(one: OutputWrite, other: OutputWrite) -> bool:
    """Whether inputs alone can make both conditions true."""
    ways, others = alternatives(one.free), alternatives(other.free)
    both: Term = (Bit(one.key), Bit(other.key))
    return any(
        not is_impossible((*way, *other_way, *both))
        and _is_free(set(way) - set(other_way))
        and _is_free(set(other_way) - set(way))
        for way in ways or ()
        for other_way in others or ()
    )


def _is_free(parts: set[Condition]) -> bool:
    """Whether parts of a condition are only inputs, one or more of them on, and bits that start off."""
    on = [part.name.startswith(INPUT) for part in parts if isinstance(part, Bit) and part.on]
    return bool(on) and all(on) and all(isinstance(part, Bit) for part in parts)
