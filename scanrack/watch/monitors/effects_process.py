"""Finds what an edit would have done in the last scans, in its own process.

    values before scan n      inputs n, n + 1, ...      the running program      what happened
                              the same                  the edited one           what would have

Both run on the recorded inputs, so the result ignores that a machine would have moved differently.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from shutil import copytree
from types import CellType
from typing import Any, NamedTuple

from scanrack.jobs.trust.attachments import load_files
from scanrack.ladder import LadderLogic
from scanrack.ladder.debug.watching import WatchedEngine
from scanrack.ladder.lowering.edited import NewTag, normalized
from scanrack.ladder.model.tags import Leaf, tag_in
from scanrack.ladder.run.edit import carry_over
from scanrack.ladder.state.memory import Memory, same
from scanrack.ladder.state.snapshots import restore, snapshot
from scanrack.ladder.state.tag_bytes import TagBytes

from ..history.program_file import read_edit, rewrite
from ..history.program_replica import ProgramReplica, SnapshotStore
from ..history.recent import RecentRows
from ..history.watched_program import Inputs, Values
from .stretched import ReplayPackage

MOST_GROUPS, MOST_MEMBERS = 60, 20
"""Largest number of instances, and of members per instance, that a page receives."""


class EditEffect(NamedTuple):
    """A value that would have differed from a scan."""

    path: str
    output: bool
    scan: int


def answer(given: ReplayPackage) -> dict[str, Any]:
    """Return the values that would have differed, grouped by tag; raise ValueError if they are unknown."""
    with tempfile.TemporaryDirectory() as folder:
        old, new = _programs(given, Path(folder))
    groups: dict[str, dict[str, Any]] = {}
    for difference in sorted(differences(given, old, new), key=lambda each: (not each.output, each.scan)):
        name = tag_in(difference.path)
        new_group = {"name": name, "output": difference.output, "scan": difference.scan, "members": []}
        group = groups.setdefault(name, new_group)
        member = difference.path[len(name) :].lstrip(".")
        group["members"] += [member] if member and len(group["members"]) < MOST_MEMBERS else []
    listed = list(groups.values())
    scans = int(given.rows["scan"][-1]) - given.first + 1
    return {"groups": listed[:MOST_GROUPS], "more": max(0, len(listed) - MOST_GROUPS), "scans": scans}


def _programs(given: ReplayPackage, folder: Path) -> tuple[LadderLogic, LadderLogic]:
    edited_folder = folder / "edited"
    copytree(given.ran.place, edited_folder)
    file = edited_folder / given.ran.program.partition(":")[0]
    old = load_files(Path(given.ran.place), given.ran.rack, given.ran.program).logic
    assert isinstance(old, LadderLogic)
    edits, tags = (
        [normalized(read_edit(file.name, rung, old.specs), old) for rung in given.rungs],
        [NewTag(*tag) for tag in given.tags],
    )
    file.write_bytes(rewrite(file.name, file.read_bytes(), edits, tags, old.specs).data)
    new = load_files(edited_folder, given.ran.rack, given.ran.program).logic
    if not isinstance(new, LadderLogic) or old.functions or new.functions:
        raise ValueError("a program with routines in Python is not tried on earlier scans")
    return old, new


def _both_runs(given: ReplayPackage, old: LadderLogic, new: LadderLogic) -> list[ProgramReplica]:
    """Return a replica of either program that repeats the scans; the new one takes the old one's values."""
    engines = [WatchedEngine(program.build(), program.scanner) for program in (old, new)]
    restore(engines[0].memory, given.values)
    engines[0].scans = given.first
    carry_over(*engines)
    values = given.values, snapshot(engines[1].memory)
    return [_replica(given, *pair) for pair in zip((old, new), values, strict=True)]


def _common_cells(memory: Memory, other: Memory) -> list[tuple[str, CellType, CellType]]:
    return [(ident, cell, other.cells[ident]) for ident, cell in memory.cells.items() if ident in other.cells]


def differences(given: ReplayPackage, old: LadderLogic, new: LadderLogic) -> list[EditEffect]:
    """Run both programs on the same inputs; return each value that differs once."""
    first, last = given.first, int(given.rows["scan"][-1])
    runs = _both_runs(given, old, new)
    memories = [run.engine.memory for run in runs]
    pairs, cells = _pairs(*memories), _common_cells(*memories)
    effects: dict[str, EditEffect] = {}
    reported: set[str] = set()
    walks = (run.walk(first, last) for run in runs)
    for scan, _ in enumerate(zip(*walks, strict=False), first):
        unequal = {
            ident
            for ident, *pair in cells
            if ident not in reported and _contents(pair[0]) != _contents(pair[1])
        }
        if not unequal and scan < last:
            continue
        reported |= unequal
        for name, leaf in _unequal(memories, pairs):
            effects.setdefault(name, EditEffect(name, leaf.output, scan))
    return list(effects.values())


def _unequal(
    memories: Sequence[Memory], pairs: Iterable[tuple[str, Leaf, Leaf]]
) -> Iterator[tuple[str, Leaf]]:
    """Yield the names of values that differ now."""
    for path, leaf, twin in pairs:
        for index in range(leaf.size):
            if not same(memories[0].read(leaf, index), memories[1].read(twin, index)):
                yield f"{path}[{index}]" if leaf.size > 1 else path, leaf


def _replica(given: ReplayPackage, program: LadderLogic, values: Mapping[str, Any]) -> ProgramReplica:
    snapshots, rows = SnapshotStore(), RecentRows(given.rows.dtype)
    rows.add(given.rows)
    snapshots.take(Values(given.first, dict(values), 0))
    for record in (Inputs(given.first - 1, (), given.forces, None, 0), *given.inputs):
        snapshots.take(record)
    return ProgramReplica(program, given.layout, rows, snapshots)


def _contents(cell: CellType) -> Any:
    value = cell.cell_contents
    return value.saved() if isinstance(value, TagBytes) else value


def _pairs(old: Memory, new: Memory) -> list[tuple[str, Leaf, Leaf]]:
    """Return the values that both programs have."""
    return [
        (leaf.path, leaf, other_leaf)
        for leaf in old.layout.leaves.values()
        if "~" not in leaf.path
        and (other_leaf := new.layout.leaves.get(leaf.path.upper())) is not None
        and (leaf.type, leaf.size) == (other_leaf.type, other_leaf.size)
        and all(memory.has(side_leaf) for memory, side_leaf in ((old, leaf), (new, other_leaf)))
    ]
