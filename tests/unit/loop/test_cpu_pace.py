"""Pacing by a scripted wall clock."""

import pytest
from scanrack.runtime import Cpu, FreeRun, ScanFlag
from scanrack.runtime.loop import pace
from scanrack.runtime.loop.pace import RealTime

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


def test_a_scan_that_a_sleep_makes_late_is_marked_like_one_after_an_overrun(rack, clock, diary):
    # Every sleep takes 0.2 ms too long. Scan 2 follows an overrun of 0.05 ms, which is not late.
    clock.slack_ns = 200_000

    def logic(scan):
        clock.now_ns += round(9.85 * MS) if scan.number == 1 else 0

    cpu = Cpu(rack, logic, 10 * MS, pacer=RealTime(), listeners=[diary])
    cpu.run(4)
    assert [scan for scan, _, flags in diary.scans if flags & ScanFlag.OVERRUN] == [1, 3]
    assert (cpu.pacer.overruns, cpu.pacer.late[:2]) == (1, [2, 2])


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


# -- spinning, and late scans by size ----------------------------------------------------------------

LOOK_NS = 10_000


class TickingClock(Clock):
    """A clock that goes on by `LOOK_NS` with every look at it, as it does for a loop that spins."""

    def monotonic_ns(self):
        self.now_ns += LOOK_NS
        return self.now_ns


@pytest.mark.parametrize(
    ("period_ns", "spin_ns"),
    [(1 * MS, 100_000), (10 * MS, 200_000)],
    ids=["a tenth of the period", "0.2 ms at most"],
)
@pytest.mark.parametrize("kind", [RealTime, pace.AdjustablePace])
def test_with_spin_a_sleep_ends_early_and_the_rest_is_waited_awake(monkeypatch, kind, period_ns, spin_ns):
    clock = TickingClock()
    clock.slack_ns = spin_ns // 2
    monkeypatch.setattr(pace, "time", clock)
    pacer = kind(spin=True)
    pacer.begin(period_ns)
    pacer.wait()
    due_ns = clock.now_ns - LOOK_NS + period_ns  # the first scan was due at the first of two looks
    assert pacer.wait() is False
    assert clock.slept_ns == [period_ns - spin_ns - 2 * LOOK_NS]
    assert 0 <= clock.now_ns - due_ns <= LOOK_NS
    assert pacer.worst_late_ns <= LOOK_NS


def test_without_spin_a_sleep_that_ends_early_is_followed_by_another(clock):
    clock.slack_ns = -1 * MS  # the system wakes it a millisecond early
    pacer = RealTime()
    pacer.begin(10 * MS)
    pacer.wait()

    def sleep(seconds, nominal=clock.sleep):
        nominal(seconds)
        clock.slack_ns = 0

    clock.sleep = sleep
    pacer.wait()
    assert clock.slept_ns == [10 * MS, 1 * MS]
    assert pacer.worst_late_ns == 0


def test_late_scans_are_counted_by_size(clock):
    """Sizes begin at 0.1, 0.3, 1, 3, 10, 30 and 100 ms; a scan later by less than the first is on time."""
    pacer = RealTime()
    pacer.begin(1000 * MS)
    for late_ns in (0, 99_999, 100_000, 299_999, 300_000, 29 * MS, 100 * MS, 900 * MS):
        clock.slack_ns = late_ns
        pacer.wait()
    # the first scan is due at once and does not sleep; each of the others sleeps and is late by its slack
    assert pacer.late == [2, 2, 1, 0, 0, 1, 0, 2]
    assert sum(pacer.late) == 8
    assert pacer.worst_late_ns == 900 * MS


@pytest.mark.parametrize(("speed", "on_time_ns"), [(1.0, 99_999), (0.1, 999_990), (2.0, 99_999)])
def test_in_slow_motion_a_scan_is_late_by_machine_time(clock, speed, on_time_ns):
    pacer = pace.AdjustablePace(speed)
    pacer.begin(1000 * MS)
    pacer.wait()
    clock.slack_ns = on_time_ns
    assert pacer.wait() is False
    clock.slack_ns = on_time_ns + 10
    assert pacer.wait() is True


def test_a_free_run_counts_no_late_scans():
    assert FreeRun().late == []
