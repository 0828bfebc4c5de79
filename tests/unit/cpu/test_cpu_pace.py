"""Pacing by a scripted wall clock."""

import pytest
from scanrack.runtime import pace
from scanrack.runtime.cpu import Cpu, ScanFlag
from scanrack.runtime.pace import FreeRun, RealTime

MS = 1_000_000


class Clock:
    """Stands in for the module `time`; sleeping moves it on, and takes `slack_ns` too long."""

    def __init__(self):
        self.now_ns = 5_000 * MS
        self.slack_ns = 0
        self.slept_ns = []

    def monotonic_ns(self):
        return self.now_ns

    def monotonic(self):
        return self.now_ns / 1e9

    def sleep(self, seconds):
        self.slept_ns.append(round(seconds * 1e9))
        self.now_ns += round(seconds * 1e9) + self.slack_ns


@pytest.fixture
def clock(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(pace, "time", clock)
    return clock


def test_scans_are_due_at_start_plus_n_periods(rack, clock):
    began = []

    def logic(scan):
        began.append(clock.now_ns - 5_000 * MS)
        clock.now_ns += 1 * MS

    cpu = Cpu(rack, logic, 10 * MS, pacer=RealTime())
    cpu.run(4)
    assert began == [0, 10 * MS, 20 * MS, 30 * MS]
    assert clock.slept_ns == [9 * MS] * 3
    assert (cpu.pacer.overruns, cpu.pacer.worst_late_ns) == (0, 0)


def test_overruns_are_counted_flagged_and_caught_up_with(rack, clock, diary):
    # Scan 1, due at 10 ms, takes 25 ms: it ends at 35 ms. Scan 2 (due at 20) begins at 35, 15 late;
    # scan 3 (due at 30) begins at 36, 6 late; scan 4 (due at 40) is on time again.
    began = []

    def logic(scan):
        began.append(clock.now_ns - 5_000 * MS)
        clock.now_ns += 25 * MS if scan.number == 1 else 1 * MS

    cpu = Cpu(rack, logic, 10 * MS, pacer=RealTime(), listeners=[diary])
    cpu.run(6)
    assert began == [0, 10 * MS, 35 * MS, 36 * MS, 40 * MS, 50 * MS]
    assert (cpu.pacer.overruns, cpu.pacer.worst_late_ns) == (2, 15 * MS)
    assert [scan for scan, _, flags in diary.scans if flags & ScanFlag.OVERRUN] == [2, 3]


def test_a_sleep_that_takes_too_long_is_late_but_no_overrun(rack, clock):
    clock.slack_ns = 70_000
    cpu = Cpu(rack, lambda scan: None, 10 * MS, pacer=RealTime())
    cpu.run(3)
    assert (cpu.pacer.overruns, cpu.pacer.worst_late_ns) == (0, 70_000)
    assert clock.slept_ns == [10 * MS, 10 * MS - 70_000]


def test_every_run_starts_anew(rack, clock):
    cpu = Cpu(rack, lambda scan: None, 10 * MS, pacer=RealTime())
    cpu.run(1)
    clock.now_ns += 1000 * MS
    cpu.run(1)
    assert (cpu.pacer.overruns, clock.slept_ns) == (0, [])


def test_a_free_run_does_not_wait():
    pacer = FreeRun()
    pacer.begin(10 * MS)
    assert pacer.wait() is False
    assert (pacer.overruns, pacer.worst_late_ns) == (0, 0)
