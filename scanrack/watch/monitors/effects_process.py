"""The process that finds what an edit would have changed in the latest scans.

    values before scan n      inputs n, n + 1, ...      the running program      its values
                              the same                  the edited program       other values

Both programs run on the recorded inputs, so the result ignores differences in the motion of the machine.
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
"""Maximum number of tags, and of members per tag, that a page gets."""


class EditEffect(NamedTuple):
    """A value that would have differed."""

    path: str
    output: bool
    scan: int


def answer(package: ReplayPackage) -> dict[str, Any]:
    """Return the values that would have differed, by tag; raise ValueError if the edit can't be tried."""
    with tempfile.TemporaryDirectory() as folder:
        old, new = _programs(package, Path(folder))
    effects = differences(package, old, new)
    effects.sort(key=lambda effect: (not effect.output, effect.scan))
    groups: dict[str, dict[str, Any]] = {}
    for effect in effects:
        name = tag_in(effect.path)
        new_group = {"name": name, "output": effect.output, "scan": effect.scan, "members": []}
        group = groups.setdefault(name, new_group)
        member = effect.path[len(name) :].lstrip(".")
        if member and len(group["members"]) < MOST_MEMBERS:
            group["members"].append(member)
    listed = list(groups.values())
    scans = int(package.rows["scan"][-1]) - package.first + 1
    return {"groups": listed[:MOST_GROUPS], "more": max(0, len(listed) - MOST_GROUPS), "scans": scans}


def _programs(package: ReplayPackage, folder: Path) -> tuple[LadderLogic, LadderLogic]:
    """Load the running program, and a copy with the edited rungs from `folder`.

    Raises:
        ValueError: a program has routines in Python, so that it can't be tried.
    """
    edited_folder, running = folder / "edited", package.ran
    copytree(running.place, edited_folder)
    file = edited_folder / running.program.partition(":")[0]
    old = load_files(Path(running.place), running.rack, running.program).logic
    assert isinstance(old, LadderLogic)
    edits = [normalized(read_edit(file.name, rung, old.specs), old) for rung in package.rungs]
    tags = [NewTag(*tag) for tag in package.tags]
    file.write_bytes(rewrite(file.name, file.read_bytes(), edits, tags, old.specs).data)
    new = load_files(edited_folder, running.rack, running.program).logic
    if not isinstance(new, LadderLogic) or old.functions or new.functions:
        raise ValueError("a program with routines in Python can't be tried on earlier scans")
    return old, new


def _both_runs(package: ReplayPackage, old: LadderLogic, new: LadderLogic) -> list[ProgramReplica]:
    """Return replicas of both programs that start with the same values."""
    old_engine, new_engine = (WatchedEngine(program.build(), program.scanner) for program in (old, new))
    restore(old_engine.memory, package.values)
    old_engine.scans = package.first
    carry_over(old_engine, new_engine)
    new_values = snapshot(new_engine.memory)
    return [_replica(package, old, package.values), _replica(package, new, new_values)]


def _common_cells(old: Memory, new: Memory) -> list[tuple[str, CellType, CellType]]:
    return [(ident, cell, new.cells[ident]) for ident, cell in old.cells.items() if ident in new.cells]


def differences(package: ReplayPackage, old: LadderLogic, new: LadderLogic) -> list[EditEffect]:
    """Run both programs on the same inputs; return each value that differs, with the first such scan."""
    first, last = package.first, int(package.rows["scan"][-1])
    runs = _both_runs(package, old, new)
    memories = [run.engine.memory for run in runs]
    pairs, cells = _pairs(*memories), _common_cells(*memories)
    effects: dict[str, EditEffect] = {}
    reported: set[str] = set()  # cells that have differed
    walks = (run.walk(first, last) for run in runs)
    for scan, _ in enumerate(zip(*walks, strict=False), first):
        unequal = {
            ident
            for ident, old_cell, new_cell in cells
            if ident not in reported and _contents(old_cell) != _contents(new_cell)
        }
        if not unequal and scan < last:
            continue
        reported |= unequal
        for path, leaf in _unequal(memories, pairs):
            effects.setdefault(path, EditEffect(path, leaf.output, scan))
    return list(effects.values())


def _unequal(
    memories: Sequence[Memory], pairs: Iterable[tuple[str, Leaf, Leaf]]
) -> Iterator[tuple[str, Leaf]]:
    """Yield the paths of values that differ now."""
    for path, old_leaf, new_leaf in pairs:
        for index in range(old_leaf.size):
            if not same(memories[0].read(old_leaf, index), memories[1].read(new_leaf, index)):
                yield f"{path}[{index}]" if old_leaf.size > 1 else path, old_leaf


def _replica(package: ReplayPackage, program: LadderLogic, values: Mapping[str, Any]) -> ProgramReplica:
    """Return a replica of a program with the given values and the inputs of the package."""
    store, rows = SnapshotStore(), RecentRows(package.rows.dtype)
    rows.add(package.rows)
    store.take(Values(package.first, dict(values), program=0))
    # forces of a scan are looked up in the notes before it
    forces_note = Inputs(package.first - 1, writes=(), forces=package.forces, images=None, program=0)
    for inputs in (forces_note, *package.inputs):
        store.take(inputs)
    return ProgramReplica(program, package.layout, rows, store)


def _contents(cell: CellType) -> Any:
    value = cell.cell_contents
    return value.saved() if isinstance(value, TagBytes) else value


def _pairs(old: Memory, new: Memory) -> list[tuple[str, Leaf, Leaf]]:
    """Return the path and both leaves of each value that both programs have, without internal values."""
    pairs = []
    for leaf in old.layout.leaves.values():
        new_leaf = new.layout.leaves.get(leaf.path.upper())
        if "~" in leaf.path or new_leaf is None:
            continue
        is_same_kind = (leaf.type, leaf.size) == (new_leaf.type, new_leaf.size)
        if is_same_kind and old.has(leaf) and new.has(new_leaf):
            pairs.append((leaf.path, leaf, new_leaf))
    return pairs
