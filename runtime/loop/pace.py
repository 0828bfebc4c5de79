"""The wall clock: scan pacing, watchdog and signals; no other module uses `time`.

    FreeRun           scans as fast as possible, in virtual time only
    RealTime          scan n of a run is due at start + n * period on the monotonic clock
    AdjustablePace    the same at a multiple of real time, which may change between scans
    Clock             virtual time at a multiple of wall time
    Watchdog          ends endless logic
    stopping_on_interrupt    Ctrl-C requests a stop between scans
    ending_as_interrupt      SIGTERM and SIGHUP act like Ctrl-C

None of this changes an image: a paced run and a free run have identical scans, except for the OVERRUN flag.
"""

from __future__ import annotations

import _thread
import signal
import sys
import threading
import time
from bisect import bisect_right
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import CodeType, FrameType
from typing import Any, Protocol

from typing_extensions import override

WATCHDOG_NS = 500_000_000
"""Default watchdog limit, the same as for a CompactLogix main task, ns."""

WAITING = 10
"""Wall time limit, as a multiple of the processor time limit."""

TICKS_PER_LIMIT = 4
"""Number of watchdog checks per time limit, so that logic is ended after 1 to 1.25 times the limit."""


LATE_FROM_NS = (100_000, 300_000, 1_000_000, 3_000_000, 10_000_000, 30_000_000, 100_000_000)
"""Bounds, ns, of the delays for counting late scans. A scan delayed up to the first bound is on time."""

SPIN_SHARE = 10
"""The longest wait without sleep is the period divided by this number, but at most `SPIN_MAX_NS`."""

SPIN_MAX_NS = 200_000
"""Longest wait without sleep, ns. On a machine with spare capacity, a sleep rarely ends later than that."""


BEAT_NS = 100_000_000
"""Longest wall time, ns, until recorded scans are flushed toward the disk."""


def _nothing() -> None: ...


class Pacer(Protocol):
    """Decides when scans begin."""

    free: bool
    """Whether scans never wait, so that the scan loop need not call `wait`."""

    overruns: int
    """Number of scans that began late because the previous scan was not finished in time."""

    worst_late_ns: int
    """The longest delay of a scan, ns."""

    late: list[int]
    """Number of scans by delay: on time, then above each delay in `LATE_FROM_NS`; empty if free."""

    beat: Callable[[], object]
    """Called between two scans, at least every `BEAT_NS` if scans are shorter; never if free."""

    def begin(self, period_ns: int) -> None:
        """Begin a run, with its first scan due now."""

    def wait(self) -> bool:
        """Wait until the next scan is due; return whether it begins late."""


class FreeRun(Pacer):
    """No pacing: the next scan begins as soon as the previous one is done."""

    free = True
    overruns = 0
    worst_late_ns = 0

    def __init__(self) -> None:
        self.late: list[int] = []
        self.beat = _nothing

    @override
    def begin(self, period_ns: int) -> None:
        pass

    def wait(self) -> bool:
        """Return False immediately."""
        return False


class RealTime(Pacer):
    """Pacing by the wall clock: scan n of a run is due at the start of the run + n * period.

    A late scan does not shift the following scans, which run without a pause until the loop has caught up. A
    scan is late if the previous scan was not finished (an overrun), or if the sleep took too long.

    Args:
        spin: whether to sleep only until shortly before a scan is due, and then poll the clock. This uses at
            most a tenth of a processor, and scans begin within a few microseconds of their due time.
        sleep: function that waits up to a number of seconds; it can do other work in the meantime.
    """

    free = False

    def __init__(self, *, spin: bool = False, sleep: Callable[[float], object] | None = None) -> None:
        self._sleep = sleep or (lambda seconds: time.sleep(seconds))  # tests replace the clock
        self.overruns = 0
        self.worst_late_ns = 0
        self.late = [0] * (len(LATE_FROM_NS) + 1)
        self._spin = spin
        self._spin_ns = 0
        self._period_ns = 0
        self._slowed = 1.0  # machine time per wall time, at most 1, since delays count in machine time
        self._due_ns: int | None = None
        self.beat: Callable[[], object] = _nothing
        self._beat_ns = 0

    @override
    def begin(self, period_ns: int) -> None:
        self._period_ns = period_ns
        self._spin_ns = min(period_ns // SPIN_SHARE, SPIN_MAX_NS) if self._spin else 0
        self._due_ns = None

    @override
    def wait(self) -> bool:
        """Wait until the next scan is due; count and measure its delay; return whether it is late."""
        now_ns = time.monotonic_ns()
        if now_ns >= self._beat_ns:
            self._beat(now_ns)
        due_ns = now_ns if self._due_ns is None else self._due_ns
        self._due_ns = due_ns + self._period_ns
        overrun = now_ns > due_ns
        if not overrun:
            now_ns = self._wait_until(due_ns, now_ns)
        late_ns = now_ns - due_ns
        self.worst_late_ns = max(self.worst_late_ns, late_ns)
        class_index = bisect_right(LATE_FROM_NS, late_ns * self._slowed)
        self.late[class_index] += 1
        self.overruns += overrun
        return class_index > 0

    def _beat(self, now_ns: int) -> None:
        """Call `beat`, and set the earliest instant of the next call."""
        self._beat_ns = now_ns + max(0, BEAT_NS - 2 * self._period_ns)
        self.beat()

    def _wait_until(self, due_ns: int, now_ns: int) -> int:
        """Sleep, and perhaps poll the clock, until an instant; return the time after that."""
        sleep_ns = due_ns - self._spin_ns - now_ns
        if sleep_ns > 0:
            self._sleep(sleep_ns / 1e9)
        while (now_ns := time.monotonic_ns()) < due_ns:
            if not self._spin:  # the sleep ended early
                self._sleep((due_ns - now_ns) / 1e9)
        return now_ns


class AdjustablePace(RealTime):
    """Pacing by the wall clock, at a speed that can change between two scans.

    In slow motion, a delay is measured in machine time: 1 ms on the clock is 0.1 ms at a tenth of the speed.
    At full speed this pacer is free, and modules can be computed in advance, as without a session. The CPU
    reads the speed when it prepares the next scans.

    Args:
        speed: seconds of virtual time per second, above 0; None = as fast as possible.
        spin: see `RealTime`.
    """

    def __init__(self, speed: float | None = 1.0, *, spin: bool = False) -> None:
        super().__init__(spin=spin)
        self._nominal_ns = 0
        self._speed = speed
        self.free = speed is None

    @property
    def speed(self) -> float | None:
        """Seconds of virtual time per second; None = as fast as possible."""
        return self._speed

    @speed.setter
    def speed(self, speed: float | None) -> None:
        self._speed = speed
        self.free = speed is None
        if self._nominal_ns:
            self.begin(self._nominal_ns)

    @override
    def begin(self, period_ns: int) -> None:
        self._nominal_ns = period_ns
        self._slowed = 1.0 if self._speed is None else min(1.0, self._speed)
        super().begin(period_ns if self._speed is None else max(1, round(period_ns / self._speed)))

    @override
    def wait(self) -> bool:
        """Wait as `RealTime` does; at full speed, only call `beat` if it is due, and return False."""
        if self._speed is not None:
            return super().wait()
        now_ns = time.monotonic_ns()
        if now_ns >= self._beat_ns:
            self._beat(now_ns)
        return False


class Clock:
    """Virtual time at a multiple of wall time, from 0 at its creation.

    Args:
        speed: seconds of virtual time per second, above 0.

    Raises:
        ValueError: the speed is not above 0.
    """

    def __init__(self, speed: float = 1.0) -> None:
        if not 0 < speed < float("inf"):
            raise ValueError(f"time scale {speed:g}: must be above 0")
        self.speed = speed
        self._start_ns = time.monotonic_ns()

    def now_ns(self) -> int:
        """Return the virtual time, ns."""
        return int((time.monotonic_ns() - self._start_ns) * self.speed)

    def seconds_until(self, at_ns: int | None, longest_s: float) -> float:
        """Return how long to wait on the wall clock until an instant of virtual time, s.

        Args:
            at_ns: the instant; None = return `longest_s`.
        """
        if at_ns is None:
            return longest_s
        return min(longest_s, max(0.0, (at_ns - self.now_ns()) / self.speed / 1e9))


class WatchdogTimeout(BaseException):
    """The logic has taken longer than the watchdog allows.

    It is not a subclass of Exception, so a program that catches every Exception in a loop does not catch it.
    """


class Watchdog:
    """A watchdog that ends endless logic.

    The limit applies to processor time, so time used by other processes on a busy machine does not count. For
    logic that waits, there is also a wall time limit that is ten times as long.

    In the main thread, the watchdog does not slow down scans: a timer, or a thread on a system without
    timers, checks regularly whether the same scan is still inside the logic. After the limit the timer raises
    `WatchdogTimeout` there, even in an endless loop. (A long call to a C function can be ended only when it
    returns.) In other threads the time is measured before and after the logic, which detects a long scan but
    not an endless one; see `timed`.

    A debugger disables the watchdog. If the timer finds a debugger on the stack, it stops for the rest of the
    run. A scan that is traced or calls `breakpoint()` does not count toward the limit.

    Args:
        limit_ns: maximum processor time of the logic in one scan; 0 = no watchdog.

    Raises:
        ValueError: the limit is negative.
    """

    def __init__(self, limit_ns: int = WATCHDOG_NS) -> None:
        if limit_ns < 0:
            raise ValueError(f"watchdog of {limit_ns} ns is not allowed: must be positive, or 0 for none")
        self.limit_ns = limit_ns
        self._checked_scan = -1  # the scan inside the logic at the latest check, -1 for none
        self._checked_since = (0, 0)  # `_clocks` at the first check that found this scan

    @property
    def timed(self) -> bool:
        """Whether the scan loop must measure the time, since no timer can interrupt this thread."""
        return self.limit_ns > 0 and not _in_main_thread()

    @contextmanager
    def armed(self, scan: Callable[[], int], *inside: CodeType) -> Iterator[None]:
        """Watch the logic within the context.

        Args:
            scan: returns the number of the current scan.
            inside: the functions that call the logic; while one of them is on the stack, the logic runs.
        """
        if self.limit_ns == 0 or not _in_main_thread():
            yield
            return
        debugged = False

        def check(_number: int, frame: FrameType | None) -> None:
            nonlocal debugged
            debugged = debugged or _in_debugger(frame)
            if not debugged:
                self._check(scan() if _on_stack(inside, frame) else -1)

        interval = self.limit_ns / TICKS_PER_LIMIT / 1e9
        with (_interval_timer if hasattr(signal, "setitimer") else _ticker.ticking)(interval, check):
            yield

    def call(self, logic: Callable[[], None]) -> None:
        """Call `logic` and measure its time, if `timed`.

        Raises:
            WatchdogTimeout: the logic took longer than the limit.
        """
        clocks_before = _clocks()
        with _noticing_breakpoints() as breakpoints:
            logic()
        if not (breakpoints or _traced_by_debugger()):
            self._expire_if_over(clocks_before)

    def _check(self, scan: int) -> None:
        if scan < 0 or scan != self._checked_scan:
            self._checked_scan, self._checked_since = scan, _clocks()
        else:
            self._expire_if_over(self._checked_since)

    def _expire_if_over(self, since: tuple[int, int]) -> None:
        """Raise `WatchdogTimeout` if the logic has taken too long since `_clocks` returned `since`."""
        thread_ns, clock_ns = _clocks()
        limit_ms = self.limit_ns / 1e6
        if thread_ns - since[0] >= self.limit_ns:
            raise WatchdogTimeout(f"it took longer than {limit_ms:g} ms of processor time")
        if clock_ns - since[1] >= WAITING * self.limit_ns:
            raise WatchdogTimeout(
                f"it blocked: it took longer than {WAITING * limit_ms:g} ms of wall-clock time"
            )


def _clocks() -> tuple[int, int]:
    """Return the processor time of this thread and the monotonic clock, ns."""
    return time.thread_time_ns(), time.monotonic_ns()


def _in_main_thread() -> bool:
    return threading.current_thread() is threading.main_thread()


def _stack(frame: FrameType | None) -> Iterator[FrameType]:
    while frame is not None:
        yield frame
        frame = frame.f_back


def _on_stack(codes: tuple[CodeType, ...], frame: FrameType | None) -> bool:
    return any(caller.f_code in codes for caller in _stack(frame))


DEBUGGERS = frozenset({"bdb", "pdb", "debugpy", "pydevd", "_pydevd_bundle", "_pydevd_frame_eval"})
"""Top-level modules of debuggers: Python's own, on which IPython's is based, and those of editors."""


def _in_debugger(frame: FrameType | None) -> bool:
    return any(_is_debugger_module(caller.f_globals.get("__name__")) for caller in _stack(frame))


def _traced_by_debugger() -> bool:
    """Return whether a debugger traces this thread; coverage tools also set a trace function."""
    return _is_debugger_module(getattr(sys.gettrace(), "__module__", None))


def _is_debugger_module(module: object) -> bool:
    return isinstance(module, str) and module.partition(".")[0] in DEBUGGERS


@contextmanager
def _noticing_breakpoints() -> Iterator[list[None]]:
    """Yield a list that gets an entry for each call to `breakpoint()`; the original hook still runs."""
    calls: list[None] = []
    hook = sys.breakpointhook

    def noticed(*arguments: Any, **options: Any) -> Any:
        calls.append(None)
        return hook(*arguments, **options)

    sys.breakpointhook = noticed
    try:
        yield calls
    finally:
        sys.breakpointhook = hook


Handler = Callable[[int, FrameType | None], None]
"""Function that handles a signal."""


@contextmanager
def _interval_timer(interval: float, handler: Handler) -> Iterator[None]:
    """Run `handler` every `interval` seconds; restore the handler and timer at the end."""
    system: Any = signal  # type checkers know its timers on POSIX only
    start = time.monotonic()
    previous = signal.signal(system.SIGALRM, handler)
    old_left_s, old_interval_s = system.setitimer(system.ITIMER_REAL, interval, interval)
    try:
        yield
    finally:
        system.setitimer(system.ITIMER_REAL, 0)
        signal.signal(system.SIGALRM, previous)
        if old_left_s:
            system.setitimer(
                system.ITIMER_REAL, max(old_left_s - (time.monotonic() - start), 1e-6), old_interval_s
            )


class _Ticker:
    """A thread that interrupts the main thread regularly, for a system without interval timers.

    It uses SIGABRT, which nothing else sends and every system has. The handler stays installed, since the
    last tick may arrive after the end. A real abort ends the process regardless of the handler.
    """

    def __init__(self) -> None:
        self._interval = 0.0  # 0 = off
        self._handler: Handler = _no_handler
        self._changing = threading.Lock()
        self.thread: threading.Thread | None = None

    @contextmanager
    def ticking(self, interval: float, handler: Handler) -> Iterator[None]:
        """Run `handler` in the main thread every `interval` seconds."""
        previous = self._interval, self._handler
        with self._changing:
            self._interval, self._handler = interval, handler
            if self.thread is None:
                signal.signal(signal.SIGABRT, lambda number, frame: self._handler(number, frame))
                self.thread = threading.Thread(target=self._run, name="watchdog", daemon=True)
                self.thread.start()
        try:
            yield
        finally:
            self._interval, self._handler = previous

    def _run(self) -> None:
        """Interrupt the main thread at every interval, until the interval is 0."""
        while True:
            time.sleep(self._interval)
            with self._changing:
                if not self._interval:  # off: the next run starts another thread
                    self.thread = None
                    return
            _thread.interrupt_main(signal.SIGABRT)


def _no_handler(_number: int, _frame: FrameType | None) -> None: ...


_ticker = _Ticker()


@contextmanager
def stopping_on_interrupt(stop: Callable[[], None], *inside: CodeType) -> Iterator[None]:
    """Make Ctrl-C call `stop`; further presses interrupt a run that does not stop.

    The first press only requests a stop. The second raises KeyboardInterrupt if the logic is running, since
    the logic may never end. Otherwise the scan is about to end, and a recorder must not be interrupted. The
    third press always raises KeyboardInterrupt. The context restores the handler when it ends. Outside the
    main thread, nothing is changed.

    Args:
        stop: function that requests a stop between scans.
        inside: the functions that call the logic; while one of them is on the stack, the logic runs.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    presses = 0

    def pressed(_number: int, frame: FrameType | None) -> None:
        nonlocal presses
        presses += 1
        stop()
        interrupts_logic = presses == 2 and _on_stack(inside, frame)
        if interrupts_logic or presses > 2:
            raise KeyboardInterrupt

    previous = signal.signal(signal.SIGINT, pressed)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, previous)


@contextmanager
def ending_as_interrupt() -> Iterator[None]:
    """Make SIGTERM, SIGHUP (a closed terminal) and Ctrl-Break on Windows act like Ctrl-C.

    An ignored signal, such as SIGHUP under nohup, stays ignored. If Ctrl-C is ignored, as in a background job
    of a shell, the other signals raise KeyboardInterrupt. The context restores the handlers when it ends.
    Outside the main thread, it does nothing.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    signal_numbers = [
        getattr(signal, name) for name in ("SIGTERM", "SIGHUP", "SIGBREAK") if hasattr(signal, name)
    ]
    previous = {
        number: signal.signal(number, _interrupt)
        for number in signal_numbers
        if signal.getsignal(number) is not signal.SIG_IGN
    }
    try:
        yield
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)
        _ended_by.clear()


def interrupted_by() -> str:
    """Return what ended the run, for messages: "Ctrl-C", or the name of a signal that acted like Ctrl-C."""
    return _ended_by[0] if _ended_by else "Ctrl-C"


_ended_by: list[str] = []
"""Names of the signals that acted like Ctrl-C."""


def _interrupt(number: int, _frame: FrameType | None) -> None:
    """Handle a signal as Ctrl-C, and keep its name for messages."""
    name = signal.Signals(number).name
    _ended_by.append(name)
    if name == "SIGHUP":  # shell and kernel both send it, and the second one would interrupt the stop
        signal.signal(number, signal.SIG_IGN)
    if not callable(signal.getsignal(signal.SIGINT)):
        raise KeyboardInterrupt
    signal.raise_signal(signal.SIGINT)


def rest(seconds: float) -> None:
    """Sleep on the wall clock."""
    time.sleep(seconds)


wall_ns: Callable[[], int] = time.monotonic_ns
"""Return the monotonic clock, ns."""
