"""Finds the values that may change outside a program's scan: inputs (by their names), bits, and numbers."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from fnmatch import fnmatchcase
from functools import partial
from typing import Any

from ...instructions.slc.processor import before_scan
from ...instructions.slc.status import STATUS
from ...model.errors import LadderError
from ...model.operands import Calculation, Constant, Place
from ...model.tags import Layout, tag_in
from ...run.view import Tags
from ...state.lowered import Call, LoweredProgram
from ..algebra.terms import T
from ..relation.places import Key

INPUTS = re.compile(r"I:\d|[^.\[]*:(?:S?I|S)\d{0,2}(?![\w:])")
"""Path prefix, in capitals, of a module's inputs that are ordinary tags in the program."""


def is_length(layout: Layout, path: str) -> bool:
    """Return whether a path, in capitals, is the LEN of a CONTROL; unlike a string, it also has a POS."""
    return path.endswith(".LEN") and layout.find(f"{path[:-4]}.POS") is not None


def named_bits(lowered: LoweredProgram) -> dict[Key, int]:
    """Return masks of the number bits that operands name, except in arguments of add-on instructions."""
    masks: dict[Key, int] = defaultdict(int)
    for place in _places_in(operand for step in lowered.all_steps for operand in step.operands):
        if place.bit is None or place.leaf.root:
            continue
        mask = (
            1 << int(place.bit.value) if isinstance(place.bit, Constant) else (1 << place.leaf.type.bits) - 1
        )
        index = place.fixed_index
        for element in range(place.leaf.size) if index is None else (index,):
            masks[place.path.upper(), element] |= mask
    return masks


def _places_in(operands: Iterable[Any]) -> Iterator[Place]:
    """Yield the places in operands, including those in expressions, subscripts and calls."""
    todo = list(operands)
    while todo:
        operand = todo.pop()
        if isinstance(operand, Place):
            yield operand
            todo += [*operand.indices, operand.bit]
        elif isinstance(operand, Calculation):
            todo += operand.operands
        elif isinstance(operand, Call):
            todo += operand.inputs


def written_bits(next_term: T, v: T) -> int:
    """Return a mask of the bits that a scan may change, from the number's term after the scan."""
    mask, open_terms, visited = 0, [next_term], set()
    while open_terms:
        term = open_terms.pop()
        if term is v or term.id in visited:
            continue
        visited.add(term.id)
        if term.op == "setbit":
            mask |= 1 << term.val[0]
            open_terms.append(term.args[0])
        elif term.op == "ite":
            open_terms += term.args[1:]
        else:
            return -1
    return mask


def refuse(lowered: LoweredProgram) -> None:
    """Raise a LadderError if a program has parts that proofs don't cover."""
    schedule = lowered.schedule
    features = [f"routine {name} in Python" for name in sorted(lowered.functions)]
    if schedule is not None:
        features += [
            f"task {scheduled.task.name}, which preempts"
            for scheduled in schedule.tasks
            if scheduled.task.preempt
        ]
        features += [
            f"fault routine {program.fault}" for program in schedule.programs if program.fault is not None
        ]
    features += [f"the sequential function chart {name}" for name in sorted(lowered.charts)]
    if lowered.axes or lowered.ideal is not None:
        features.append("motion axes")
    if features:
        raise LadderError(f"{lowered.name} has {', '.join(features)}, which proofs don't support")


def written_beside(lowered: LoweredProgram) -> tuple[str, ...]:
    """Return path prefixes with writers other than rungs: SLC status, messages, consumed tags."""
    names = [STATUS] if before_scan in lowered.opening else []
    if any(isinstance(hook, partial) for hook in lowered.closing):
        ends = (".~WAITING", ".~STARTED_NS")
        names += [path[: path.rfind(".")] for path in lowered.layout.leaves if path.endswith(ends)]
    tags = Tags(lowered, None)  # type: ignore[arg-type]  # names are resolved without memory
    received = [target for target, _ in lowered.replies.values()]  # data from messages and from producers
    received += [name for connection in lowered.connections for name in (connection.tag, connection.status)]
    for name in filter(None, received):
        names.append(tag_in(tags.where(name).path).upper())
    return tuple(names)


def named_paths(layout: Layout, option: str, patterns: Sequence[str]) -> frozenset[str]:
    """Return the paths, in capitals, that match patterns; a structure matches with all its members."""
    matched: set[str] = set()
    paths = [*layout.leaves] if patterns else []
    for glob in patterns:
        pattern = glob.upper().replace("[", "[[]")
        hits = [
            path
            for path in paths
            if path == glob.upper() or path.startswith(glob.upper() + ".") or fnmatchcase(path, pattern)
        ]
        if not hits:
            raise LadderError(f"{option}: no tag {glob!r}")
        matched.update(hits)
    return frozenset(matched)
