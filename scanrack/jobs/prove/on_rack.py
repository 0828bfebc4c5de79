"""Runs a scenario on the rack, with the models of its modules.

The program first runs with its monitors, to find the scan that breaks the claim. Then it runs without them
and is recorded, so that `scanrack watch` and `scanrack why` can open the recording. Module words are forced.
If a run without the forces also breaks the claim, the modules produce these inputs themselves.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from scanrack.io_images.times import time_text
from scanrack.ladder import LadderLogic
from scanrack.ladder.debug import Debugger
from scanrack.ladder.model.tags import Layout
from scanrack.ladder.prove.answers import tag_text
from scanrack.ladder.prove.monitors import ClaimWatch, WatchedClaim
from scanrack.ladder.prove.replaying import ScanOf
from scanrack.ladder.prove.system import Key
from scanrack.ladder.state.lowered import LoweredProgram
from scanrack.runtime.live.operator_actions import AppliedAction
from scanrack.runtime.loop.faults import CpuFault
from scanrack.runtime.loop.listeners import QuietListener

from ..load.loading import LoadedRack
from ..run.running import JobRun, RunOptions
from .scenario import RackScenario, on_scans_of
from .subject import ProofSubject

TWO_RUNS = "it needs two runs with the same --retain FILE, but a scenario is one run"
"""The reason why a scenario that restarts with retained tags is not run."""

MORE = 5
"""Number of scans recorded after the scan that breaks the claim."""


@dataclass(frozen=True, slots=True)
class OnRack:
    """The effect of a scenario on the rack.

    Attributes:
        confirmed: whether the scenario showed the expected result.
        scan: number of the scan that showed it, from 0; None if no scan did.
        scenario: the operator actions of the scenario.
        forced: forced words that the modules do not produce themselves.
        why: the reason if the scenario did not show the result, or could not be run.
    """

    confirmed: bool
    scan: int | None
    scenario: RackScenario
    forced: tuple[str, ...] = ()
    why: str = ""

    def __str__(self) -> str:
        if not self.confirmed:
            return f"on the rack: {self.why}"
        text = f"on the rack: scan {self.scan}"
        if not self.forced:
            return f"{text}, without forced inputs"
        words = ", ".join(self.forced)
        return f"{text} with {words} forced: the models of the modules do not produce these inputs"

    def to_json(self) -> dict[str, Any]:
        """Return the result as JSON values."""
        return {"confirmed": self.confirmed, "scan": self.scan, "forced": list(self.forced), "why": self.why}


Shows = Callable[[Debugger], Callable[[], bool]]
"""Returns, for a program before its run, a test of whether the latest scan shows the expected result."""

FindScan = Callable[[RackScenario], int | None]
"""Runs a scenario; returns the first scan that shows the expected result, or None."""


def claim_broken(subject: ProofSubject, watched: WatchedClaim) -> Shows:
    """Return a test of whether the latest scan breaks a claim while its assumptions are true."""

    def shows(program: Debugger) -> Callable[[], bool]:
        watch = ClaimWatch(subject.program, watched)
        return lambda: watch.is_broken(program.tags)

    return shows


def coils_disagree(subject: ProofSubject, coils: Sequence[int]) -> Shows:
    """Return a test of whether two coils had different power in the latest scan."""
    places = [_place_of(subject.problem.lowered, number) for number in coils]

    def shows(program: Debugger) -> Callable[[], bool]:
        program.note_power()

        def power(routine: str, rung: int, place: int) -> bool | None:
            """Return the power after an instruction in the latest scan; None if its rung was not scanned."""
            truth = program.truth(routine)[rung]
            return None if truth is None else truth[place]

        return lambda: {power(*place) for place in places} == {True, False}

    return shows


def _place_of(lowered: LoweredProgram, number: int) -> tuple[str, int, int]:
    """Return the routine and rung of an instruction, and its place in the rung."""
    for routine in lowered.routines.values():
        for line in routine.lines:
            sites = [step.site for step in line.steps]
            if number in sites:
                return routine.name, line.number, sites.index(number)
    raise ValueError(f"no rung has instruction {number}")


def replay_on_rack(subject: ProofSubject, shows: Shows, scans: Sequence[ScanOf]) -> OnRack | None:
    """Run a scenario on the subject's rack; return None if there is no rack.

    Args:
        shows: makes a test for the expected result of the last scan.
    """
    job = replace(subject.job, logic=subject.program.program)

    def find_scan(scenario: RackScenario) -> int | None:
        results = _results(job, scenario, shows)
        return next((scan for scan, is_shown in enumerate(results) if is_shown), None)

    return _replayed(job, subject.problem.lowered.layout, scans, find_scan)


def difference_on_rack(
    job: LoadedRack, old: LadderLogic, layout: Layout, scans: Sequence[ScanOf], key: Key
) -> OnRack | None:
    """Run a scenario on a rack with its program and with an old one; return None if there is no rack.

    Args:
        key: the value that differs after the last scan.
    """
    tag = tag_text(layout, key)

    def find_scan(scenario: RackScenario) -> int | None:
        old_values = _tag_values(replace(job, logic=old), scenario, tag)
        pairs = enumerate(zip(old_values, _tag_values(job, scenario, tag), strict=False))
        return next((scan for scan, (old_value, new_value) in pairs if old_value != new_value), None)

    return _replayed(job, layout, scans, find_scan)


def _replayed(job: LoadedRack, layout: Layout, scans: Sequence[ScanOf], find_scan: FindScan) -> OnRack | None:
    """Run a scenario in up to two variants, until one shows the result; return None without a rack.

    If several scans replace a long scan, inputs change before the last or before the first of them.
    """
    if not job.spec.slot:
        return None
    period_ns = job.spec.scan_ns
    variants = [on_scans_of(layout, scans, period_ns, inputs_first=first) for first in (False, True)]
    if any(model_scan.again for model_scan in scans):
        return OnRack(confirmed=False, scan=None, scenario=variants[0], why=TWO_RUNS)
    why = ""
    for scenario in variants:
        try:
            scan = find_scan(scenario)
        except (ValueError, CpuFault) as error:
            why = str(error)
            continue
        if scan is not None:
            forced = _needed_forces(scenario, find_scan)
            return OnRack(confirmed=True, scan=scan, scenario=scenario, forced=forced)
    if not why and variants[0].left_out:
        why = f"nothing on the rack sets {', '.join(variants[0].left_out)}"
    why = why or f"scans of {time_text(period_ns)} do not show it; a scan of another length does"
    return OnRack(confirmed=False, scan=None, scenario=variants[0], why=why)


def _needed_forces(scenario: RackScenario, find_scan: FindScan) -> tuple[str, ...]:
    """Return the forced words, if the scenario does not show the result without them."""
    if not scenario.forced:
        return ()
    try:
        scan = find_scan(scenario.without_forces())
    except (ValueError, CpuFault):
        scan = None
    return scenario.forced if scan is None else ()


def faults_on_rack(subject: ProofSubject, scans: Sequence[ScanOf]) -> str:
    """Run the scenario of a fault on the subject's rack; return the result as text, "" without a rack."""
    job = subject.job
    if not job.spec.slot:
        return ""
    scenario = on_scans_of(subject.problem.lowered.layout, scans, job.spec.scan_ns)
    if any(scan.again for scan in scans):
        return f"on the rack: {TWO_RUNS}"
    try:
        with ExitStack() as ports:
            _run(job, scenario, ports).run(scenario.scans)
    except CpuFault as error:
        return f"on the rack: the controller faults in scan {error.fault.scan}"
    except ValueError as error:
        return f"on the rack: {error}"
    return "on the rack: the controller does not stop"


class _ScanResults(QuietListener):
    """Calls a function after each scan, and keeps the results."""

    def __init__(self, read: Callable[[], Any]) -> None:
        self._read = read
        self.results: list[Any] = []

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Call the function after a scan."""
        self.results.append(self._read())


def _results(
    job: LoadedRack, scenario: RackScenario, reader: Callable[[Debugger], Callable[[], Any]]
) -> list[Any]:
    """Run a scenario; return the result of a function after each scan.

    Args:
        reader: returns the function for a program.

    Raises:
        ValueError: an operator action can't be applied.
        CpuFault: the controller faults.
    """
    with ExitStack() as ports:
        run = _run(job, scenario, ports)
        assert run.program.debugger is not None
        listener = _ScanResults(reader(run.program.debugger))
        run.cpu.add_listener(listener)
        run.run(scenario.scans)
    if run.repeated is not None and run.repeated.refused:
        raise ValueError(run.repeated.refused[0])
    return listener.results


def _tag_values(job: LoadedRack, scenario: RackScenario, tag: str) -> list[Any]:
    """Run a scenario; return the value of a tag after each scan."""
    return _results(job, scenario, lambda program: lambda: program.tags[tag])


def record(job: LoadedRack, result: OnRack, trace: Path) -> None:
    """Record a confirmed scenario on the rack, running the program without its monitors.

    Raises:
        OSError: the trace can't be written.
    """
    assert result.scan is not None
    with ExitStack() as ports:
        _run(job, result.scenario, ports, trace).run(result.scan + 1 + MORE)


def _run(job: LoadedRack, scenario: RackScenario, ports: ExitStack, trace: Path | None = None) -> JobRun:
    """Return a run that applies a scenario's operator actions, before its first scan."""
    orders = [AppliedAction(scan, order) for scan, order in scenario.orders]
    return JobRun(job, ports, RunOptions(trace=trace, orders=orders, handled=True, keep=0))
