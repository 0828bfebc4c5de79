"""Finds what may change outside a program's scan: inputs by their names, bits, and numbers."""

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
    """Whether a path, in capitals, is LEN of a CONTROL and not of a string, which has no POS."""
    return path.endswith(".LEN") and layout.find(f"{path[:-4]}.POS") is not None


def named_bits(lowered: LoweredProgram) -> dict[Key, int]:
    """Return masks of the bits of numbers that operands name, except arguments of add-on instructions."""
    found: dict[Key, int] = defaultdict(int)
    for place in _places_in(operand for step in lowered.all_steps for operand in step.operands):
        if place.bit is None or place.leaf.root:
            continue
        mask = (
            1 << int(place.bit.value) if isinstance(place.bit, Constant) else (1 << place.leaf.type.bits) - 1
        )
        index = place.fixed_index
        for each in range(place.leaf.size) if index is None else (index,):
            found[place.path.upper(), each] |= mask
    return found


def _places_in(operands: Iterable[Any]) -> Iterator[Place]:
    """Yield the places in operands, including those in expressions, subscripts and calls."""
    todo = list(operands)
    while todo:
        each = todo.pop()
        if isinstance(each, Place):
            yield each
            todo += [*each.indices, each.bit]
        elif isinstance(each, Calculation):
            todo += each.operands
        elif isinstance(each, Call):
            todo += each.inputs


def written_bits(after: T, v: T) -> int:
    """Return a mask of the bits that a scan may change, from the number's term after the scan."""
    mask, todo, seen = 0, [after], set()
    while todo:
        t = todo.pop()
        if t is v or t.id in seen:
            continue
        seen.add(t.id)
        if t.op == "setbit":
            mask |= 1 << t.val[0]
            todo.append(t.args[0])
        elif t.op == "ite":
            todo += t.args[1:]
        else:
            return -1
    return mask


def refuse(lowered: LoweredProgram) -> None:
    """Raise a LadderError if a program has parts that proofs don't cover."""
    schedule = lowered.schedule
    found = [f"routine {name} in Python" for name in sorted(lowered.functions)]
    if schedule is not None:
        found += [
            f"task {scheduled.task.name}, which preempts"
            for scheduled in schedule.tasks
            if scheduled.task.preempt
        ]
        found += [f"fault routine {each.fault}" for each in schedule.programs if each.fault is not None]
    found += [f"the sequential function chart {name}" for name in sorted(lowered.charts)]
    if lowered.axes or lowered.ideal is not None:
        found.append("motion axes")
    if found:
        raise LadderError(f"{lowered.name} has {', '.join(found)}, which proofs don't cover")


def written_beside(lowered: LoweredProgram) -> tuple[str, ...]:
    """Return prefixes of paths that are not only written by rungs: SLC status, messages, consumed tags."""
    found = [STATUS] if before_scan in lowered.opening else []
    if any(isinstance(hook, partial) for hook in lowered.closing):
        ends = (".~WAITING", ".~STARTED_NS")
        found += [path[: path.rfind(".")] for path in lowered.layout.leaves if path.endswith(ends)]
    tags = Tags(lowered, None)  # type: ignore[arg-type]  # names are resolved without memory
    brought = [to for to, _ in lowered.replies.values()]  # data from messages and from producers
    brought += [name for connection in lowered.connections for name in (connection.tag, connection.status)]
    for name in filter(None, brought):
        found.append(tag_in(tags.where(name).path).upper())
    return tuple(found)


def named_paths(layout: Layout, what: str, patterns: Sequence[str]) -> frozenset[str]:
    """Return the paths, in capitals, that match patterns; a structure matches with all its members."""
    found: set[str] = set()
    paths = [*layout.leaves] if patterns else []
    for each in patterns:
        pattern = each.upper().replace("[", "[[]")
        hits = [
            path
            for path in paths
            if path == each.upper() or path.startswith(each.upper() + ".") or fnmatchcase(path, pattern)
        ]
        if not hits:
            raise LadderError(f"{what}: no tag is called {each!r}")
        found.update(hits)
    return frozenset(found)
