"""The phases of a scan, in their order, each a short method.

    scan n            phase            in mode           what it does
    at n * period     input_latch      all               modules come up to now, their inputs are taken
                      input_forces     all               forced input bits are put over them
                      logic            run, test         the program is called once
                      output_forces    run, test         forced output bits are put over its outputs
                      output_latch     run               outputs are sent to the modules
                      record           all               listeners hear of events, then of the scan
                      housekeeping     all               requests take effect, time moves on

Scan 0 is at t = 0 and sees the modules as they power up. A scan takes no virtual
time: what it does happens at its instant.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping

from .events import Event, JsonValue
from .exchange import Exchange
from .faults import Cause
from .forces import Forces
from .listeners import Listeners, ScanListener
from .pace import Pacer, Watchdog
from .rack import Rack
from .scan import CpuMode, Logic, Scan, ScanFlag

PHASES = (
    "input_latch",
    "input_forces",
    "logic",
    "output_forces",
    "output_latch",
    "record",
    "housekeeping",
)
"""The phases of a scan in order; each is a method of the CPU."""

Phase = Callable[[], None]

IDLE_PHASES = {
    CpuMode.PROGRAM: frozenset({"logic", "output_forces", "output_latch"}),
    CpuMode.RUN: frozenset[str](),
    CpuMode.TEST: frozenset({"output_latch"}),
    CpuMode.SINGLE_SCAN: frozenset({"output_latch"}),
}
"""By mode: the phases that are left out."""


class ScanPhases(ABC):
    """What a scan consists of.

    The list of phases that have something to do is prepared again whenever that changes
    (`_prepare`), so that a scan without forces does not ask about forces. `_plain` scans have nothing
    to do but the input latch, the logic, the output latch, record and housekeeping.
    """

    def __init__(
        self,
        rack: Rack,
        logic: Logic,
        period_ns: int,
        *,
        exchange: Exchange,
        listeners: Iterable[ScanListener],
        pacer: Pacer,
        watchdog: Watchdog,
    ) -> None:
        self.rack = rack
        self.program = logic
        self._period_ns = period_ns
        self.pacer = pacer
        self.forces = Forces(rack, self._ask_for_attention)
        self._exchange = exchange
        self._exchange.attach(rack)
        self._listeners = Listeners(listeners)
        self._watchdog = watchdog
        self._modules = tuple(slot.module for slot in rack.slots.values())
        self._modules_run = True
        self._view = Scan(rack.slots, period_ns)
        self._flags = self._scan_flags = 0
        self._news: dict[str, Mapping[str, JsonValue]] = {}
        self._announced: list[Event] = []
        self._tag_forces: Mapping[str, str | int | float | bool] = {}
        self._tags_set_before = -1  # the scan before which a tag was set from outside
        self._attention = False
        self._plain = False
        self._call_logic: Phase = self.logic
        self._phases: tuple[Phase, ...] = ()
        self._blame: Mapping[Phase, Cause] = {}

    @property
    def period_ns(self) -> int:
        """Time from scan to scan."""
        return self._period_ns

    def input_latch(self) -> None:
        """Bring the modules up to now and take their inputs."""
        self._view.updated = self._exchange.latch_inputs(self._view.now_ns)

    def input_forces(self) -> None:
        """Give the logic its own outputs back, and put the input forces over the inputs."""
        self.forces.restore_outputs()
        self.forces.apply_inputs()

    def logic(self) -> None:
        """Call the program."""
        self.program(self._view)

    def output_forces(self) -> None:
        """Put the output forces over what the program wrote."""
        self.forces.apply_outputs()

    def output_latch(self) -> None:
        """Send the outputs to the modules."""
        self._exchange.latch_outputs()

    def record(self) -> None:
        """Tell the listeners what happened and that the scan is done."""
        view = self._view
        for module in self._modules:
            if module.events:
                self._listeners.module_events(view.number, self.rack.slots.values())
                break
        self._listeners.scan(view.number, view.now_ns, self._scan_flags)

    def housekeeping(self) -> None:
        """Let requests take effect, and move on to the next scan."""
        if self._attention:
            self._attend()
        view = self._view
        view.number += 1
        view.now_ns += self._period_ns

    @abstractmethod
    def _ask_for_attention(self) -> None:
        """Have requests served by the housekeeping of the present scan, or now if there is none."""

    @property
    @abstractmethod
    def _next_scan(self) -> int:
        """Number of the scan in which a request that is made now takes effect."""

    @abstractmethod
    def _attend(self) -> None:
        """End what was special about this scan, and serve requests."""

    # phases of special occasions

    def _pace(self) -> None:
        """Wait for the wall clock, before the scan."""
        self._scan_flags = self._flags | ScanFlag.OVERRUN if self.pacer.wait() else self._flags

    def _timed_logic(self) -> None:
        """Call the program where no timer can end it."""
        self._watchdog.call(self.logic)

    def _first_output_latch(self) -> None:
        """Send the outputs, and with them the news that the PLC runs."""
        self._exchange.latch_outputs()
        self._exchange.start()
        self._modules_run = True

    def _tell_news(self) -> None:
        """Tell the listeners what has taken effect with this scan."""
        for topic, fields in self._news.items():
            self._listeners.event(self._view.number, self._view.now_ns, topic, fields)
        self._news.clear()
        for event in self._announced:
            self._listeners.raised(self._view.number, event)
        self._announced.clear()

    def _prepare(self, mode: CpuMode) -> None:
        """List the phases that have something to do in the next scan, and the cause of an error in each."""
        idle = IDLE_PHASES[mode]
        logic_runs = "logic" not in idle
        first = logic_runs and self._view.first
        starting = mode is CpuMode.RUN and not self._modules_run
        news = bool(self._news or self._announced)
        forced_in, forced_out = self.forces.on_inputs, logic_runs and self.forces.on_outputs
        call_logic = self._call_logic = self._timed_logic if self._watchdog.timed else self.logic
        send = self._first_output_latch if starting else self.output_latch
        plan: tuple[tuple[bool, Phase, Cause], ...] = (
            (not self.pacer.free, self._pace, Cause.MODULE),
            (True, self.input_latch, Cause.MODULE),
            (forced_in or forced_out, self.input_forces, Cause.MODULE),
            (logic_runs, call_logic, Cause.PROGRAM),
            (forced_out, self.output_forces, Cause.MODULE),
            ("output_latch" not in idle, send, Cause.MODULE),
            (news, self._tell_news, Cause.LISTENER),
            (True, self.record, Cause.LISTENER),
            (True, self.housekeeping, Cause.MODULE),
        )
        self._phases = tuple(phase for needed, phase, _ in plan if needed)
        self._blame = {phase: cause for needed, phase, cause in plan if needed}
        set_before = self._tags_set_before == self._next_scan
        outside = set_before or bool(self._tag_forces)
        self._flags = self._scan_flags = _flags(mode, first, forced_in, forced_out, outside)
        if first or starting or news or set_before or mode is CpuMode.SINGLE_SCAN:
            self._attention = True
        special = self._attention or forced_in or forced_out
        self._plain = mode is CpuMode.RUN and self.pacer.free and not special


def _flags(mode: CpuMode, first: bool, forced_in: bool, forced_out: bool, outside: bool) -> int:
    return (
        mode.value
        | first * ScanFlag.FIRST_SCAN.value
        | forced_in * ScanFlag.INPUT_FORCES.value
        | forced_out * ScanFlag.OUTPUT_FORCES.value
        | outside * ScanFlag.TAGS_FROM_OUTSIDE.value
    )
