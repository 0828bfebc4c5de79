"""A sequence: its turns, abort and restart, and what others see of it."""

import sys
from threading import Thread
from typing import Any

import pytest
from scanrack import Abort, Axis3601, Input, Logic, Output, dwell, sequence, until
from scanrack.ladder.python.sequences import fields_of, parts_of
from scanrack.runtime import CpuFault
from sequence_bench import SETUP, SLOW, SequenceBench


class Ordered(Logic):
    """Does in given scans what a test asks for: `orders` by scan, called with the logic."""

    def __init__(self, **orders):
        self.orders = {int(scan[1:]): order for scan, order in orders.items()}
        self.scan = -1
        self.log = []

    def note(self, what):
        self.log.append((self.scan, what))

    def every_scan(self):
        self.scan += 1
        if self.scan in self.orders:
            self.orders[self.scan](self)

    @sequence
    async def cycle(self):
        self.note("begins")
        try:
            await dwell("1 s")
        except Abort:
            self.note("aborted")
            raise
        finally:
            await until(lambda: True)
            await until(lambda: True)
            self.note("ends")

    @sequence(start=False)
    async def other(self):
        self.note("other")


def played(scans=12, **orders):
    return SequenceBench(Ordered(**orders)).scan(scans).logic.log


def test_an_abort_comes_in_the_same_scan_and_finally_takes_its_scans():
    assert played(s3=lambda self: self.cycle.abort()) == [(0, "begins"), (3, "aborted"), (5, "ends")]


def test_a_restart_begins_anew_in_the_scan_in_which_it_is_over():
    log = played(s3=lambda self: self.cycle.restart())
    assert log == [(0, "begins"), (3, "aborted"), (5, "ends"), (5, "begins")]


def test_a_second_abort_breaks_finally_off():
    log = played(s3=lambda self: self.cycle.restart(), s4=lambda self: self.cycle.abort())
    assert log == [(0, "begins"), (3, "aborted")]


def test_the_later_order_of_a_scan_counts():
    def both(self):
        self.cycle.restart()
        self.cycle.abort()

    assert played(s3=both)[-1] == (5, "ends")


def test_a_sequence_may_wait_for_its_restart():
    log = played(s3=lambda self: self.other.restart(), s5=lambda self: self.other.restart())
    assert log == [(0, "begins"), (3, "other"), (5, "other")]


def test_it_may_be_restarted_in_the_first_scan():
    assert played(1, s0=lambda self: self.other.restart()) == [(0, "begins"), (0, "other")]


def test_an_abort_of_what_is_over_does_nothing():
    assert played(s3=lambda self: self.other.abort()) == [(0, "begins")]


def test_an_order_to_an_earlier_sequence_acts_in_the_next_scan():
    class Two(Logic):
        def __init__(self):
            self.scan = -1
            self.log = []

        def every_scan(self):
            self.scan += 1

        @sequence
        async def early(self):
            try:
                await dwell("1 s")
            finally:
                self.log.append(("early", self.scan))

        @sequence
        async def ordering(self):
            await dwell("6 ms")
            self.early.abort()
            self.late.abort()
            self.ordering.abort()
            await dwell("1 s")

        @sequence
        async def late(self):
            try:
                await dwell("1 s")
            finally:
                self.log.append(("late", self.scan))

    bench = SequenceBench(Two).scan(10)
    assert bench.logic.log == [("late", 3), ("early", 4)]
    assert all(each.over for each in bench.sequences)


def test_an_abort_that_a_sequence_catches_ends_nothing_once():
    """It may go on; a second Abort that it catches faults, see the traps."""

    class Stubborn(Logic):
        start = Input("start")
        caught = 0

        def every_scan(self):
            if self.start:
                self.cycle.abort()

        @sequence
        async def cycle(self):
            while True:
                try:
                    await dwell("1 s")
                except Abort:
                    self.caught += 1

    bench = SequenceBench(Stubborn).scan(3).press(0).scan().press(0, False).scan(3)
    assert (bench.logic.caught, bench.sequences[0].over) == (1, False)
    bench.press(0)
    with pytest.raises(CpuFault, match="swallows Abort"):
        bench.scan()


class Line(Logic):
    axis = Axis3601(1, SETUP)
    start = Input("start")
    lamp: Output = Output("Local:2:O.Data.0")
    count = 0
    name = "line"
    speed = 1.5
    ready = False
    _hidden = 5

    def __init__(self):
        self.made = 7
        self.parts = (1, 2)

    @sequence
    async def cycle(self):
        await self.axis.configure()
        while True:
            await self.start.rises
            self.count += 1
            await self.part()

    async def part(self):
        await dwell("10 ms")


LINE = Line.cycle.function.__code__.co_firstlineno


def test_what_others_see():
    bench = SequenceBench(Line)
    (cycle,) = bench.sequences
    assert (cycle.name, cycle.over, cycle.line, cycle.waits_for, cycle.resumed) == (
        "cycle",
        True,
        None,
        "",
        0,
    )
    assert str(cycle) == "cycle: over"
    bench.scan()
    assert (cycle.line, cycle.waits_for, cycle.resumed, cycle.since_ns) == (
        LINE + 2,
        "axis.configure()",
        1,
        0,
    )
    assert str(cycle) == f"cycle, line {LINE + 2}: axis.configure()"
    bench.until(lambda: cycle.resumed == 2)
    assert (cycle.waits_for, cycle.since_ns) == ("start rises", bench.cpu.now_ns - 2_000_000)
    bench.press(0).scan()
    assert (cycle.line, cycle.waits_for, cycle.resumed) == (LINE + 9, "dwell 10 ms", 3)
    assert cycle.file == __file__


def test_resumed_differs_in_the_scan_of_a_resumption_and_in_no_other():
    bench = SequenceBench(Line)
    seen = []
    for scan in range(40):
        bench.press(0, scan >= 20).scan()
        seen.append(bench.sequences[0].resumed)
    changed = [scan for scan in range(1, 40) if seen[scan] != seen[scan - 1]]
    assert changed[-2:] == [20, 25]
    assert len(changed) == 3  # configured, pressed, dwelt


def test_a_branch_that_goes_on_shows_and_the_count_never_falls():
    from scanrack import all_of

    class Branching(Logic):
        async def part(self):
            await dwell("4 ms")
            await dwell("4 ms")

        @sequence
        async def cycle(self):
            await all_of(self.part(), dwell("20 ms"))
            await dwell("1 s")

    bench = SequenceBench(Branching)
    seen = []
    for _ in range(14):
        bench.scan()
        seen.append(bench.sequences[0].resumed)
    assert seen == sorted(seen)
    changed = [scan for scan in range(1, 14) if seen[scan] != seen[scan - 1]]
    assert changed == [2, 4, 10]


def test_fields_are_those_that_can_be_recorded():
    logic = SequenceBench(Line).scan().logic
    assert fields_of(logic) == {"count": 0, "name": "line", "speed": 1.5, "ready": False, "made": 7}
    assert [each.name for each in parts_of(logic)] == ["axis", "start", "lamp"]


def test_a_move_of_a_sequence_scan_by_scan():
    """The table of the design: call, busy; active from the next scan; state and sequence go on together."""

    class Moving(Logic):
        axis = Axis3601(1, SETUP)
        now = False
        command: Any = None
        second: Any = None

        @sequence
        async def cycle(self):
            await self.axis.configure()
            await self.axis.set_position(0)
            await until(lambda: False if self.axis.moving else self.now)
            self.now = False
            self.command = self.axis.move_by(10, **SLOW)
            await self.command
            self.second = self.axis.move_by(10, **SLOW)
            await self.second

    bench = SequenceBench(Moving).scan(60)
    bench.logic.now = True
    bench.scan()
    command = bench.logic.command
    assert (command.busy, bench.words[0]) == (True, 2)
    bench.until(lambda: not command.busy)
    finished = bench.cpu.scan - 1
    assert bench.logic.second is not None  # the same scan
    bench.until(lambda: bench.words[0] == 2)
    assert bench.cpu.scan - 1 - finished == 7  # zeros have crossed: 10 ms and two scans


def test_racks_in_threads_do_not_disturb_each_other():
    """Whether a sequence takes its turn is asked per thread; the end of one turn is not that of another."""

    class Busy(Logic):
        rounds = 0

        @sequence
        async def cycle(self):
            while True:
                await until(lambda: True)
                self.rounds += 1

    benches = [SequenceBench(Busy) for _ in range(4)]
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        threads = [Thread(target=bench.scan, args=(2_000,)) for bench in benches]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    finally:
        sys.setswitchinterval(interval)
    assert [bench.logic.rounds for bench in benches] == [1_999] * 4


def test_a_sequence_that_runs_says_its_line():
    """Read while it runs, as a debugger does; Python 3.11 and 3.12 crash in some of a thousand calls."""
    lines = set()

    class Look:
        def __call__(self, logic):
            lines.add(logic.cycle.line)

    look = Look()

    class Looking(Logic):
        @sequence
        async def cycle(self):
            for _ in range(5_000):
                look(self)
            await dwell("1 s")

    SequenceBench(Looking).scan(1)
    assert len(lines) == 1
