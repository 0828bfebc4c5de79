"""The phases of a scan, in order; each is a short method.

    scan n            phase            in mode           action
    at n * period     input_latch      all               update the modules, read their inputs
                      input_forces     all               overwrite forced input bits
                      logic            run, test         call the program once
                      output_forces    run, test         overwrite forced output bits
                      output_latch     run               send the outputs to the modules
                      record           all               pass events, and then the scan, to the listeners
                      housekeeping     all               apply requests, advance the time

Scan 0 is at t = 0, when the modules have just powered up. A scan takes no virtual
time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from .events import Event, JsonValue
from .exchange import Exchange
from .faults import Cause
from .forces import Forces
from .listeners import Listeners
from .pace import Pacer, Watchdog
from .rack import Rack
from .scan import MODE_MASK, CpuMode, LogicScan, ScanFlag, ScanLogic

PHASES = (
    "input_latch",
    "input_forces",
    "logic",
    "output_forces",
    "output_latch",
    "record",
    "housekeeping",
)
"""The phases of a scan in order; each is a method of `ScanPhases`, except the last, a method of the CPU."""

Phase = Callable[[], None]

IDLE_PHASES = {
    CpuMode.PROGRAM: frozenset({"logic", "output_forces", "output_latch"}),
    CpuMode.RUN: frozenset[str](),
    CpuMode.TEST: frozenset({"output_latch"}),
    CpuMode.SINGLE_SCAN: frozenset({"output_latch"}),
}
"""The phases that are skipped in each mode."""

_LOGIC_RUNS = tuple("logic" not in IDLE_PHASES[mode] for mode in sorted(CpuMode))


def runs_logic(flags: int) -> bool:
    """Return whether the logic runs in a scan with these flags."""
    return _LOGIC_RUNS[flags & MODE_MASK]


class ScanPhases:
    """The phases of a scan, and the list of those that are active in the next scan.

    `prepare` rebuilds the list after every change, so a scan without forces does not have to check for
    forces.

    Attributes:
        order: the active phases.
        blame: the part of the system to blame for an error in each active phase.
        attention: whether the housekeeping of this scan must apply requests.
        plain: whether only the input latch, logic, output latch, record and housekeeping phases are active.
        after_logic: the last three of these phases.
    """

    def __init__(
        self,
        rack: Rack,
        logic: ScanLogic,
        period_ns: int,
        *,
        exchange: Exchange,
        listeners: Listeners,
        pacer: Pacer,
        watchdog: Watchdog,
        forces: Forces,
        housekeeping: Phase,
    ) -> None:
        self.program = logic
        self.view = LogicScan(rack.slots, period_ns)
        self.listeners = listeners
        self.housekeeping = housekeeping
        self.order: tuple[Phase, ...] = ()
        self.blame: Mapping[Phase, Cause] = {}
        self.flags = self._prepared_flags = 0
        self.call_logic: Phase = self.logic
        self.attention = self.plain = False
        self._planned_for: tuple[object, ...] = ()  # the state for which `order` was made
        self.after_logic: tuple[Phase, ...] = (self.output_latch, self.record, housekeeping)
        self._rack, self._exchange, self._forces = rack, exchange, forces
        self._pacer, self._watchdog = pacer, watchdog
        self._modules = tuple(slot.module for slot in rack.slots.values())
        self._modules_run = True
        self._changes: dict[str, Mapping[str, JsonValue]] = {}
        self._announced: list[Event] = []

    def input_latch(self) -> None:
        """Advance the modules to the current instant and read their inputs."""
        self.view.updated = self._exchange.latch_inputs(self.view.now_ns)

    def input_forces(self) -> None:
        """Restore the logic's own outputs, and overwrite the inputs with the input forces."""
        self._forces.restore_outputs()
        self._forces.apply_inputs()

    def logic(self) -> None:
        """Call the program."""
        self.program(self.view)

    def output_forces(self) -> None:
        """Overwrite the program's outputs with the output forces."""
        self._forces.apply_outputs()

    def output_latch(self) -> None:
        """Send the outputs to the modules."""
        self._exchange.latch_outputs()

    def record(self) -> None:
        """Pass the events to the listeners, and then the scan."""
        view = self.view
        for module in self._modules:
            if module.events:
                self.report_module_events()
                break
        self.listeners.scan(view.number, view.now_ns, self.flags)

    # scans by rows

    def rows_at_once(self) -> int:
        """Return how many scans can be passed on together; 0 = each one separately."""
        return 0 if self._watchdog.timed else self.listeners.begin_rows(self.view.number)

    # phases of special scans

    def _pace(self) -> None:
        """Wait until the scan is due, and flag it if it is late."""
        is_late = self._pacer.wait()
        self.flags = self._prepared_flags | ScanFlag.OVERRUN if is_late else self._prepared_flags

    def _timed_logic(self) -> None:
        """Call the program and measure its time, since no timer can end it here."""
        self._watchdog.call(self.logic)

    def _first_output_latch(self) -> None:
        """Send the outputs, and inform the modules that the PLC is running."""
        self._exchange.latch_outputs()
        self._exchange.start()
        self._modules_run = True

    def report_changes(self) -> None:
        """Report the changes that took effect with this scan."""
        for topic, fields in self._changes.items():
            self.listeners.event(self.view.number, self.view.now_ns, topic, fields)
        self._changes.clear()
        for event in self._announced:
            self.listeners.raised(self.view.number, event)
        self._announced.clear()

    # requests of the CPU

    def report_module_events(self) -> None:
        """Pass the modules' events to the listeners."""
        self.listeners.module_events(self.view.number, self._rack.slots.values())

    def report_change(self, topic: str, fields: Mapping[str, JsonValue]) -> None:
        """Report a CPU change to listeners with the next scan; only the latest per topic is reported."""
        self._changes[topic] = fields

    def announce(self, event: Event) -> None:
        """Pass an event to the listeners with the next scan."""
        self._announced.append(event)

    def exchange_early(self) -> bool:
        """In this scan, carry out the exchange before the next scan; return whether one is due."""
        due = self._exchange.exchange_early(self.view.now_ns + self.view.period_ns)
        if due and self._forces.on_inputs:
            self._forces.apply_inputs()
        return due

    def stop_modules(self) -> None:
        """Inform the modules that the PLC is no longer running; do nothing if it was not running."""
        if self._modules_run:
            self._modules_run = False
            self._exchange.stop()

    def drop_outputs(self) -> None:
        """Send zeros, and stop the modules."""
        for slot in self._rack.slots.values():
            slot.outputs.clear()
        self._exchange.latch_outputs()
        self.stop_modules()

    def prepare(self, mode: CpuMode, *, tags_set: bool, tags_forced: bool) -> None:
        """List the active phases of the next scan, and the part to blame for an error in each phase."""
        logic_runs = "logic" not in IDLE_PHASES[mode]
        is_first = logic_runs and self.view.first
        has_changes = bool(self._changes or self._announced)
        forced_in, forced_out = self._forces.on_inputs, logic_runs and self._forces.on_outputs
        starting = mode is CpuMode.RUN and not self._modules_run
        state = (mode, starting, has_changes, forced_in, forced_out, self._watchdog.timed, self._pacer.free)
        if state != self._planned_for:  # a new list costs more than a short scan
            self._planned_for = state
            self.call_logic = self._timed_logic if self._watchdog.timed else self.logic
            plan = self._plan(mode, starting, has_changes, forced_in, forced_out)
            self.blame = {phase: cause for is_active, phase, cause in plan if is_active}
            self.order = tuple(self.blame)
        self.flags = self._prepared_flags = _flags(
            mode, is_first, forced_in, forced_out, tags_set or tags_forced
        )
        self.attention = any(
            (self.attention, is_first, starting, has_changes, tags_set, mode is CpuMode.SINGLE_SCAN)
        )
        special = any((self.attention, forced_in, forced_out))
        self.plain = mode is CpuMode.RUN and self._pacer.free and not special

    def _plan(
        self, mode: CpuMode, starting: bool, has_changes: bool, forced_in: bool, forced_out: bool
    ) -> Iterator[tuple[bool, Phase, Cause]]:
        """For each phase in order, yield whether it is active, the phase, and the cause of its errors."""
        idle = IDLE_PHASES[mode]
        yield not self._pacer.free, self._pace, Cause.MODULE
        yield True, self.input_latch, Cause.MODULE
        yield forced_in or forced_out, self.input_forces, Cause.MODULE
        yield "logic" not in idle, self.call_logic, Cause.PROGRAM
        yield forced_out, self.output_forces, Cause.MODULE
        output_latch = self._first_output_latch if starting else self.output_latch
        yield "output_latch" not in idle, output_latch, Cause.MODULE
        yield has_changes, self.report_changes, Cause.LISTENER
        yield True, self.record, Cause.LISTENER
        yield True, self.housekeeping, Cause.MODULE


def _flags(mode: CpuMode, first: bool, forced_in: bool, forced_out: bool, outside: bool) -> int:
    """Return the flags of a scan: its mode, and a bit for each condition that applies."""
    flags = mode.value
    if first:
        flags |= ScanFlag.FIRST_SCAN.value
    if forced_in:
        flags |= ScanFlag.INPUT_FORCES.value
    if forced_out:
        flags |= ScanFlag.OUTPUT_FORCES.value
    if outside:
        flags |= ScanFlag.TAGS_FROM_OUTSIDE.value
    return flags
