"""Waits hold in the scan that the table of waits says; one scan is the least of any."""

from typing import Any

import pytest
from scanrack import Input, Logic, Wait, dwell, sequence, steady, until
from sequence_bench import SequenceBench


class Waiting(Logic):
    """Notes the scan in which each wait held."""

    start = Input("start")

    def __init__(self, *waits):
        self.waits = waits
        self.scan = -1
        self.held = []

    def every_scan(self):
        self.scan += 1

    @sequence
    async def cycle(self):
        for make in self.waits:
            await make(self)
            self.held.append(self.scan)


def held(*waits, presses=(), scans=30, scan_ms=2):
    """Return the scans in which waits held; `presses` are scans in which input 0 changes."""
    bench = SequenceBench(Waiting(*waits), scan_ms=scan_ms)
    for scan in range(scans):
        bench.press(0, sum(each <= scan for each in presses) % 2 == 1).scan()
    return bench.logic.held


def test_each_wait_takes_a_scan_at_least():
    assert held(*[lambda self: until(lambda: True)] * 4) == [1, 2, 3, 4]


@pytest.mark.parametrize(
    ("wait", "presses", "expected"),
    [
        (lambda self: self.start.rises, [3], [3]),
        (lambda self: self.start.rises, [0], []),  # on already: no edge
        (lambda self: self.start.rises, [0, 5, 9], [9]),
        (lambda self: self.start.falls, [3, 5], [5]),
        (lambda self: self.start.falls, [0, 7], [7]),
        (lambda self: self.start.on, [0], [1]),  # on already: from the next scan on
        (lambda self: self.start.on, [4], [4]),
        (lambda self: self.start.off, [], [1]),
        (lambda self: self.start.off, [0, 6], [6]),
        (lambda self: until(lambda: self.scan >= 5), [], [5]),
        (lambda self: until(self.start.read), [2], [2]),
    ],
)
def test_levels_and_edges(wait, presses, expected):
    assert held(wait, presses=presses) == expected


@pytest.mark.parametrize(
    ("time", "scan_ms", "expected"),
    [("0 ms", 2, 1), ("1 ms", 2, 1), ("2 ms", 2, 1), ("3 ms", 2, 2), ("20 ms", 2, 10), ("20 ms", 7, 3)],
)
def test_a_dwell_ends_at_the_first_scan_at_or_after_its_time(time, scan_ms, expected):
    assert held(lambda self: dwell(time), scan_ms=scan_ms) == [expected]


@pytest.mark.parametrize(
    ("presses", "expected"),
    [([0], [6]), ([4], [9]), ([2, 5, 7], [12])],  # 10 ms are five scans behind the first that is true
)
def test_steady_begins_anew_at_each_break(presses, expected):
    """The wait begins in scan 0 and looks from scan 1 on."""
    assert held(lambda self: steady(self.start.read, "10 ms"), presses=presses) == expected


def test_a_wait_of_ones_own():
    class Third(Wait[int]):
        def begin(self, now_ns):
            self.left = 3

        def poll(self, now_ns):
            self.left -= 1
            return self.left == 0

        def result(self):
            return 42

    results = []

    async def both(self):
        results.append(await Third())

    class Own(Logic):
        cycle = sequence(both)

    SequenceBench(Own).scan(3)
    assert results == []
    SequenceBench(Own).scan(4)
    assert results == [42]


@pytest.mark.parametrize("text", ["2", "s", "-1 s", "2 seconds", "1e3 ms", "0.5 ns", ""])
def test_what_is_no_time(text):
    with pytest.raises(ValueError, match=r"is not a time|whole number of nanoseconds"):
        dwell(text)


def test_a_level_in_place_of_a_question_is_refused():
    """`until(self.axis.moving)` would ask once and for ever get the same answer."""
    level: Any = True
    with pytest.raises(TypeError, match="write until"):
        until(level)
    with pytest.raises(TypeError, match="write steady"):
        steady(level, "1 s")


def test_a_wait_is_neither_true_nor_false():
    """`if self.start.on:` would always be true."""
    with pytest.raises(TypeError, match="await it"):
        bool(dwell("1 s"))


def test_an_input_is_a_condition():
    assert held(lambda self: until(self.start), presses=[4]) == [4]
    assert held(lambda self: steady(self.start, "10 ms"), presses=[4]) == [9]
    start = Waiting(until).start
    assert repr(steady(start, "1 s")) == "start steady for 1 s"


def test_the_name_of_a_lambda_is_its_text():
    level = 3
    waits = [
        until(lambda: level > 3 and not level),
        until(
            lambda: level == 4  # a comment is no part of it
        ),
        until(lambda: level > 3, "full"),
        until(eval("lambda: True")),
    ]
    assert list(map(repr, waits)) == [
        "until level > 3 and not level", "until level == 4", "full", "until a condition",
    ]  # fmt: skip
