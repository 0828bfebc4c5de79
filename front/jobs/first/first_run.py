"""The first run of an export, on a rack in a temporary folder: a thousand scans, and what they show.

What is not simulated is memory: nobody presses a button, no part comes by. So the report names the conditions
that the program waits for, the inputs that never changed, and the modules that would change them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ...ladder.debug import Debugger
from ...ladder.model.errors import LadderError
from ...ladder.model.operands import Place
from ...runtime.loop.faults import CpuFault
from ..bench.bench import Bench
from ..bench.opening import bench_of
from ..imports.export_slots import ExportSlot
from ..load.exports import rack_of_export
from ..load.loading import load_job
from .waiting import Condition, conditions

SCANS = 1000
"""Scans of a first run."""

SHOWN = 12
"""Inputs that are listed as text."""


@dataclass(slots=True)
class FirstRun:
    """What a first run shows."""

    scans: int = 0  # done
    time_ns: int = 0
    fault: str = ""  # why it ended early, "" if it did not
    problem: str = ""  # why nothing ran, "" if something did
    stubs: tuple[str, ...] = ()
    waits: list[Condition] = field(default_factory=list)
    inputs: list[str] = field(default_factory=list)  # of modules, that never changed
    others: list[str] = field(default_factory=list)  # read, and written by nothing: panel, other controllers
    modules: list[dict[str, object]] = field(default_factory=list)  # not simulated

    def as_json(self) -> dict[str, Any]:
        """Return it for `--json`."""
        return {
            "scans": self.scans,
            "time_ns": self.time_ns,
            "fault": self.fault,
            "problem": self.problem,
            "stubs": list(self.stubs),
            "waits": [each.as_json() for each in self.waits],
            "unchanged_inputs": self.inputs,
            "never_written": self.others,
            "modules": self.modules,
        }

    def lines(self) -> Iterator[str]:
        """Yield it as text."""
        if self.problem:
            yield f"first run: none: {self.problem}"
            return
        ended = f", ended by {self.fault}" if self.fault else ""
        yield f"first run: {self.scans:,} scans, {self.time_ns / 1e9:g} s{ended}"
        waits = [line for each in self.waits for line in each.lines()]
        modules = [_module_text(each) for each in self.modules]
        sections: dict[str, Iterable[str]] = {
            "it waits for": waits,
            "inputs that never changed": _first(self.inputs),
            "tags that nothing writes": _first(self.others),
            "modules it wants, memory here": modules,
            "in place of what is not here": self.stubs,
        }
        for title, listed in sections.items():
            shown = [f"    {each}" for each in listed]
            yield from (f"{title}:", *shown) if shown else ()


def first_run(export: Path, modules: Iterable[ExportSlot], *, slc: bool, scans: int = SCANS) -> FirstRun:
    """Run an export on a rack of its own, and report.

    Args:
        modules: the modules of the export.
        slc: whether it is a text of RSLogix 500.
    """
    found = FirstRun(modules=[_wanted(each) for each in modules if each.module is None])
    try:
        job = load_job(str(rack_of_export(export, slc=slc)))
    except (LadderError, ValueError, OSError) as error:
        found.problem = str(error)
        return found
    with bench_of(job, watched=True) as bench:
        debugger: Debugger = bench.program
        reads = list(_read_only(debugger))
        before = _values(debugger, [text for text, _ in reads])
        modules_own = {text for text, is_module in reads if is_module}
        changed: set[str] = set()
        _scan(bench, found, scans, lambda: changed.update(_changed(debugger, before)))
        found.stubs = job.stubs
        for each in before:
            if each not in changed:
                (found.inputs if each in modules_own else found.others).append(each)
        if bench.scans and not found.fault:
            found.waits = conditions(debugger)
    return found


STRIDE = 20
"""Scans between two looks at the inputs."""


def _scan(bench: Bench, found: FirstRun, scans: int, look: Any) -> None:
    try:
        for begin in range(0, scans, STRIDE):
            bench.scan(min(STRIDE, scans - begin))
            look()
    except CpuFault as error:
        found.fault = str(error)
    found.scans, found.time_ns = bench.scans, bench.now_ns


def _read_only(debugger: Debugger) -> Iterator[tuple[str, bool]]:
    """Yield the tags that instructions read and none writes, as in rungs, and whether a module has them."""
    written: set[str] = set()
    read: dict[str, str] = {}
    for each in debugger.cross_reference.mentions:
        where = each.where
        path = (where.leaf.path if isinstance(where, Place) else where.path).upper()
        if each.writes:
            written.add(path)
        elif isinstance(where, Place) and not where.leaf.frame:
            read.setdefault(each.text, path)  # an alias has its own text, and the path of its target
    for text, path in read.items():
        parts = path.split(".")
        above = {".".join(parts[:count]) for count in range(1, len(parts) + 1)}
        if not above & written and not path.startswith("S:"):
            yield text, ":" in path


def _first(names: list[str]) -> list[str]:
    return [*names[:SHOWN], *([f"and {len(names) - SHOWN:,} more"] * (len(names) > SHOWN))]


def _values(debugger: Debugger, names: Iterable[str]) -> dict[str, Any]:
    found = {}
    for each in names:
        try:
            found[each] = debugger.tags[each]
        except (LadderError, ValueError):
            continue  # a computed subscript, or a constant of an instruction
    return found


def _changed(debugger: Debugger, before: dict[str, Any]) -> list[str]:
    return [name for name, value in before.items() if debugger.tags[name] != value]


def _wanted(slot: ExportSlot) -> dict[str, object]:
    return {"name": slot.name, "catalog": slot.catalog, "slot": slot.number or None, "tags": slot.tags}


def _module_text(module: dict[str, object]) -> str:
    place = f"slot {module['slot']}" if module["slot"] else "on a network"
    tags = f": {module['tags']}" if module["tags"] else ""
    return f"{module['catalog'] or 'a module'} {module['name']}".rstrip() + f", {place}{tags}"
