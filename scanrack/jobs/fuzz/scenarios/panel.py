"""Finds the tags that an operator's panel writes, and values to try, near the program's constants.

They are the tags that clients can write (`[server]`), tags that the rack file declares as written outside or
free (`[prove]`), and tags with a typical panel name: `HMI`, `RECIPE`, `SETPOINT` and so on.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from fnmatch import fnmatchcase
from itertools import chain

from scanrack.ladder.debug.crossref import mentions_of
from scanrack.ladder.model.operands import Constant, Place, first_leaf
from scanrack.ladder.model.tags import Leaf
from scanrack.ladder.state.lowered import LoweredProgram, LoweredStep, steps_of
from scanrack.runtime.config.rackspec import RackSpec

from ...check.rungs.number_ranges import BY_PEOPLE

MOST_SETTINGS, MOST_VALUES = 200, 24
"""Maximum number of panel tags, and of values for one tag."""

NEAR = (0, -1, 1)
"""Offsets of the values from a constant of the program."""


@dataclass(frozen=True, slots=True)
class PanelTag:
    """A tag that an operator's panel writes, and values to try."""

    tag: str
    values: tuple[bool | int | float, ...]


def settings_of(lowered: LoweredProgram, spec: RackSpec) -> tuple[PanelTag, ...]:
    """Return the panel tags of a program, in the order of its tags."""
    patterns = [
        writable.upper()
        for writable in (*spec.server.writable, *spec.prove.written_outside, *spec.prove.free)
    ]
    leaves = [leaf for leaf in lowered.layout.leaves.values() if _is_panel_tag(leaf, patterns)]
    leaves = leaves[:MOST_SETTINGS]
    if not leaves:
        return ()
    constants = _constants_by_tag(lowered)
    return tuple(PanelTag(leaf.path, tuple(_values(leaf, constants[leaf.ident]))) for leaf in leaves)


def _is_panel_tag(leaf: Leaf, patterns: list[str]) -> bool:
    """Return whether a tag's name or a pattern shows that an operator's panel writes it."""
    path = leaf.path.upper()
    if leaf.slot is not None or leaf.dims or leaf.frame or path.startswith(("S:", "~")):
        return False
    full_name = path.replace("\\", "PROGRAM:", 1) if path.startswith("\\") else path
    return bool(BY_PEOPLE.search(path)) or any(
        fnmatchcase(full_name, pattern) or fnmatchcase(full_name, f"{pattern}.*") for pattern in patterns
    )


def _constants_by_tag(lowered: LoweredProgram) -> defaultdict[str, list[int | float]]:
    """Return the constants in the instructions that read each tag, by the tag's identifier."""
    constants_by_tag: defaultdict[str, list[int | float]] = defaultdict(list)
    lines = (line for routine in lowered.routines.values() for line in routine.lines)
    for step in chain.from_iterable(steps_of(line.nodes) for line in lines):
        constants = [operand.value for operand in step.operands if isinstance(operand, Constant)]
        for tag in _tags_read(lowered, step) if constants else ():
            constants_by_tag[tag] += constants
    return constants_by_tag


def _tags_read(lowered: LoweredProgram, step: LoweredStep) -> Iterator[str]:
    """Yield the identifiers of the tags that an instruction reads."""
    for mention in mentions_of(lowered.sites[step.site], step):
        if mention.reads and isinstance(mention.where, Place):
            yield first_leaf(mention.where).ident


def _values(leaf: Leaf, constants: list[int | float]) -> Iterator[bool | int | float]:
    """Yield values to try for a tag, without duplicates."""
    if leaf.type.is_bool:
        yield from (True, False)
        return
    candidates = [constant + difference for constant in (0, *constants) for difference in NEAR]
    if leaf.type.is_real:
        yield from dict.fromkeys(map(float, candidates[:MOST_VALUES]))
        return
    minimum = -(1 << leaf.type.bits - 1) if leaf.type.is_signed else 0
    maximum = minimum + (1 << leaf.type.bits) - 1
    fitting = [int(candidate) for candidate in candidates if minimum <= candidate <= maximum]
    yield from dict.fromkeys(fitting[:MOST_VALUES])
