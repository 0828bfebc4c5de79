"""Finds the tags that an operator's panel writes, and values to try near the program's constants.

These are the tags that clients may write (`[server]`), tags that the rack file declares as written outside or
free (`[prove]`), and tags with a typical panel name: `HMI`, `RECIPE`, `SETPOINT` and so on.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from fnmatch import fnmatchcase

from scanrack.ladder.debug.crossref import mentions_of
from scanrack.ladder.model.operands import Constant, Place, first_leaf
from scanrack.ladder.model.tags import Leaf
from scanrack.ladder.state.lowered import LoweredProgram, LoweredStep, steps_of
from scanrack.runtime.config.rackspec import RackSpec

from ...check.rungs.number_ranges import BY_PEOPLE

MOST_SETTINGS, MOST_VALUES = 200, 24
"""Largest number of written tags, and of values for one tag."""

NEAR = (0, -1, 1)
"""Distances of the values from a number that the program compares."""


@dataclass(frozen=True, slots=True)
class PanelTag:
    """A tag that is written from outside, and values to try."""

    tag: str
    values: tuple[bool | int | float, ...]


def settings_of(lowered: LoweredProgram, spec: RackSpec) -> tuple[PanelTag, ...]:
    """Return the panel tags of a program, in the order of its tags."""
    patterns = [
        writable.upper()
        for writable in (*spec.server.writable, *spec.prove.written_outside, *spec.prove.free)
    ]
    leaves = [leaf for leaf in lowered.layout.leaves.values() if _is_set(leaf, patterns)][:MOST_SETTINGS]
    if not leaves:
        return ()
    compared = _compared(lowered)
    return tuple(PanelTag(leaf.path, tuple(_values(leaf, compared[leaf.ident]))) for leaf in leaves)


def _is_set(leaf: Leaf, patterns: list[str]) -> bool:
    path = leaf.path.upper()
    if leaf.slot is not None or leaf.dims or leaf.frame or path.startswith(("S:", "~")):
        return False
    named = path.replace("\\", "PROGRAM:", 1) if path.startswith("\\") else path
    below = (fnmatchcase(named, pattern) or fnmatchcase(named, f"{pattern}.*") for pattern in patterns)
    return bool(BY_PEOPLE.search(path)) or any(below)


def _compared(lowered: LoweredProgram) -> defaultdict[str, list[int | float]]:
    """Return the constants that share an instruction with each tag, by the tag's identifier."""
    numbers_by_tag: defaultdict[str, list[int | float]] = defaultdict(list)
    for routine in lowered.routines.values():
        for line in routine.lines:
            for step in steps_of(line.nodes):
                numbers = list(_constants(step))
                for mention in mentions_of(lowered.sites[step.site], step) if numbers else ():
                    if mention.reads and isinstance(mention.where, Place):
                        numbers_by_tag[first_leaf(mention.where).ident] += numbers
    return numbers_by_tag


def _constants(step: LoweredStep) -> Iterator[int | float]:
    return (operand.value for operand in step.operands if isinstance(operand, Constant))


def _values(leaf: Leaf, constants: list[int | float]) -> Iterator[bool | int | float]:
    if leaf.type.is_bool:
        yield from (True, False)
        return
    candidates = [number + distance for number in (0, *constants) for distance in NEAR]
    if leaf.type.is_real:
        yield from dict.fromkeys(map(float, candidates[:MOST_VALUES]))
        return
    least = -(1 << leaf.type.bits - 1) if leaf.type.is_signed else 0
    most = least + (1 << leaf.type.bits) - 1
    fitting = [int(number) for number in candidates if least <= number <= most]
    yield from dict.fromkeys(fitting[:MOST_VALUES])
