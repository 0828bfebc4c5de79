"""Waits inside of waits, at random: the scan in which they hold is that of a few lines of arithmetic.

The oracle knows no coroutine. A wait that begins in scan n holds in scan n + 1 at the earliest; all_of holds
with its last or fails with its first error, first_of holds with its first, within with its wait or at its
time, and a branch takes its waits one after the other.
"""

from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st
from scanrack import Logic, WaitTimeout, all_of, dwell, first_of, sequence, steady, until, within
from sequence_bench import SequenceBench

SCAN_MS = 2

times = st.integers(0, 40)
leaves = (
    st.tuples(st.just("dwell"), times)
    | st.tuples(st.just("until"), st.integers(0, 40))
    | st.tuples(st.just("steady"), st.integers(0, 40), times)
)


def nested(inner):
    several = st.lists(inner, min_size=1, max_size=3)
    return (
        st.tuples(st.just("all"), several)
        | st.tuples(st.just("first"), several)
        | st.tuples(st.just("within"), times, inner)
        | st.tuples(st.just("branch"), st.lists(inner, max_size=3))
    )


waits: st.SearchStrategy[Any] = st.recursive(leaves, nested, max_leaves=8)


def end_of(wait, start):
    """Return the scan in which a wait that begins in scan `start` ends, and whether it ends well."""
    kind, *rest = wait
    if kind == "dwell":
        return start + max(1, scans_of(rest[0])), True
    if kind == "until":
        return max(start + 1, rest[0]), True
    if kind == "steady":
        return max(start + 1, rest[0]) + scans_of(rest[1]), True
    if kind == "within":
        limit = start + max(1, scans_of(rest[0]))
        scan, well = end_of(rest[1], start)
        return (scan, well) if scan <= limit else (limit, False)
    if kind == "branch":
        scan, well = start, True
        for each in rest[0]:
            if well:
                scan, well = end_of(each, scan)
        return max(scan, start + 1), well
    ends = [end_of(each, start) for each in rest[0]]
    if kind == "first":
        return min(ends, key=lambda end: end[0])
    failed = [scan for scan, well in ends if not well]
    return (min(failed), False) if failed else (max(scan for scan, _ in ends), True)


def scans_of(ms):
    return -(-ms // SCAN_MS)


class Waiting(Logic):
    """Awaits what a specification says, and notes the scan in which it ends."""

    def __init__(self, wait):
        self.wait, self.scan, self.ended = wait, -1, None

    def every_scan(self):
        self.scan += 1

    def made(self, wait):
        kind, *rest = wait
        if kind == "dwell":
            return dwell(f"{rest[0]} ms")
        if kind == "until":
            return until(lambda: self.scan >= rest[0])
        if kind == "steady":
            return steady(lambda: self.scan >= rest[0], f"{rest[1]} ms")
        if kind == "within":
            return within(f"{rest[0]} ms", self.made(rest[1]))
        if kind == "branch":
            return self.branch(rest[0])
        return (all_of if kind == "all" else first_of)(*map(self.made, rest[0]))

    async def branch(self, waits):
        for each in waits:
            await self.made(each)

    @sequence
    async def cycle(self):
        try:
            await all_of(self.made(self.wait))
            self.ended = self.scan, True
        except WaitTimeout:
            self.ended = self.scan, False


@settings(deadline=None)
@given(wait=waits)
def test_a_wait_ends_in_the_scan_that_arithmetic_says(wait):
    expected = end_of(("all", [wait]), 0)
    bench = SequenceBench(Waiting(wait))
    bench.until(lambda: bench.logic.ended is not None, expected[0] + 5)
    assert bench.logic.ended == expected
    assert bench.cpu.scan == expected[0] + 1
