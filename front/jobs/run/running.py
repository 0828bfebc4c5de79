"""A job, run scan by scan and recorded: what `scanrack run` does, without its words.

    with ExitStack() as ports:
        run = JobRun(load_job("line.toml"), ports, trace=Path("line.mcap"))
        run.run(5000)

Errors are exceptions; `cli.run` turns them into messages and an exit status.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager, ExitStack, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

from ...ladder import LadderLogic
from ...runtime.loop.cpu import Cpu
from ...runtime.loop.listeners import ScanListener
from ...runtime.loop.pace import FreeRun, Pacer
from ...runtime.loop.realtime import frozen_collector
from ...runtime.loop.scan import Logic
from ...traces.write.recorder import ScanRecorder
from ..load.loading import Job
from ..record.recording import NOTHING, recorder_for
from ..record.sequence_watch import WatchesSequences, declared_axes, sequences_in, standing
from .build import build_cpu, build_rack
from .hints import Hints
from .outside import tell_cpu

if TYPE_CHECKING:  # imported late: a rack without a session does not need them
    from ...ladder.debug import Debugger
    from ...runtime.live.hands import Hands
    from ...runtime.live.orders import Edit
    from ..record.editions import Editions
    from ..record.repeating import RecordedOrder, Repeated
    from .editing import Edited

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
        repeated: gives the orders of a recorded session; None without them.
        logic: the program; of a rack that can be operated a ladder program is under a debugger.
        debugger: that debugger; None without one.
        hints: what the program may have meant otherwise.
        stubs: the stubs in use, see `Job.stubs`.
        on_edit: called with every edit, between two scans.
        steps: the waits of the program's sequences at the end of the run, a sentence each; none after a
        fault.

    Args:
        job: what to run.
        ports: closes the real ports that are opened.
        trace: path of the recording; None = no recording.
        live: real ports may be driven.
        pacer: makes scans wait for the wall clock; as fast as possible if left out.
        listeners: further listeners.
        warn: takes a hint, at once.
        handled: the rack can be operated while it runs: tags are set and forced, incidents happen.
        metadata: further entries of the recording's metadata.
        keep: how many earlier recordings are kept; None = as the rack file says.
        orders: of a recorded session, given again; the rack can then be operated.
        editions: brings the programs of edits; without them there can be none.

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
        handled: bool = False,
        metadata: Mapping[str, str] = NOTHING,
        keep: int | None = None,
        orders: Iterable[RecordedOrder] | None = None,
        editions: Editions | None = None,
    ) -> None:
        handled = handled or orders is not None
        units = {unit.address: unit.make(job.folder) for unit in job.spec.unit}
        self.stubs = job.stubs
        self.rack = build_rack(job.spec, ports if live else None, handled=handled)
        self.debugger = _debugger_of(job.logic) if handled else None
        self.logic: Logic = self.debugger or job.logic
        self.hints = Hints(self.rack, job.spec, warn, declared_axes(self.logic))
        self.steps: list[str] = []
        heard: list[ScanListener] = [*listeners, self.hints]
        self._editions = editions
        self._edits = 0
        self._followers: list[WatchesSequences] = []
        self.on_edit: Callable[[Edited], object] = lambda _edited: None
        recording: list[ScanListener] = []
        drafts: list[Callable[[], object]] = []
        if trace is not None:
            recorder = recorder_for(
                job,
                self.rack,
                trace,
                self.logic,
                orders=handled,
                sequences=self._may_be_edited,
                metadata=metadata,
                keep=keep,
                warn=warn,
            )
            drafts.append(recorder.draft_soon)
            recording.append(self.following(self._with_edits(recorder)))
        if units:
            from .rack_units import UnitsBeside  # the controllers take time to import

            beside = UnitsBeside(units, trace)
            drafts.append(beside.draft)
            heard.append(beside)
        heard += recording  # closed last: its end looks at all files of the recording
        self._pacer = pacer or FreeRun()
        self._pacer.beat = lambda: [each() for each in drafts]
        self.cpu = build_cpu(job.spec, self.logic, self.rack, listeners=heard, pacer=self._pacer)
        if self.debugger is not None:
            tell_cpu(self.debugger, self.cpu)
        self.repeated: Repeated | None = None
        if orders is not None:
            from ..record.repeating import Repeated

            self.repeated = Repeated(self.cpu, self.hands, orders)
            self.cpu.add_listener(self.repeated)
            self.repeated.begin()

    @property
    def edits(self) -> int:
        """How often the program was edited while it ran."""
        return self._edits if self.debugger is None else len(self.debugger.edits)

    def use(self, logic: Logic) -> None:
        """Go on with another program that is not a ladder program, from the next scan on."""
        self.logic = self.cpu.program = logic
        self._edits += 1
        for each in self._followers:
            each.watch(sequences_in(logic))

    @property
    def hands(self) -> Hands:
        """Carries out orders on the rack; tags only of a program under a debugger."""
        from ...runtime.live.hands import Hands

        return Hands(self.cpu, self.rack, self.debugger, None if self._editions is None else self._edit)

    def _with_edits(self, recorder: ScanRecorder) -> ScanListener:
        """Return a recorder that attaches the files of edits, if there may be some."""
        if self._editions is None:
            return recorder
        from .editing import RecordsEdits

        return RecordsEdits(recorder, self._editions)

    def following(self, listener: ScanListener) -> ScanListener:
        """Return a listener that also gets the sequences of the program, those of an edited one, too."""
        sequences = sequences_in(self.logic)
        if not self._may_be_edited and not sequences:
            return listener
        self._followers.append(WatchesSequences(listener, sequences))
        return self._followers[-1]

    @property
    def _may_be_edited(self) -> bool:
        """Whether the program is in Python, and another one may take its place."""
        return self._editions is not None and self.debugger is None

    def _edit(self, order: Edit, at_ns: int) -> None:
        from .editing import edit

        assert self._editions is not None
        self.on_edit(edit(self, self._editions, order, at_ns))

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
            self.steps = [str(standing(each, cpu.scan)) for each in sequences_in(self.logic)]


def _debugger_of(logic: Logic) -> Debugger | None:
    """Return a debugger that runs a ladder program and remembers little; None for other logic."""
    if not isinstance(logic, LadderLogic):
        return None
    from ...ladder.debug import Debugger

    return Debugger(logic, remembered=0)
