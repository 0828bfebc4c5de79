"""Runs and records a job scan by scan: the work of `scanrack run`, without its messages.

    with ExitStack() as ports:
        run = JobRun(load_job("line.toml"), ports, RunOptions(trace=Path("line.mcap")))
        run.run(5000)

Errors are exceptions; `commands.programs.run` turns them into messages and an exit status.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager, ExitStack, nullcontext
from dataclasses import field
from pathlib import Path
from typing import TYPE_CHECKING

from scanrack.io_images.dataclass import dataclass
from scanrack.runtime.loop.cpu import Cpu
from scanrack.runtime.loop.listeners import ScanListener
from scanrack.runtime.loop.pace import FreeRun, Pacer
from scanrack.traces.write.recorder import ScanRecorder

from ..load.building import build_cpu, build_rack
from ..load.loading import LoadedRack
from ..record.recording import recorder_for
from ..record.sequence_watch import declared_axes, wait_of, waiting_in
from .editing import RunProgram
from .external_tags import report_external_tags
from .hints import Hints

if TYPE_CHECKING:  # imported late, since the controllers of units take time to import
    from scanrack.runtime.controllers.pcl601.line import Pcl601
    from scanrack.runtime.live.actions import Force
    from scanrack.runtime.live.operator_actions import OperatorActions

    from ..record.order_repeater import OrderRepeater, RecordedOrder
    from ..record.program_versions import ProgramVersions
    from .rack_units import UnitsBeside

Observer = Callable[[Cpu, int | None], AbstractContextManager[None]]
"""Observes a running CPU, like a progress bar. Arguments: the CPU, and its last scan's number or None."""


def unobserved(cpu: Cpu, scans: int | None) -> AbstractContextManager[None]:
    """Run without an observer."""
    return nullcontext()


@dataclass(frozen=True, slots=True)
class RunOptions:
    """The options of a run."""

    trace: Path | None = None  # path of the recording; None = no recording
    live: bool = False  # whether real ports may be driven
    pacer: Pacer | None = None  # makes scans wait for the wall clock; None = as fast as possible
    listeners: Iterable[ScanListener] = ()
    warn: Callable[[str], object] = lambda _hint: None  # receives hints and warnings
    handled: bool = False  # whether the rack can be operated: tags set and forced, faults injected
    metadata: Mapping[str, str] = field(default_factory=dict)
    keep: int | None = None  # number of earlier recordings to keep; None = as in the rack file
    orders: Iterable[RecordedOrder] | None = None  # operator actions of a recorded session to repeat
    forces: tuple[Force, ...] = ()  # forces of tags and images from the first scan
    editions: ProgramVersions | None = None  # loads the programs of edits; None without edits
    remembered: int = 0  # number of snapshots of a ladder program; see `Debugger`


AS_IT_IS = RunOptions()


class JobRun:
    """A job on a new rack, powered up before its first scan.

    Attributes:
        program: the program, which edits replace.
        hints: collects hints about ignored actions.
        repeated: repeats the operator actions of a recorded session; None without such actions.
        stubs: the stubs in use, see `LoadedRack.stubs`.
        steps: sentences about the waits of the program's sequences at the end; empty after a fault.

    Args:
        ports: stack that closes the real ports opened here.

    Raises:
        ValueError: a unit's program or a port can't be used, or a real port is not allowed.
        OSError: the trace can't be written.
    """

    def __init__(self, job: LoadedRack, ports: ExitStack, options: RunOptions = AS_IT_IS) -> None:
        """Power up the rack with its listeners, and apply forces and recorded actions before scan 0."""
        handled = options.handled or options.orders is not None or bool(options.forces)
        units = {unit.address: unit.make(job.folder) for unit in job.spec.unit}
        self.stubs = job.stubs
        self.rack = build_rack(job.spec, ports if options.live else None, handled=handled)
        self.program = RunProgram(
            job.logic, handled=handled, editions=options.editions, remembered=options.remembered
        )
        self.hints = Hints(self.rack, job.spec, options.warn, declared_axes(self.program.logic))
        self.steps: list[str] = []
        listeners: list[ScanListener] = [*options.listeners, self.hints]
        # The recorder first: it keeps or refuses the earlier recordings of the rack and of its units.
        recorder = None if options.trace is None else self._recorder(job, options.trace, options, handled)
        units_beside = _units_beside(units, options.trace)
        recorded = None if recorder is None else self.program.recorded(recorder)
        listeners += filter(None, (units_beside, recorded))  # the recorder is closed last: it reads all files
        self._pacer = options.pacer or FreeRun()
        self._pacer.beat = lambda: _write_drafts(recorder, units_beside)
        self.cpu = build_cpu(job.spec, self.program.logic, self.rack, listeners=listeners, pacer=self._pacer)
        if self.program.operated is not None:
            report_external_tags(self.program.operated, self.cpu)
        self._apply_forces(options)
        self.repeated: OrderRepeater | None = None
        if options.orders is not None:
            self._repeat_orders(options.orders)

    def _repeat_orders(self, orders: Iterable[RecordedOrder]) -> None:
        """Add a last listener that repeats recorded actions, and apply the actions before scan 0."""
        from ..record.order_repeater import OrderRepeater

        self.repeated = OrderRepeater(self.cpu, self.hands, orders)
        self.cpu.add_listener(self.repeated)
        self.repeated.begin()

    def _apply_forces(self, options: RunOptions) -> None:
        """Apply the forces; warn about forces that can't be applied."""
        for order in options.forces:
            try:
                self.hands.act(order, 0, 0)
            except ValueError as error:
                options.warn(f"a force is not applied: {error}")

    def _recorder(self, job: LoadedRack, trace: Path, options: RunOptions, handled: bool) -> ScanRecorder:
        """Return a recorder of the run; it also records operator actions if the rack is operated."""
        return recorder_for(
            job,
            self.rack,
            trace,
            self.program.logic,
            orders=handled,
            sequences=self.program.may_bring_sequences,
            metadata=options.metadata,
            keep=options.keep,
            warn=options.warn,
        )

    @property
    def hands(self) -> OperatorActions:
        """The executor of operator actions on the rack, see `RunProgram.hands`."""
        return self.program.hands(self.cpu, self.rack)

    def run(self, scans: int | None = None, *, observed: Observer = unobserved) -> None:
        """Run to the end, or until Ctrl-C stops the CPU between scans; then close the listeners.

        Args:
            scans: number of scans; None = until Ctrl-C.

        Raises:
            CpuFault: the program, a module or a listener failed.
            OSError: the trace can't be finished.
            KeyboardInterrupt: a second Ctrl-C.
        """
        cpu = self.cpu
        with (
            nullcontext() if self._pacer.free else _frozen_collector(),
            cpu.stopping_on_ctrl_c(),
            cpu,
            observed(cpu, scans),
        ):
            cpu.run(scans)
            self.steps = [str(wait_of(sequence, cpu.scan)) for sequence in waiting_in(self.program.logic)]


def _frozen_collector() -> AbstractContextManager[None]:
    from scanrack.runtime.loop.realtime import frozen_collector

    return frozen_collector()


def _units_beside(units: Mapping[int, Pcl601], trace: Path | None) -> UnitsBeside | None:
    """Return a listener that runs the units on the rack's serial line; None without units."""
    if not units:
        return None
    from .rack_units import UnitsBeside

    return UnitsBeside(units, trace)


def _write_drafts(recorder: ScanRecorder | None, units_beside: UnitsBeside | None) -> None:
    if recorder is not None:
        recorder.draft_soon()
    if units_beside is not None:
        units_beside.draft()
