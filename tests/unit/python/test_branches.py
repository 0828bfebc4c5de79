"""all_of, first_of, within and locks: what they wait for, which branch loses, and when."""

from typing import Any

import pytest
import scanrack
from scanrack import (
    Axis3601,
    AxisError,
    CommandAborted,
    Input,
    Lock,
    Logic,
    WaitTimeout,
    all_of,
    dwell,
    first_of,
    sequence,
    until,
    within,
)
from scanrack.runtime import CpuFault
from sequence_bench import SETUP, SLOW, SequenceBench


class Playing(Logic):
    """Notes what happens, with the scan."""

    start = Input("start")
    stop = Input("stop")

    def __init__(self):
        self.scan = -1
        self.log = []

    def every_scan(self):
        self.scan += 1

    def note(self, what):
        self.log.append((self.scan, what))

    async def counting(self, name, scans, *, last=0):
        """Take so many waits; the `finally` takes `last` more."""
        try:
            for _ in range(scans):
                await until(lambda: scans > 0)  # Python 3.12 does not know where a constant stands
            return name
        finally:
            for _ in range(last):
                await until(lambda: True)
            self.note(f"{name} ends")

    async def failing(self, scans):
        for _ in range(scans):
            await until(lambda: True)
        raise KeyError("failing")


def played(method, scans=20, **options):
    class Cycle(Playing):
        cycle = sequence(method)

    return SequenceBench(Cycle, **options).scan(scans).logic.log


def test_all_of_waits_for_the_last_and_returns_all():
    async def cycle(self):
        self.note(await all_of(self.counting("a", 2), dwell("10 ms"), self.counting("b", 3)))

    assert played(cycle) == [(2, "a ends"), (3, "b ends"), (5, ("a", None, "b"))]


def test_branches_that_end_at_once_take_a_scan_nevertheless():
    async def cycle(self):
        self.note(await all_of(self.counting("a", 0), self.counting("b", 0)))

    assert played(cycle) == [(0, "a ends"), (0, "b ends"), (1, ("a", "b"))]


def test_the_first_error_ends_all_of_and_the_others_are_aborted():
    async def cycle(self):
        try:
            await all_of(self.counting("a", 9), self.failing(3), self.counting("b", 9))
        except KeyError as error:
            self.note(error.args[0])

    assert played(cycle) == [(3, "a ends"), (3, "b ends"), (3, "failing")]


def test_a_branch_that_fails_at_once_raises_in_the_next_scan():
    async def cycle(self):
        try:
            await all_of(self.failing(0), self.counting("b", 9))
        except KeyError:
            self.note("caught")

    assert played(cycle) == [(1, "b ends"), (1, "caught")]


def test_first_of_returns_the_argument_that_was_first():
    async def cycle(self):
        work, pause = self.counting("a", 9), dwell("6 ms")
        winner = await first_of(work, pause)
        self.note(winner is pause)

    assert played(cycle) == [(3, "a ends"), (3, True)]


def test_a_branch_may_be_the_first():
    async def cycle(self):
        work = self.counting("a", 2)
        self.note(await first_of(dwell("1 s"), work) is work)

    assert played(cycle) == [(2, "a ends"), (2, True)]


def test_order_decides_within_a_scan():
    async def cycle(self):
        one, other = dwell("4 ms"), dwell("4 ms")
        self.note(await first_of(one, other) is one)

    assert played(cycle) == [(2, True)]


def test_the_wait_holds_once_the_loser_is_gone():
    """The loser's `finally` takes three waits, so three scans; cocotb's #5188: an aborted task has to end."""

    async def cycle(self):
        await first_of(self.counting("loser", 9, last=3), dwell("4 ms"))
        self.note("on")

    assert played(cycle) == [(5, "loser ends"), (5, "on")]


def test_an_error_waits_for_the_losers_too():
    async def cycle(self):
        try:
            await all_of(self.counting("loser", 9, last=2), self.failing(1))
        except KeyError:
            self.note("caught")

    assert played(cycle) == [(3, "loser ends"), (3, "caught")]


def test_within_returns_the_value_in_time():
    async def cycle(self):
        self.note(await within("20 ms", self.counting("a", 3)))

    assert played(cycle) == [(3, "a ends"), (3, "a")]


def test_within_raises_at_its_time_and_aborts_the_branch():
    async def cycle(self):
        try:
            await within("6 ms", self.counting("a", 9, last=2))
        except WaitTimeout as error:
            self.note(str(error).split(",")[0])

    assert played(cycle) == [(5, "a ends"), (5, "counting")]


def test_the_message_of_a_timeout_says_where_the_branch_stood():
    async def cycle(self):
        await within("6 ms", self.counting("a", 9))

    with pytest.raises(CpuFault, match=r"counting, line \d+: until scans > 0 took longer than 6 ms"):
        played(cycle)


def test_nested_waits():
    async def cycle(self):
        self.note(await all_of(within("1 s", self.counting("a", 1)), all_of(self.counting("b", 2))))

    assert played(cycle)[-1] == (2, ("a", ("b",)))


def test_abort_reaches_the_branches_first():
    """The sequence gets its Abort in the scan in which its branches are gone."""

    class Aborted(Playing):
        def every_scan(self):
            super().every_scan()
            if self.scan == 4:
                self.cycle.abort()

        @sequence
        async def cycle(self):
            try:
                await all_of(self.counting("a", 50, last=3), self.counting("b", 50))
            finally:
                self.note("cycle ends")

    bench = SequenceBench(Aborted).scan(20)
    assert bench.logic.log == [(4, "b ends"), (7, "a ends"), (7, "cycle ends")]
    assert bench.sequences[0].over


def test_a_command_that_loses_goes_on_moving():
    class Losing(Logic):
        axis = Axis3601(1, SETUP)
        moving_at_the_end = False

        @sequence
        async def cycle(self):
            await self.axis.configure()
            await self.axis.set_position(0)
            move = self.axis.move_to(4_000, **SLOW)
            await first_of(move, dwell("200 ms"))
            self.moving_at_the_end = self.axis.moving and move.busy
            await move

    bench = SequenceBench(Losing).scan(150)
    assert bench.logic.moving_at_the_end
    bench.until(lambda: bench.sequences[0].over)
    assert bench.logic.axis.position == 4_000


def test_errors_of_commands_come_through():
    class Failing(Logic):
        axis = Axis3601(1, SETUP)
        said: Any = ()

        @sequence
        async def cycle(self):
            await self.axis.configure()
            await self.axis.set_position(0)
            try:
                await all_of(dwell("1 s"), self.axis.move_to(1, speed=5, acceleration=1, deceleration=1))
            except AxisError as error:
                self.said += (int(error.id),)
            await self.axis.reset()
            move = self.axis.move_to(4_000, **SLOW)
            self.axis.halt()
            try:
                await within("1 s", move)
            except CommandAborted:
                self.said += ("aborted",)

    bench = SequenceBench(Failing)
    bench.until(lambda: bench.sequences[0].resumed and bench.sequences[0].over)
    assert bench.logic.said == (3, "aborted")  # below starting speed: CMD-05 and PRF-01


@pytest.mark.parametrize("make", [all_of, first_of, lambda *work: within("1 s", *work)])
@pytest.mark.parametrize("work", [(), (5,), (None,)])
def test_what_is_neither_wait_nor_coroutine_is_refused(make, work):
    with pytest.raises(TypeError):
        make(*work)


class Sharing(Playing):
    zone = Lock()

    def every_scan(self):
        super().every_scan()
        if self.start:
            self.second.abort()

    async def stay(self, name, scans):
        async with self.zone:
            self.note(f"{name} in")
            for _ in range(scans):
                await until(lambda: True)
        self.note(f"{name} out")

    @sequence
    async def first(self):
        await self.stay("first", 3)

    @sequence
    async def second(self):
        await self.stay("second", 2)

    @sequence
    async def third(self):
        await self.stay("third", 1)


def test_a_lock_has_one_owner_at_a_time_in_order_of_asking():
    """One that comes later in the scan takes it over in the scan in which it is free."""
    assert SequenceBench(Sharing).scan(20).logic.log == [
        (0, "first in"),
        (3, "first out"),
        (3, "second in"),
        (5, "second out"),
        (5, "third in"),
        (6, "third out"),
    ]


@pytest.mark.parametrize("scan", [1, 4])
def test_an_abort_leaves_the_queue_or_the_lock(scan):
    bench = SequenceBench(Sharing).scan(scan).press(0).scan(20)
    assert [what for _, what in bench.logic.log if what.startswith("third")] == ["third in", "third out"]
    assert not bench.logic.zone.taken


def test_a_lock_says_who_waits():
    bench = SequenceBench(Sharing).scan(2)
    assert bench.sequences[1].waits_for == "zone free"
    assert bench.sequences[1].line == bench.sequences[2].line


def test_program_mode_frees_the_lock():
    bench = SequenceBench(Sharing).scan(2).restart().scan()
    assert bench.logic.log[-1] == (2, "first in")


def test_within_limits_what_is_awaited_and_eventually_what_must_come_true():
    @scanrack.eventually("5 s", after=lambda now: True)
    def it_ends(now):
        return True

    assert it_ends.name == "it_ends"
    assert repr(scanrack.within("5 s", dwell("1 s"))) == "within 5 s dwell 1 s"
    wrong: Any
    for wrong in ({}, {"work": dwell("1 s"), "after": lambda now: True}):
        with pytest.raises(TypeError):
            scanrack.within("5 s", **wrong)
