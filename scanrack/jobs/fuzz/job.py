"""Loads the rack and program of a search in every worker, and writes the files about a failure."""

from __future__ import annotations

import json
import os
import shlex
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path
from types import ModuleType

from scanrack.io_images.amci3601.firmware import Firmware
from scanrack.ladder import LadderLogic
from scanrack.ladder.python.sequences import Logic, fresh
from scanrack.runtime.config.rackspec import RackSpec, SlotSpec
from scanrack.runtime.loop.listeners import ScanListener
from scanrack.runtime.loop.rack import Rack
from scanrack.runtime.loop.scan import ScanLogic
from scanrack.runtime.machine.spec import input_name
from scanrack.traces.plot import Mark, save_page
from scanrack.traces.read.reader import open_trace
from scanrack.traces.replay import PackedTrace

from ..load.claims import has_claims, with_monitors
from ..load.loading import LoadedRack, load_job
from ..load.program import LoadedProgram, executed_again, load_program
from ..record.recording import recorder_for
from ..record.sequence_watch import watching
from ..trust.attachments import forget_imported
from ..trust.owned import in_use
from . import STANDARD, Counterexample, Invariant, InvariantError, Scenario, TrialBench, load_invariants
from .aim.branches import branches_noted
from .explain.cause import cause_of
from .explain.futures import PointOfNoReturn, find_point_of_no_return
from .folder_lock import write_text
from .invariants.claimed import invariants_in
from .report import report
from .scenarios.drivescript import DriveScript, obstacle
from .scenarios.kinds import Kind
from .scenarios.panel import PanelTag, settings_of
from .scenarios.rackdoc import rack_text
from .scenarios.tearing import Rung, reading_rungs

RESERVE = 100
"""Number of scans recorded after a failure."""

AROUND_NS = 200_000_000
"""Time before and after the failure in the initial view of the chart, ns."""


@dataclass(frozen=True, slots=True)
class Setup:
    """The rack and the settings of a search. They can be sent to a worker."""

    rack: str
    invariants: tuple[Path, ...]
    checks: tuple[str, ...]  # standard invariants by name
    scans: int
    kinds: frozenset[Kind]
    seed: int = 0

    def with_absolute_paths(self) -> Setup:
        """Return the setup with absolute paths, for a worker that runs in another folder."""
        files = tuple(file.absolute() for file in self.invariants)
        return replace(self, rack=os.path.abspath(self.rack), invariants=files)

    @property
    def words(self) -> list[str]:
        """The invariants and checks as command-line options."""
        words = [word for file in self.invariants for word in ("--invariants", str(file))]
        return words + [word for check in self.checks for word in ("--check", check)]


@cache
def bench_of(setup: Setup) -> TrialBench:
    """Return the bench of a setup. A worker creates it only once.

    Raises:
        ValueError: the rack, the program or an invariant is unusable.
    """
    with branches_noted():
        job = load_job(setup.rack)
    fresh_logic, invariants = logic_factory(job, setup.rack), invariants_of(setup)
    if has_claims(job):
        monitored = with_monitors(job)  # claims in the program's text are invariants too
        fresh_logic, invariants = monitored.program.compile, [*invariants, *invariants_in(monitored)]
    spec = with_needed_firmware(job)
    rungs: tuple[Rung, ...] = ()
    settings: tuple[PanelTag, ...] = ()
    if isinstance(job.logic, LadderLogic):
        settings = settings_of(job.logic.compile().lowered, spec)
    if spec.controller == "compactlogix" and isinstance(job.logic, LadderLogic):
        rungs = reading_rungs(job.logic.compile().lowered)
    return TrialBench(spec, fresh_logic, invariants, scans=setup.scans, rungs=rungs, settings=settings)


NEEDS_FIRMWARE = "NEEDS_FIRMWARE"
"""Variable of a Python program with the oldest firmware that it supports."""


def with_needed_firmware(job: LoadedRack) -> RackSpec:
    """Return a job's rack with the firmware that its program requires.

    Raises:
        ValueError: a module's firmware is older, or the stated firmware is unknown.
    """
    modules = [module for module in list(sys.modules.values()) if _is_loaded_from(module, job.program)]
    versions = [vars(module)[NEEDS_FIRMWARE] for module in modules if NEEDS_FIRMWARE in vars(module)]
    if not versions or versions[0] is None:
        return job.spec
    try:
        needed = Firmware.parse(str(versions[0]))
    except ValueError as error:
        raise ValueError(f"{job.program}: {NEEDS_FIRMWARE} = {versions[0]!r}: {error}") from None
    slots = tuple(_slot_with_need(slot, needed, job) for slot in job.spec.slot)
    return job.spec.model_copy(update={"slot": slots})


def _is_loaded_from(module: ModuleType, program: Path) -> bool:
    file = getattr(module, "__file__", None)
    return isinstance(file, str) and Path(file) == program


def _slot_with_need(slot: SlotSpec, needed: Firmware, job: LoadedRack) -> SlotSpec:
    """Return a slot that needs at least a firmware; raise ValueError if the module's firmware is older."""
    if Firmware.parse(slot.firmware) < needed:
        raise ValueError(
            f"{job.program}: {NEEDS_FIRMWARE} is {needed}, but slot {slot.number} has "
            f"firmware {slot.firmware}"
        )
    needed = max(needed, Firmware.parse(slot.needs_firmware))
    return slot.model_copy(update={"needs_firmware": str(needed)})


def invariants_of(setup: Setup) -> list[Invariant]:
    """Return the invariants of a setup, with unique names.

    Raises:
        InvariantError: a file can't be used, or two files have invariants with the same name.
    """
    invariants = {name: STANDARD[name] for name in setup.checks}
    file_of: dict[str, Path] = {}
    for file in dict.fromkeys(setup.invariants):
        for invariant in load_invariants(file):
            name = invariant.name
            if name in file_of:
                raise InvariantError(f"{file}: {name} is also in {file_of[name]}; rename one of them")
            file_of[name] = file
            invariants[name] = invariant
    return list(invariants.values())


def logic_factory(job: LoadedRack, rack: str) -> Callable[[], ScanLogic]:
    """Return a function that creates the logic of a job."""
    logic = job.logic
    if isinstance(logic, LadderLogic):
        return logic.compile
    if isinstance(logic, Logic):
        return partial(fresh, logic)
    if job.rack_file == job.program:
        return lambda: _reload_logic(rack, job.folder.resolve())
    address = f"{job.program}:{job.logic_name.rpartition(':')[2]}"
    return _FunctionMaker(address, job.program.resolve().parent)


class _FunctionMaker:
    """Recreates the function of a Python program, with new globals in all modules of its folder."""

    def __init__(self, address: str, folder: Path) -> None:
        self._address, self._folder = address, folder
        self._program: LoadedProgram | None = None
        self._outside_modules: set[str] = set()  # names of modules that are not in the folder

    def __call__(self) -> ScanLogic:
        """Execute the program again, without its previously imported modules; return its function."""
        if sys.modules.keys() - self._outside_modules:
            forget_imported(self._folder)
            self._outside_modules = set(sys.modules)
        with branches_noted():
            if self._program is not None:
                return executed_again(self._program)
            self._program = load_program(self._address)
        return self._program.function


def _reload_logic(rack: str, folder: Path) -> ScanLogic:
    forget_imported(folder)
    with branches_noted():
        return load_job(rack).logic


def write_failure(
    job: LoadedRack,
    setup: Setup,
    bench: TrialBench,
    failure: Counterexample,
    folder: Path,
    has_time: Callable[[], bool] = lambda: True,
) -> bool:
    """Write the report, scenario, rack file, trace, drive scripts and chart of a failure.

    Args:
        has_time: returns whether there is time left to find the point of no return.

    Returns:
        Whether there was enough time to find it.

    Raises:
        OSError: a file can't be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    files_in_use = {**in_use(job), **dict.fromkeys(setup.invariants, "a file of invariants")}
    scans = min(bench.scans, failure.broken.scan + RESERVE)
    scenario = write_text(
        folder / "scenario.json", json.dumps(failure.scenario.to_json(), indent=1) + "\n", files_in_use
    )
    check = shlex.join(["scanrack", "fuzz", setup.rack, *setup.words, "--scenario", str(scenario)])
    commands = []
    if job.rack_file.suffix == ".toml":
        text = rack_text(job.rack_file, bench.spec, failure.scenario, scans, folder)
        rack_file = write_text(folder / "rack.toml", text, files_in_use)
        job = load_job(str(rack_file))
        commands.append(shlex.join(["scanrack", "run", str(rack_file)]))
        if failure.scenario.tears:
            commands.append("(without input changes in the middle of a scan: a rack file can't have them)")
        if failure.scenario.orders:
            commands.append("(without tags that an operator writes: a rack file can't have them)")
    commands += _record(job, bench, failure.scenario, scans, folder)
    point = find_point_of_no_return(bench, failure, has_time=has_time)
    with open_trace(folder / "trace.mcap") as trace:
        cause = cause_of(PackedTrace.of(trace), job, str(job.rack_file), failure.broken)
    chart = _draw_chart(failure, point, folder)
    write_text(folder / "report.txt", report(failure, point, cause, chart, commands, check), files_in_use)
    return point is not None


def _draw_chart(failure: Counterexample, point: PointOfNoReturn | None, folder: Path) -> list[str]:
    """Draw the trace as a page; return its path and a link to the part around the failure."""
    broken, page = failure.broken, folder / "chart.html"
    marks = [Mark(broken.now_ns, None, "broken", f"{broken.invariant} is broken", str(broken))]
    if point is not None and point.is_clear and point.scan < broken.scan:
        marks.append(Mark(point.now_ns, None, "broken", "inevitable", "\n".join(point.lines)))
    with open_trace(folder / "trace.mcap") as trace:
        save_page(trace, page, title=broken.sentence, more_marks=marks)
    begin_s, end_s = max(0, broken.now_ns - AROUND_NS) / 1e9, (broken.now_ns + AROUND_NS) / 1e9
    return [str(page), f"{page.resolve().as_uri()}#from={begin_s:.3f}&to={end_s:.3f}"]


def _record(job: LoadedRack, bench: TrialBench, scenario: Scenario, scans: int, folder: Path) -> list[str]:
    """Record a scenario as a trace and `scanrack drive` scripts; return the drive commands and notes."""
    scripts: dict[int, DriveScript] = {}
    lines = []

    def listeners(spec: RackSpec, rack: Rack, logic: ScanLogic) -> Iterable[ScanListener]:
        """Yield a script for each slot that the bench supports, and the recorder of the trace."""
        for slot in spec.slot:
            feature = obstacle(spec, slot)
            if feature is None:
                scripts[slot.number] = DriveScript(spec, slot, rack.slots[slot.number])
                yield scripts[slot.number]
            else:
                lines.append(f"(no drive script for slot {slot.number}: the bench doesn't support {feature})")
        trace, orders = folder / "trace.mcap", bool(scenario.orders)
        yield watching(recorder_for(job, rack, trace, logic, orders=orders, keep=0), logic)

    replace(bench, invariants=(), scans=scans).run(scenario, listeners=listeners)
    modules = {slot.number: slot.module for slot in bench.spec.slot}
    for number, script in scripts.items():
        file = write_text(folder / f"drive-slot{number}.jsonl", script.text())
        lines.append(f"scanrack drive {modules[number]} < {shlex.quote(str(file))}")
        if script.by_level:
            inputs = ", ".join(map(input_name, script.by_level))
            lines.append(f"(the script sets {inputs}, up to one scan later than the machine)")
    return lines


def replay(bench: TrialBench, scenario: Scenario) -> list[Counterexample]:
    """Run one scenario and show the program's output; return each failure once."""
    failures: list[Counterexample] = []
    known_keys: set[str] = set()
    while (broken := bench.run(scenario, without=known_keys, aloud=not known_keys).broken) is not None:
        failures.append(Counterexample(scenario, broken, 1))
        known_keys.add(broken.key)
    return failures
