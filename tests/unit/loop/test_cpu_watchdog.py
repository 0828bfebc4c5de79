"""Logic that does not come back. The clocks are scripted ones, but for the endless loop."""

import io
import os
import pdb
import signal
import sys
import threading

import pytest
from scanrack.runtime import Cpu, CpuFault, ScanFlag
from scanrack.runtime.loop import pace
from scanrack.runtime.loop.faults import Cause
from scanrack.runtime.loop.pace import Watchdog

MS = 1_000_000


@pytest.fixture(params=["interval timer", "thread"])
def ticks(request, monkeypatch):
    """The timer that this system has, and what Windows has instead."""
    if request.param == "interval timer":
        yield
        return
    monkeypatch.delattr(signal, "setitimer")
    previous = signal.getsignal(signal.SIGABRT)
    yield
    for each in threading.enumerate():
        if each.name == "watchdog":
            each.join()
    signal.signal(signal.SIGABRT, previous)


@pytest.mark.usefixtures("ticks")
def test_an_endless_loop_ends(rack, module, diary):
    def logic(scan):
        while scan.number == 2:
            try:
                scan.slot[1].outputs[0] = 1
            except Exception:
                continue

    with pytest.raises(
        CpuFault, match=r"scan 2 .* the watchdog ended the program: .*it took longer than 200"
    ) as caught:
        Cpu(rack, logic, 2 * MS, listeners=[diary], watchdog=Watchdog(200 * MS)).run(10)
    fault = caught.value.fault
    assert fault.cause is Cause.WATCHDOG
    assert fault.where.startswith(f"{__file__}:")
    assert diary.scans[-1] == (2, 4 * MS, ScanFlag.RUN | ScanFlag.FAULT)
    assert (diary.word(2), diary.closed) == (0, 1)


def test_many_scans_may_last_longer_than_the_watchdog(rack, monkeypatch):
    """The limit is that of one scan: every scan takes 300 ms of its 500, and is looked at twice."""
    clock = scripted_clock(monkeypatch)

    def logic(scan):
        os.kill(os.getpid(), signal.SIGALRM)
        clock.work(300 * MS)
        os.kill(os.getpid(), signal.SIGALRM)

    cpu = Cpu(rack, logic, watchdog=Watchdog(500 * MS))
    cpu.run(20)
    assert cpu.fault is None


def test_time_outside_the_logic_does_not_count(rack, module, monkeypatch):
    clock = scripted_clock(monkeypatch)

    def script(now_ns):
        for _ in range(3):
            clock.work(1000 * MS)
            os.kill(os.getpid(), signal.SIGALRM)
        return 0

    module.script = script
    cpu = Cpu(rack, lambda scan: None, watchdog=Watchdog(500 * MS))
    cpu.run(2)
    assert cpu.fault is None


WORKS = r"it took longer than 500 ms of processor time"
WAITS = r"it blocked: it took longer than 5000 ms of wall-clock time"
SPENT = [("work", 499, ""), ("work", 500, WORKS), ("wait", 4_999, ""), ("wait", 5_000, WAITS)]
"""What logic does, for how long, and what the watchdog of 500 ms says: others may have the processor, too."""


@pytest.mark.parametrize(("does", "spent_ms", "words"), SPENT)
def test_the_limit_is_one_of_processor_time_and_ten_times_that_on_the_clock(
    rack, monkeypatch, does, spent_ms, words
):
    clock = scripted_clock(monkeypatch)

    def logic(scan):
        os.kill(os.getpid(), signal.SIGALRM)  # seen for the first time
        getattr(clock, does)(spent_ms * MS)
        os.kill(os.getpid(), signal.SIGALRM)

    cpu = Cpu(rack, logic, watchdog=Watchdog(500 * MS))
    if words:
        with pytest.raises(CpuFault, match=words):
            cpu.run(1)
    else:
        cpu.run(1)


@pytest.mark.parametrize(("does", "spent_ms", "words"), SPENT)
def test_without_a_timer_the_time_is_taken_around_the_logic(rack, monkeypatch, does, spent_ms, words):
    clock = scripted_clock(monkeypatch)
    outcome = []

    def logic(scan):
        getattr(clock, does)(spent_ms * MS)

    def elsewhere():
        cpu = Cpu(rack, logic, watchdog=Watchdog(500 * MS))
        try:
            cpu.run(1)
        except CpuFault as fault:
            outcome.append(fault.fault.cause)

    thread = threading.Thread(target=elsewhere)
    thread.start()
    thread.join()
    assert outcome == ([Cause.WATCHDOG] if words else [])


def debugger(clock):
    """Return a prompt that takes a second, in a frame of pdb's."""
    names = {"__name__": "pdb", "os": os, "signal": signal, "clock": clock, "MS": MS}
    exec(
        "def prompt():\n"
        "    for _ in range(3):\n"
        "        clock.work(1000 * MS)\n"
        "        os.kill(os.getpid(), signal.SIGALRM)\n",
        names,
    )
    return names["prompt"]


def test_no_watchdog_at_the_prompt_of_a_debugger(rack, monkeypatch):
    prompt = debugger(scripted_clock(monkeypatch))
    monkeypatch.setattr(sys, "breakpointhook", prompt)
    cpu = Cpu(rack, lambda scan: breakpoint(), watchdog=Watchdog(500 * MS))
    cpu.run(3)
    assert (cpu.fault, cpu.scan) == (None, 3)


@pytest.mark.usefixtures("ticks")
def test_a_real_debugger_stops_the_timer(rack, monkeypatch):
    """A script of commands for pdb, one of which lasts longer than the watchdog."""
    commands = io.StringIO("import time\ntime.sleep(0.3)\ncontinue\n")
    debugger = pdb.Pdb(stdin=commands, stdout=io.StringIO(), nosigint=True)  # it would keep SIGINT's handler
    monkeypatch.setattr(sys, "breakpointhook", debugger.set_trace)

    def logic(scan):
        if scan.number == 1:
            breakpoint()
        scan.slot[1].outputs[0] = scan.number

    cpu = Cpu(rack, logic, watchdog=Watchdog(100 * MS))
    cpu.run(3)
    assert (cpu.fault, cpu.scan, commands.read()) == (None, 3, "")


def test_in_another_thread_a_scan_with_a_breakpoint_has_no_limit(rack, monkeypatch):
    prompt = debugger(scripted_clock(monkeypatch))
    monkeypatch.setattr(pace, "_in_main_thread", lambda: False)
    monkeypatch.setattr(sys, "breakpointhook", prompt)
    signal.signal(signal.SIGALRM, signal.SIG_IGN)
    try:
        cpu = Cpu(rack, lambda scan: breakpoint(), watchdog=Watchdog(500 * MS))
        cpu.run(3)
    finally:
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
    assert (cpu.fault, sys.breakpointhook) == (None, prompt)


def test_handler_and_timer_are_as_they_were(rack):
    ticks = []
    previous = signal.signal(signal.SIGALRM, lambda number, frame: ticks.append(number))
    handler = signal.getsignal(signal.SIGALRM)
    signal.setitimer(signal.ITIMER_REAL, 3600, 1800)
    try:
        Cpu(rack, lambda scan: None).run(3)
        left, every = signal.setitimer(signal.ITIMER_REAL, 0)
        assert signal.getsignal(signal.SIGALRM) is handler
        assert 3000 < left <= 3600
        assert every == 1800
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, previous)


def test_no_watchdog_arms_nothing(rack):
    handler = signal.getsignal(signal.SIGALRM)
    seen = []
    Cpu(rack, lambda scan: seen.append(signal.getsignal(signal.SIGALRM)), watchdog=Watchdog(0)).run(1)
    assert seen == [handler]


def test_a_negative_limit_is_refused():
    with pytest.raises(ValueError, match="watchdog of -1 ns is not allowed"):
        Watchdog(-1)


class Clock:
    """Stands in for the module `time`."""

    now_ns = 0
    used_ns = 0

    def wait(self, ns):
        self.now_ns += ns

    def work(self, ns):
        self.now_ns += ns
        self.used_ns += ns

    def thread_time_ns(self):
        return self.used_ns

    def monotonic_ns(self):
        return self.now_ns

    def monotonic(self):
        return self.now_ns / 1e9


def scripted_clock(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(pace, "time", clock)
    return clock
