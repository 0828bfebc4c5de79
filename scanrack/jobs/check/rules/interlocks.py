"""Outputs that exclude each other: two command bits of a 3601, or two directions of a drive."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import combinations, product

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
    outputs = [output for output in subject.facts.outputs if not output.commands]
    for first, second in combinations(outputs, 2):
        if _are_opposite(first.name, second.name) and _can_be_on_together(first, second):
            text = (
                f"{second.name} is switched on here while {first.name} of line {first.place.line} may be on: "
                "their inputs do not exclude each other"
            )
            yield Violation(second.place, text)


def both_commands(subject: Subject) -> Iterator[Violation]:
    """Find command bits of a 3601 that inputs can set together."""
    row = RULES["CMD-02"]
    command_bits = [output for output in subject.facts.outputs if output.commands]
    for first, second in combinations(command_bits, 2):
        is_pair = first.commands == second.commands and first.name != second.name
        if is_pair and _can_be_on_together(first, second):
            text = (
                f"{second.name} is set here while {first.name} of line {first.place.line} may be set: "
                f"{row.text.rstrip('.')} [{row.section}]: interlock them"
            )
            yield Violation(second.place, text)


def _are_opposite(first: str, second: str) -> bool:
    """Whether two names differ only in opposite words.

    >>> _are_opposite("DoorOpen", "DoorClose"), _are_opposite("open_valve_1", "close_valve_2")
    (True, False)
    """
    first_words, second_words = _words(first), _words(second)
    if len(first_words) != len(second_words):
        return False
    differing = [{a, b} for a, b in zip(first_words, second_words, strict=True) if a != b]
    return len(differing) == 1 and any(differing[0] == set(pair) for pair in OPPOSITES)


def _words(name: str) -> list[str]:
    """Return the words of a name: `DoorOpen_1` has door, open and 1."""
    words = re.findall(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+", name.rpartition(".")[2])
    return [word.lower() for word in words]


def _can_be_on_together(first: OutputWrite, second: OutputWrite) -> bool:
    """Whether inputs alone can make the conditions of both outputs true."""
    both_on: Term = (Bit(first.key), Bit(second.key))
    for term, other_term in product(alternatives(first.free) or (), alternatives(second.free) or ()):
        if not is_impossible((*term, *other_term, *both_on)):
            only_first, only_second = set(term) - set(other_term), set(other_term) - set(term)
            if _inputs_decide(only_first) and _inputs_decide(only_second):
                return True
    return False


def _inputs_decide(parts: set[Condition]) -> bool:
    """Whether inputs alone can make all parts true.

    All parts must be bits. At least one bit must be on, and all bits that are on must be inputs. The other
    bits are off at start-up.
    """
    bits = [part for part in parts if isinstance(part, Bit)]
    bits_on = [bit for bit in bits if bit.on]
    are_inputs = all(bit.name.startswith(INPUT) for bit in bits_on)
    return bool(bits_on) and are_inputs and len(bits) == len(parts)
