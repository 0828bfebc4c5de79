"""A job, run scan by scan and recorded: what `scanrack run` does, without its words.

    with ExitStack() as ports:
        run = JobRun(load_job("line.toml"), ports, trace=Path("line.mcap"))
        run.run(5000)

Errors are exceptions; `cli.run` turns them into messages and an exit status.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager, ExitStack, nullcontext
from pathlib import Path

from ..loop.cpu import Cpu
from ..loop.listeners import ScanListener
from ..loop.pace import FreeRun, Pacer
from ..loop.realtime import frozen_collector
from .build import build_cpu, build_rack
from .hints import Hints
from .loading import Job
from .rack_units import UnitsBeside, units_of
from .recording import recorder_for

Observer = Callable[[Cpu, int | None], AbstractContextManager[None]]
"""Observes a CPU while it runs: a progress bar. Arguments: the CPU, the number of its last scan or None."""


def unobserved(cpu: Cpu, scans: int | None) -> AbstractContextManager[None]:
    """Run without an observer."""
    return nullcontext()


class JobRun:
    """A job on a new rack, powered up and not yet scanned.

    Attributes:
        rack: the rack.
        cpu: the CPU that runs the program.
        hints: what the program may have meant otherwise.
        stubs: the stubs in use, see `Job.stubs`.

    Args:
        job: what to run.
        ports: closes the real ports that are opened.
        trace: path of the recording; None = no recording.
        live: real ports may be driven.
        pacer: makes scans wait for the wall clock; as fast as possible if left out.
        listeners: further listeners.
        warn: takes a hint, at once.

    Raises:
        ValueError: a unit's program or a port can't be used, or a real port is not allowed.
        OSError: the trace can't be written.
    """

    def __init__(
        self,
        job: Job,
        ports: ExitStack,
        *,
        trace: Path | None = None,
        live: bool = False,
        pacer: Pacer | None = None,
        listeners: Iterable[ScanListener] = (),
        warn: Callable[[str], None] = lambda _hint: None,
    ) -> None:
        units = units_of(job.spec.unit, job.folder)
        self.stubs = job.stubs
        self.rack = build_rack(job.spec, ports if live else None)
        self.hints = Hints(self.rack, job.spec, warn)
        heard: list[ScanListener] = [*listeners, self.hints]
        if trace is not None:
            heard.append(recorder_for(job, self.rack, trace))
        if units:
            heard.append(UnitsBeside(units, trace))
        self._pacer = pacer or FreeRun()
        self.cpu = build_cpu(job.spec, job.logic, self.rack, listeners=heard, pacer=self._pacer)

    def run(self, scans: int | None = None, *, observed: Observer = unobserved) -> None:
        """Run to the end, or until Ctrl-C stops the CPU between scans; then close the listeners.

        Args:
            scans: how many scans; None = until Ctrl-C.
            observed: observes the CPU meanwhile.

        Raises:
            CpuFault: the program, a module or a listener failed.
            OSError: the trace can't be finished.
            KeyboardInterrupt: a second Ctrl-C.
        """
        cpu = self.cpu
        with (
            nullcontext() if self._pacer.free else frozen_collector(),
            cpu.stopping_on_ctrl_c(),
            cpu,
            observed(cpu, scans),
        ):
            cpu.run(scans)
