"""The CPU, which runs scans in virtual time, changes modes, and shuts down in order.

The phases of a scan are in `runtime.loop.phases`. A request made during a scan (such as a mode or a force)
takes effect after that scan. The next scan is the first one that shows the change, and the listeners receive
the change with that scan.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import AbstractContextManager, ExitStack
from types import TracebackType
from typing import NoReturn, Self

from scanrack.io_images.site import NOWHERE, sites_of

from .events import Event, JsonValue
from .exchange import EndOfScan, Exchange
from .faults import Cause, CpuFault, Fault, ends_the_run, place_of, words_of
from .forces import Forces
from .listeners import Listeners, ScanListener
from .pace import FreeRun, Pacer, Watchdog, WatchdogTimeout, stopping_on_interrupt
from .phases import IDLE_PHASES, PHASES, Phase, ScanPhases
from .rack import Rack
from .scan import CpuMode, LogicScan, ScanFlag, ScanLogic, attached, mode_name
from .scans_ahead import LOGIC_CALLERS, RepeatFinder, ScansAhead

__all__ = ["PHASES", "Cpu", "CpuFault", "CpuMode", "Fault", "LogicScan", "ScanFlag", "ScanLogic"]

PERIOD_NS = 2_000_000
"""Default time from one scan to the next, ns."""

ENDLESS = 1 << 62
"""Number of scans of a run without a limit."""


class Cpu:
    """A controller's CPU that runs logic on a rack, scan by scan.

    Use the CPU as a context manager, or call `close` at the end; either closes the listeners.

    Args:
        rack: modules in their slots, just powered up.
        logic: called once per scan with the `LogicScan`.
        period_ns: time from one scan to the next, at least 1 ns.
        exchange: the exchange of images across the backplane; by default it takes place in every scan, as on
            a MicroLogix.
        listeners: called after every scan, in this order.
        pacer: makes scans wait for the wall clock; by default, scans run as fast as possible.
        watchdog: ends endless logic, by default after 500 ms.

    Raises:
        ValueError: the period is not positive, or the rack lacks a slot that the logic needs.
    """

    def __init__(
        self,
        rack: Rack,
        logic: ScanLogic,
        period_ns: int = PERIOD_NS,
        *,
        exchange: Exchange | None = None,
        mode: CpuMode = CpuMode.RUN,
        listeners: Iterable[ScanListener] = (),
        pacer: Pacer | None = None,
        watchdog: Watchdog | None = None,
    ) -> None:
        if period_ns < 1:
            raise ValueError(f"scan period of {period_ns} ns: must be at least 1 ns")
        self.rack, self.period_ns = rack, period_ns
        self.pacer = pacer or FreeRun()  # makes scans wait, and counts late scans as overruns
        self.forces = Forces(rack, self._ask_for_attention)  # changes take effect with the next scan
        self.fault: Fault | None = None  # the cause of a stop, or None
        self._watchdog = watchdog or Watchdog()
        self._listeners = Listeners(listeners)
        exchange = exchange or EndOfScan()
        exchange.attach(rack)
        self._phases = ScanPhases(
            rack,
            logic,
            period_ns,
            exchange=exchange,
            listeners=self._listeners,
            pacer=self.pacer,
            watchdog=self._watchdog,
            forces=self.forces,
            housekeeping=self.housekeeping,
        )
        self._ahead = ScansAhead(self._phases, rack, exchange, period_ns)
        self._view = self._phases.view
        self._tag_forces: Mapping[str, str | int | float | bool] = {}
        self._tags_set_before = -1  # the scan before which a tag was set from outside
        self._scanning = False
        self._closed = False
        self._tag_forces_changed = False
        self._mode = self._next_mode = mode
        self._phases.report_change("/cpu", {"mode": mode_name(mode)})
        if mode is not CpuMode.RUN:
            self._phases.stop_modules()
        self._prepare()
        prepared = attached(logic)
        if prepared is not None:
            prepared.__attach_logic__(self._view.slot)

    @property
    def program(self) -> ScanLogic:
        """The logic. Newly assigned logic is called from the next scan on."""
        return self._phases.program

    @program.setter
    def program(self, logic: ScanLogic) -> None:
        self._phases.program = logic
        self._ahead.end_block()

    @property
    def stop_requested(self) -> bool:
        """Whether `stop` was called; the next `run` resets it."""
        return self._ahead.stop_requested

    @property
    def scan(self) -> int:
        """Number of the next scan; during a scan, the number of that scan."""
        return self._view.number

    @property
    def now_ns(self) -> int:
        """Virtual time of the next scan; during a scan, the time of that scan."""
        return self._view.now_ns

    @property
    def mode(self) -> CpuMode:
        """The mode. A mode that is set during a scan takes effect at the end of the scan."""
        return self._mode

    @mode.setter
    def mode(self, mode: CpuMode) -> None:
        self._next_mode = mode
        self._ask_for_attention()

    def add_listener(self, listener: ScanListener) -> None:
        """Add a listener, which receives events and scans from the next scan on."""
        self._ahead.before_new_listeners()
        self._listeners.add(listener)

    def dismiss(self, listener: ScanListener) -> None:
        """Close a listener and pass nothing more to it; do nothing if it is already closed."""
        self._ahead.before_new_listeners()
        self._listeners.dismiss(listener)

    def pass_over_repeats(self, finder: RepeatFinder) -> None:
        """In repeated scans, only advance the time; see `runtime.loop.scans_ahead`."""
        self._ahead.pass_over_repeats(finder)

    def announce(self, event: Event) -> None:
        """Pass an event from the program to the listeners with the next scan."""
        self._phases.announce(event)
        self._ask_for_attention()

    def tags_from_outside(self, forces: Mapping[str, str | int | float | bool]) -> None:
        """Note that a program tag was set from outside, or that its force changed.

        The next scan shows this in its flags and on /forces. The program stores the forces of its tags; the
        CPU only reports them.
        """
        self._tags_set_before = self._next_scan
        if forces != self._tag_forces:
            self._tag_forces = dict(forces)
            self._tag_forces_changed = True
        self._ask_for_attention()

    def run(self, scans: int | None = None) -> None:
        """Run scans at the pacer's speed, until they are done or `stop` is called.

        Args:
            scans: number of scans; None = until `stop`.

        Raises:
            CpuFault: the logic raised an exception or did not end, or a module or listener failed. Outputs
                are then zero, the modules are stopped, and all listeners are closed.
            ValueError: the CPU has already faulted or is closed.
        """
        self._refuse_if_over()
        self._ahead.stop_requested = False
        self.pacer.begin(self.period_ns)
        self._prepare()
        with self._watchdog.armed(lambda: self._view.number, *LOGIC_CALLERS):
            try:
                self._scanning = True
                self._loop(ENDLESS if scans is None else scans)
            finally:
                self._scanning = False

    def exchange_early(self) -> bool:
        """While the logic is running, carry out the exchange that precedes the next scan.

        After this call the logic sees the new inputs. A CompactLogix does not wait for the end of a scan to
        exchange images either. The exchange does not send the outputs of this scan.

        Returns:
            Whether an exchange is due before the next scan.
        """
        self._ahead.catch_up()
        return self._phases.exchange_early()

    def stop(self) -> None:
        """Make `run` return after the current scan; may be called from a signal handler."""
        self._ahead.stop()

    def stopping_on_ctrl_c(self) -> AbstractContextManager[None]:
        """Make Ctrl-C stop the CPU between scans within the context.

        A second Ctrl-C interrupts endless logic, see `pace.stopping_on_interrupt`.
        """
        return stopping_on_interrupt(self.stop, *LOGIC_CALLERS)

    def close(self) -> None:
        """Close the logic, if possible, and then all listeners in order; do nothing if already closed.

        Raises:
            Exception: the logic or a listener failed to close. The others are closed anyway.
        """
        if self._closed:
            return
        self._closed = True
        with ExitStack() as stack:
            stack.callback(self._listeners.close)
            prepared = attached(self.program)
            if prepared is not None:
                stack.callback(prepared.__close_logic__)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _loop(self, scans: int) -> None:
        """Run scans; turn an error into a fault of the CPU, unless it ends the run, as Ctrl-C does."""
        try:
            self._ahead.run(scans)
        except (Exception, SystemExit, WatchdogTimeout) as error:
            self._fail(error, self._ahead.present)
        except BaseException as error:
            if ends_the_run(error) or self._phases.blame[self._ahead.present] is not Cause.PROGRAM:
                raise
            self._fail(error, self._ahead.present)

    def _ask_for_attention(self) -> None:
        """Have requests applied after this scan, or immediately between runs."""
        self._phases.attention = True
        self._ahead.end_block()
        if not self._scanning:
            self._serve_requests()

    @property
    def _next_scan(self) -> int:
        """Number of the scan in which a request made now takes effect."""
        return self.scan + self._scanning

    def _prepare(self) -> None:
        """Plan the phases of the next scan, see `ScanPhases.prepare`."""
        tags_set = self._tags_set_before == self._next_scan
        self._phases.prepare(self._mode, tags_set=tags_set, tags_forced=bool(self._tag_forces))

    def housekeeping(self) -> None:
        """Apply requests, and move on to the next scan."""
        if self._phases.attention:
            self._attend()
        view = self._view
        view.number += 1
        view.now_ns += self.period_ns

    def _attend(self) -> None:
        """Reset this scan's special conditions, and apply requests."""
        if "logic" not in IDLE_PHASES[self._mode]:
            self._view.first = False
        if self._mode is self._next_mode is CpuMode.SINGLE_SCAN:
            self._next_mode = CpuMode.PROGRAM
        self._serve_requests()

    def _serve_requests(self) -> None:
        """Apply changed forces and a new mode, report them, and plan the next scan."""
        self._phases.attention = False
        if self.forces.commit() or self._tag_forces_changed:
            self._tag_forces_changed = False
            forces: dict[str, JsonValue] = {**self.forces.active}
            if self._tag_forces:
                forces["tags"] = self._tag_forces
            self._phases.report_change("/forces", forces)
        if self._next_mode is not self._mode:
            self._change_mode(self._next_mode)
        self._prepare()

    def _change_mode(self, mode: CpuMode) -> None:
        """Stop the modules, switch to a mode, and report it.

        The next call of the logic is a first one if the CPU leaves program mode for run or test mode.
        """
        self._phases.stop_modules()
        if self._mode is CpuMode.PROGRAM and mode is not CpuMode.SINGLE_SCAN:
            self._view.first = True
        self._mode = mode
        self._phases.report_change("/cpu", {"mode": mode_name(mode)})

    def _refuse_if_over(self) -> None:
        if self.fault is not None:
            raise ValueError(f"the CPU has faulted: {self.fault}")
        if self._closed:
            raise ValueError("the CPU is closed and can't run further scans")

    def _fail(self, error: BaseException, phase: Phase) -> NoReturn:
        """Clear outputs, stop modules and close listeners after an error in a phase; raise a `CpuFault`."""
        cause = Cause.WATCHDOG if isinstance(error, WatchdogTimeout) else self._phases.blame[phase]
        text = _watchdog_words(error) if cause is Cause.WATCHDOG else words_of(error)
        site = next(sites_of(error), NOWHERE)
        self.fault = Fault(self.scan, self.now_ns, cause, place_of(error), text, site)
        if cause is Cause.LISTENER:
            self._listeners.dismiss_present()
        failure = CpuFault(self.fault)
        recorded = phase in (self._phases.record, self.housekeeping)  # the scan is recorded, at least in part
        report_fault = self._report_fault if recorded else self._record_fault
        for step in (self._phases.drop_outputs, report_fault, self.close):
            try:
                step()
            except BaseException as further_error:
                if ends_the_run(further_error):
                    raise
                failure.add_note(f"while stopping: {words_of(further_error)}")
        raise failure from error

    def _record_fault(self) -> None:
        """Pass the unfinished scan and its fault to the listeners."""
        self._phases.report_changes()
        self._report_fault()
        self._listeners.scan(self.scan, self.now_ns, self._phases.flags | ScanFlag.FAULT)

    def _report_fault(self) -> None:
        """Pass the fault to the listeners, after the events of modules."""
        if self.fault is not None:
            self._phases.report_module_events()
            self._listeners.event(self.scan, self.now_ns, "/faults", self.fault.fields)


def _watchdog_words(error: BaseException) -> str:
    """Return the watchdog's message, with the place in the program that the ladder engine noted."""
    return ", ".join([str(error), *getattr(error, "__notes__", ())])
