"""A scenario on the rack, with the models of its modules.

The program with its monitors runs first, to find the scan that breaks the claim; then as it is, recorded, so
that `scanrack watch` and `scanrack why` open the recording. Words of modules are forced. If a run without
these forces breaks the claim, too, the modules themselves give these inputs.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path

from ...ladder.debug import Debugger
from ...ladder.prove.monitors import WatchedClaim
from ...ladder.prove.replaying import ScanOf
from ...runtime.live.hands import GivenOrder
from ...runtime.loop.faults import CpuFault
from ...runtime.loop.listeners import QuietListener
from ..load.loading import Job
from ..run.running import JobRun, RunOptions
from .scenario import RackScenario, on_scans_of
from .subject import ProofSubject

MORE = 5
"""Recorded scans after the one that breaks the claim."""


@dataclass(frozen=True, slots=True)
class OnRack:
    """What a scenario did on the rack.

    Attributes:
        confirmed: whether the claim was broken.
        scan: number of the scan that broke it, from 0; None if none did.
        scenario: the orders.
        forced: words that modules were forced to show, and that they do not show by themselves.
        why: why it was not broken, or could not be run.
    """

    confirmed: bool
    scan: int | None
    scenario: RackScenario
    forced: tuple[str, ...] = ()
    why: str = ""

    def __str__(self) -> str:
        if not self.confirmed:
            return f"on the rack: {self.why}"
        said = f"on the rack: scan {self.scan}"
        if not self.forced:
            return f"{said}, as its modules answer"
        return (
            f"{said} with {', '.join(self.forced)} forced: the models of the modules do not give these inputs"
        )


def replay_on_rack(subject: ProofSubject, asked: WatchedClaim, scans: Sequence[ScanOf]) -> OnRack | None:
    """Run a scenario on the subject's rack; None without a rack."""
    job = subject.job
    if not job.spec.slot:
        return None
    layout, period_ns = subject.problem.lowered.layout, job.spec.scan_ns
    tried = [on_scans_of(layout, scans, period_ns, inputs_first=first) for first in (False, True)]
    why = ""
    for scenario in tried:
        try:
            scan = _broken_in(subject, asked, scenario)
        except (ValueError, CpuFault) as error:
            why = str(error)
            continue
        if scan is not None:
            return OnRack(True, scan, scenario, _not_given(subject, asked, scenario))
    if not why and tried[0].left_out:
        why = f"nothing sets {', '.join(tried[0].left_out)} there"
    ms = f"{period_ns / 1e6:g} ms"
    return OnRack(
        False, None, tried[0], why=why or f"scans of {ms} do not break it; one of another length does"
    )


def faults_on_rack(subject: ProofSubject, scans: Sequence[ScanOf]) -> str:
    """Run the scenario of a fault on the subject's rack; return what became of it, "" without a rack."""
    job = subject.job
    if not job.spec.slot:
        return ""
    scenario = on_scans_of(subject.problem.lowered.layout, scans, job.spec.scan_ns)
    try:
        with ExitStack() as ports:
            _run(job, scenario, ports).run(scenario.scans)
    except CpuFault as error:
        return f"on the rack: the CPU faults in scan {error.fault.scan}"
    except ValueError as error:
        return f"on the rack: {error}"
    return "on the rack: the CPU does not stop"


def _not_given(subject: ProofSubject, asked: WatchedClaim, scenario: RackScenario) -> tuple[str, ...]:
    """Return the forced words without which the modules do not break the claim."""
    if not scenario.forced:
        return ()
    try:
        alone = _broken_in(subject, asked, scenario.without_forces())
    except (ValueError, CpuFault):
        alone = None
    return scenario.forced if alone is None else ()


class _Looker(QuietListener):
    """Notes the first scan after which a claim is broken; its assumptions have held until then."""

    def __init__(self, program: Debugger, subject: ProofSubject, asked: WatchedClaim) -> None:
        self._program, self._bit = program, asked.bit[0]
        self._assumed = [name for name, _ in (*subject.program.assume, *asked.assume)]
        self._holds = True
        self.broken: int | None = None

    def scan(self, scan: int, now_ns: int, flags: int) -> None:
        """Look at the bits after a scan."""
        tags = self._program.tags
        self._holds = self._holds and all(tags[name] for name in self._assumed)
        if self.broken is None and self._holds and tags[self._bit]:
            self.broken = scan


def _broken_in(subject: ProofSubject, asked: WatchedClaim, scenario: RackScenario) -> int | None:
    """Return the scan that breaks a claim; a ValueError for an order that can't be carried out."""
    job = replace(subject.job, logic=subject.program.program)
    with ExitStack() as ports:
        run = _run(job, scenario, ports)
        assert run.program.debugger is not None
        looker = _Looker(run.program.debugger, subject, asked)
        run.cpu.add_listener(looker)
        run.run(scenario.scans)
    if run.repeated is not None and run.repeated.refused:
        raise ValueError(run.repeated.refused[0])
    return looker.broken


def record(job: Job, found: OnRack, trace: Path) -> None:
    """Record a scenario on the rack with its program as it is.

    Raises:
        OSError: the trace can't be written.
    """
    assert found.scan is not None
    with ExitStack() as ports:
        _run(job, found.scenario, ports, trace).run(found.scan + 1 + MORE)


def _run(job: Job, scenario: RackScenario, ports: ExitStack, trace: Path | None = None) -> JobRun:
    orders = [GivenOrder(scan, order) for scan, order in scenario.orders]
    return JobRun(job, ports, RunOptions(trace=trace, orders=orders, handled=True, keep=0))
