"""Runs an export for the first time, on a rack in a temporary folder for a thousand scans, and reports.

Modules that are not simulated are only memory: no one presses a button, and no part arrives. So the report
names the conditions for which the program waits, the inputs that never changed, and the modules that would
change them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
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
"""Largest number of inputs that are listed as text."""


@dataclass(slots=True)
class FirstRun:
    """The result of a first run."""

    scans: int = 0  # number of completed scans
    time_ns: int = 0
    fault: str = ""  # why the run ended early; "" if it did not
    problem: str = ""  # why nothing ran; "" if it did
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
        """Yield the result as lines of text."""
        if self.problem:
            yield f"first run: none: {self.problem}"
            return
        ended = f", ended by {self.fault}" if self.fault else ""
        yield f"first run: {self.scans:,} scans, {time_text(self.time_ns)}{ended}"
        waits = [line for wait in self.waits for line in wait.lines()]
        modules = [_module_text(module) for module in self.modules]
        sections: dict[str, Iterable[str]] = {
            "it waits for": waits,
            "inputs that never changed": _first(self.inputs),
            "tags that nothing writes": _first(self.others),
            "modules it wants, memory here": modules,
            "in place of what is not here": self.stubs,
        }
        for title, section_rows in sections.items():
            row_lines = [f"    {row}" for row in section_rows]
            yield from (f"{title}:", *row_lines) if row_lines else ()


def first_run(
    export: Path,
    imported: L5xImport | SlcImport,
    scans: int = SCANS,
    begins: ExportStart = DOWNLOADED,
) -> FirstRun:
    """Run an export on its own rack and report.

    Args:
        imported: the export, already imported for a trial.
        begins: how the program begins.
    """
    missing = (module for module in _modules(imported) if module.module is None)
    run = FirstRun(modules=[_module_row(module) for module in missing])
    try:
        job = load_job(str(rack_of_export(export, imported, begins)))
        opened = bench_of(job, watched=True)
    except (LadderError, ValueError, OSError, RecursionError) as error:
        run.problem = str(error)
        return run
    with opened as bench:
        debugger: Debugger = bench.program
        inputs = _Inputs(debugger)
        _scan(bench, run, scans, inputs.look)
        run.stubs = job.stubs
        run.inputs, run.others = inputs.unchanged(module=True), inputs.unchanged(module=False)
        if bench.scans and not run.fault:
            run.waits = conditions(debugger)
    return run


def _modules(imported: L5xImport | SlcImport) -> list[ExportSlot]:
    if isinstance(imported, SlcImport):
        return slots_of_slc(imported.document.slots.values())
    return all_modules(imported.document.modules)


STRIDE = 20
"""Number of scans between two checks of the inputs."""


def _scan(bench: Bench, run: FirstRun, scans: int, look: Any) -> None:
    try:
        for begin in range(0, scans, STRIDE):
            bench.scan(min(STRIDE, scans - begin))
            look()
    except CpuFault as error:
        run.fault = str(error)
    run.scans, run.time_ns = bench.scans, bench.now_ns


class _Inputs:
    """The tags that instructions read but none writes, with their initial values."""

    def __init__(self, debugger: Debugger) -> None:
        self._engine = debugger.engine
        self._places = dict(_read_only(debugger))
        self._before = {name: self._value(place) for name, place in self._places.items()}
        self._changed: set[str] = set()

    def _value(self, place: Place) -> Value:
        return self._engine.interpreter.get(place)

    def look(self) -> None:
        """Record the inputs that have changed."""
        for name, value in self._before.items():
            if name not in self._changed and self._value(self._places[name]) != value:
                self._changed.add(name)

    def unchanged(self, *, module: bool) -> list[str]:
        """Return the inputs that never changed: inputs of modules, or all others."""
        left = (name for name in self._places if name not in self._changed)
        return [name for name in left if (":" in self._places[name].path) is module]


def _read_only(debugger: Debugger) -> Iterator[tuple[str, Place]]:
    """Yield tags that are read but never written, as named in rungs; skip computed subscripts."""
    paths_written: set[str] = set()
    read: dict[str, Place] = {}
    for mention in debugger.cross_reference.mentions:
        where = mention.where
        if mention.writes:
            paths_written.add(path_of(where))
        elif isinstance(where, Place) and not where.frame and _is_fixed(where):
            read.setdefault(mention.text, where)
    for text, where in read.items():
        parts = where.path.upper().split(".")
        above = {".".join(parts[:count]) for count in range(1, len(parts) + 1)}
        if above.isdisjoint(paths_written) and not parts[0].startswith("S:"):
            yield text, where


def _is_fixed(place: Place) -> bool:
    return all(isinstance(index, Constant) for index in (*place.indices, *filter(None, [place.bit])))


def _first(names: list[str]) -> list[str]:
    return [*names[:SHOWN], *([f"and {len(names) - SHOWN:,} more"] * (len(names) > SHOWN))]


def _module_row(slot: ExportSlot) -> dict[str, object]:
    return {"name": slot.name, "catalog": slot.catalog, "slot": slot.number or None, "tags": slot.tags}


def _module_text(module: dict[str, object]) -> str:
    place = f"slot {module['slot']}" if module["slot"] else "on a network"
    tags = f": {module['tags']}" if module["tags"] else ""
    return f"{module['catalog'] or 'a module'} {module['name']}".rstrip() + f", {place}{tags}"
