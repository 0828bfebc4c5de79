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
    for each in sorted(differences(given, old, new), key=lambda each: (not each.output, each.scan)):
        name = tag_in(each.path)
        begun = {"name": name, "output": each.output, "scan": each.scan, "members": []}
        group = groups.setdefault(name, begun)
        member = each.path[len(name) :].lstrip(".")
        group["members"] += [member] if member and len(group["members"]) < MOST_MEMBERS else []
    found = list(groups.values())
    scans = int(given.rows["scan"][-1]) - given.first + 1
    return {"groups": found[:MOST_GROUPS], "more": max(0, len(found) - MOST_GROUPS), "scans": scans}


def _programs(given: ReplayPackage, folder: Path) -> tuple[LadderLogic, LadderLogic]:
    edited = folder / "edited"
    copytree(given.ran.place, edited)
    file = edited / given.ran.program.partition(":")[0]
    old = load_files(Path(given.ran.place), given.ran.rack, given.ran.program).logic
    assert isinstance(old, LadderLogic)
    edits, tags = (
        [normalized(read_edit(file.name, each, old.specs), old) for each in given.rungs],
        [NewTag(*each) for each in given.tags],
    )
    file.write_bytes(rewrite(file.name, file.read_bytes(), edits, tags, old.specs).data)
    new = load_files(edited, given.ran.rack, given.ran.program).logic
    if not isinstance(new, LadderLogic) or old.functions or new.functions:
        raise ValueError("a program with routines in Python is not tried on earlier scans")
    return old, new


def _both_runs(given: ReplayPackage, old: LadderLogic, new: LadderLogic) -> list[ProgramReplica]:
    """Return a replica of either program that repeats the scans; the new one takes the old one's values."""
    engines = [WatchedEngine(each.build(), each.scanner) for each in (old, new)]
    restore(engines[0].memory, given.values)
    engines[0].scans = given.first
    carry_over(*engines)
    values = given.values, snapshot(engines[1].memory)
    return [_replica(given, *each) for each in zip((old, new), values, strict=True)]


def _common_cells(memory: Memory, other: Memory) -> list[tuple[str, CellType, CellType]]:
    return [(ident, each, other.cells[ident]) for ident, each in memory.cells.items() if ident in other.cells]


def differences(given: ReplayPackage, old: LadderLogic, new: LadderLogic) -> list[EditEffect]:
    """Run both programs on the same inputs; return each value that differs once."""
    first, last = given.first, int(given.rows["scan"][-1])
    runs = _both_runs(given, old, new)
    memories = [each.engine.memory for each in runs]
    pairs, cells = _pairs(*memories), _common_cells(*memories)
    found: dict[str, EditEffect] = {}
    seen: set[str] = set()
    walks = (each.walk(first, last) for each in runs)
    for scan, _ in enumerate(zip(*walks, strict=False), first):
        unequal = {
            ident for ident, *both in cells if ident not in seen and _contents(both[0]) != _contents(both[1])
        }
        if not unequal and scan < last:
            continue
        seen |= unequal
        for name, leaf in _unequal(memories, pairs):
            found.setdefault(name, EditEffect(name, leaf.output, scan))
    return list(found.values())


def _unequal(
    memories: Sequence[Memory], pairs: Iterable[tuple[str, Leaf, Leaf]]
) -> Iterator[tuple[str, Leaf]]:
    """Yield the names of values that differ now."""
    for path, leaf, twin in pairs:
        for index in range(leaf.size):
            if not same(memories[0].read(leaf, index), memories[1].read(twin, index)):
                yield f"{path}[{index}]" if leaf.size > 1 else path, leaf


def _replica(given: ReplayPackage, program: LadderLogic, values: Mapping[str, Any]) -> ProgramReplica:
    kept, rows = SnapshotStore(), RecentRows(given.rows.dtype)
    rows.add(given.rows)
    kept.take(Values(given.first, dict(values), 0))
    for record in (Inputs(given.first - 1, (), given.forces, None, 0), *given.inputs):
        kept.take(record)
    return ProgramReplica(program, given.layout, rows, kept)


def _contents(cell: CellType) -> Any:
    value = cell.cell_contents
    return value.saved() if isinstance(value, TagBytes) else value


def _pairs(old: Memory, new: Memory) -> list[tuple[str, Leaf, Leaf]]:
    """Return the values that both programs have."""
    return [
        (leaf.path, leaf, other)
        for leaf in old.layout.leaves.values()
        if "~" not in leaf.path
        and (other := new.layout.leaves.get(leaf.path.upper())) is not None
        and (leaf.type, leaf.size) == (other.type, other.size)
        and all(memory.has(each) for memory, each in ((old, leaf), (new, other)))
    ]
