"""Runs an export for the first time, on a rack in a temporary folder for a thousand scans, and reports.

Modules that are not simulated are only memory, so no button is pressed and no part arrives. The report lists
the conditions the program waits for, the inputs that never changed, and the modules that are not simulated.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from scanrack.io_images.times import time_text
from scanrack.ladder.debug import Debugger
from scanrack.ladder.model.errors import LadderError
from scanrack.ladder.model.operands import Constant, Place
from scanrack.ladder.state.memory import Value
from scanrack.rockwell.l5x import L5xImport
from scanrack.rockwell.slc import SlcImport
from scanrack.runtime.loop.faults import CpuFault

from ..bench.bench import Bench
from ..bench.opening import bench_of
from ..check.rungs.operands import path_of
from ..imports.export_slots import ExportSlot
from ..imports.export_start import DOWNLOADED, ExportStart
from ..imports.l5x_rack import all_modules
from ..imports.slc_rack import slots_of_slc
from ..load.exports import rack_of_export
from ..load.loading import load_job
from .waiting import Condition, conditions

SCANS = 1000
"""Number of scans in a first run."""

SHOWN = 12
"""Maximum number of inputs that are listed as text."""


@dataclass(slots=True)
class FirstRun:
    """The result of a first run."""

    scans: int = 0  # number of completed scans
    time_ns: int = 0
    fault: str = ""  # the fault that ended the run early, or ""
    problem: str = ""  # the reason why nothing ran, or ""
    stubs: tuple[str, ...] = ()
    waits: list[Condition] = field(default_factory=list)
    inputs: list[str] = field(default_factory=list)  # inputs of modules that never changed
    others: list[str] = field(default_factory=list)  # tags that are read but never written
    modules: list[dict[str, object]] = field(default_factory=list)  # modules that are not simulated

    def as_json(self) -> dict[str, Any]:
        """Return the result for `--json`."""
        return {
            "scans": self.scans,
            "time_ns": self.time_ns,
            "fault": self.fault,
            "problem": self.problem,
            "stubs": list(self.stubs),
            "waits": [wait.as_json() for wait in self.waits],
            "unchanged_inputs": self.inputs,
            "never_written": self.others,
            "modules": self.modules,
        }

    def lines(self) -> Iterator[str]:
        """Yield the result as lines of text: the run, and each list that is not empty."""
        if self.problem:
            yield f"first run: not possible: {self.problem}"
            return
        end_text = f", ended by {self.fault}" if self.fault else ""
        yield f"first run: {self.scans:,} scans, {time_text(self.time_ns)}{end_text}"
        sections: dict[str, Sequence[str]] = {
            "it waits for": [line for wait in self.waits for line in wait.lines()],
            "inputs that never changed": _first(self.inputs),
            "tags that nothing writes": _first(self.others),
            "modules that are not simulated, only memory": [_module_text(module) for module in self.modules],
            "stubs": self.stubs,
        }
        for title, rows in sections.items():
            if rows:
                yield f"{title}:"
                yield from (f"    {row}" for row in rows)


def first_run(
    export: Path,
    imported: L5xImport | SlcImport,
    scans: int = SCANS,
    start: ExportStart = DOWNLOADED,
) -> FirstRun:
    """Run an export on its own rack; return the report.

    Args:
        imported: the export, already imported for a trial.
        start: initial state of the program.
    """
    not_simulated = (slot for slot in _slots(imported) if slot.module is None)
    run = FirstRun(modules=[_module_row(slot) for slot in not_simulated])
    try:
        job = load_job(str(rack_of_export(export, imported, start)))
        opened = bench_of(job, watched=True)
    except (LadderError, ValueError, OSError, RecursionError) as error:
        run.problem = str(error)
        return run
    with opened as bench:
        debugger: Debugger = bench.program
        inputs = _Inputs(debugger)
        _scan(bench, run, scans, inputs)
        run.stubs = job.stubs
        run.inputs, run.others = inputs.unchanged(of_modules=True), inputs.unchanged(of_modules=False)
        if bench.scans and not run.fault:
            run.waits = conditions(debugger)
    return run


def _slots(imported: L5xImport | SlcImport) -> list[ExportSlot]:
    if isinstance(imported, SlcImport):
        return slots_of_slc(imported.document.slots.values())
    return all_modules(imported.document.modules)


STRIDE = 20
"""Number of scans between two checks of the inputs."""


def _scan(bench: Bench, run: FirstRun, scans: int, inputs: _Inputs) -> None:
    """Run scans up to a fault; check the inputs at intervals."""
    try:
        for begin in range(0, scans, STRIDE):
            bench.scan(min(STRIDE, scans - begin))
            inputs.note_changes()
    except CpuFault as error:
        run.fault = str(error)
    run.scans, run.time_ns = bench.scans, bench.now_ns


class _Inputs:
    """The tags that instructions read but no instruction writes, with their initial values."""

    def __init__(self, debugger: Debugger) -> None:
        self._engine = debugger.engine
        self._unchanged = dict(_read_only(debugger))
        self._initial = {name: self._value(place) for name, place in self._unchanged.items()}

    def _value(self, place: Place) -> Value:
        return self._engine.interpreter.get(place)

    def note_changes(self) -> None:
        """Drop the inputs whose values differ from their initial values."""
        self._unchanged = {
            name: place
            for name, place in self._unchanged.items()
            if self._value(place) == self._initial[name]
        }

    def unchanged(self, *, of_modules: bool) -> list[str]:
        """Return the inputs that never changed: either module inputs or all others."""
        return [name for name, place in self._unchanged.items() if (":" in place.path) is of_modules]


def _read_only(debugger: Debugger) -> Iterator[tuple[str, Place]]:
    """Yield tags that are read but never written, as named in rungs. Skip computed subscripts."""
    written_paths: set[str] = set()
    read: dict[str, Place] = {}
    for mention in debugger.cross_reference.mentions:
        place = mention.where
        if mention.writes:
            written_paths.add(path_of(place))
        elif isinstance(place, Place) and not place.frame and _is_fixed(place):
            read.setdefault(mention.text, place)
    for text, place in read.items():
        members = place.path.upper().split(".")
        path_and_owners = {".".join(members[:count]) for count in range(1, len(members) + 1)}
        if path_and_owners.isdisjoint(written_paths) and not members[0].startswith("S:"):
            yield text, place


def _is_fixed(place: Place) -> bool:
    """Return whether all subscripts of a tag are constants."""
    subscripts = place.indices if place.bit is None else (*place.indices, place.bit)
    return all(isinstance(subscript, Constant) for subscript in subscripts)


def _first(names: list[str]) -> list[str]:
    """Return the first `SHOWN` names, and a line with the number of remaining names."""
    more = len(names) - SHOWN
    return [*names[:SHOWN], f"and {more:,} more"] if more > 0 else names


def _module_row(slot: ExportSlot) -> dict[str, object]:
    return {"name": slot.name, "catalog": slot.catalog, "slot": slot.number or None, "tags": slot.tags}


def _module_text(module: dict[str, object]) -> str:
    place = f"slot {module['slot']}" if module["slot"] else "on a network"
    tags = f": {module['tags']}" if module["tags"] else ""
    return f"{module['catalog'] or 'a module'} {module['name']}".rstrip() + f", {place}{tags}"
