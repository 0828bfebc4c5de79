"""Timers, edges and counters: the timing diagrams of IEC 61131-3, tables 44 to 46."""

import pytest
from scanrack import Counter, DownCounter, Fall, Input, Logic, OffDelay, OnDelay, Output, Pulse, Rise
from scanrack.ladder.python.sequences.parts import Clock
from sequence_bench import SequenceBench


def played(block, inputs, ms=10):
    """Call a block with each input in turn, so many ms apart; return its results as 0 and 1."""
    clock = Clock()
    if hasattr(block, "preset_ns"):
        block.attach({}, clock)
    results = ""
    for each in inputs:
        results += str(int(block(each == "1")))
        clock.now_ns += ms * 1_000_000
    return results


@pytest.mark.parametrize(
    ("block", "inputs", "expected"),
    [
        (OnDelay("30 ms"), "0111111001110", "0000111000000"),
        (OnDelay("0 ms"), "0110", "0110"),
        (OnDelay("25 ms"), "11111", "00011"),  # between two scans: the first one after
        (OffDelay("30 ms"), "0110000011001000", "0111110011111111"),
        (OffDelay("0 ms"), "0110", "0110"),
        (OffDelay("30 ms"), "0000", "0000"),
        (Pulse("30 ms"), "0100000", "0111000"),
        (Pulse("30 ms"), "0111111", "0111000"),  # as long as its time, and once for a rise
        (Pulse("30 ms"), "01010100101", "01110111001"),  # no rise while it runs, its last scan included
        (Rise(), "0110100", "0100100"),
        (Rise(), "10", "10"),
        (Fall(), "0110100", "0001010"),
        (Fall(), "00", "00"),
        (Counter(2), "0101101", "0001111"),
        (DownCounter(2), "0101", "1111"),  # not loaded: it stands at 0
    ],
)
def test_diagrams(block, inputs, expected):
    assert played(block, inputs) == expected


def test_elapsed_times():
    """ET stands at the preset while the input stays, and falls to 0 with it."""
    clock = Clock()
    timers = OnDelay("20 ms"), OffDelay("20 ms"), Pulse("20 ms")
    for timer in timers:
        timer.attach({}, clock)
    seen = []
    for level in (True, True, True, True, False, False, False, False):
        for timer in timers:
            timer(level)
        seen.append([timer.elapsed_ns // 1_000_000 for timer in timers])
        clock.now_ns += 10_000_000
    on, off, pulse = zip(*seen, strict=True)
    assert on == (0, 10, 20, 20, 0, 0, 0, 0)
    assert off == (0, 0, 0, 0, 0, 10, 20, 20)
    assert pulse == (0, 10, 20, 20, 0, 0, 0, 0)


def test_counts():
    up, down = Counter(2), DownCounter(2)
    assert [up(level, reset=reset) for level, reset in ((1, 0), (0, 0), (1, 0), (1, 1), (0, 0))] == [
        False,
        False,
        True,
        False,
        False,
    ]
    assert down(False, load=True) is False
    assert [(down(level), down.value) for level in (1, 0, 1, 0, 1)] == [
        (False, 1),
        (False, 1),
        (True, 0),
        (True, 0),
        (True, -1),
    ]


def test_counters_stop_at_the_ends_of_a_dint():
    up, down = Counter(1), DownCounter(1)
    up.value, down.value = 2**31 - 1, -(2**31)
    up(True)
    down(True)
    assert (up.value, down.value) == (2**31 - 1, -(2**31))


@pytest.mark.parametrize("make", [lambda: Counter(2**31), lambda: OnDelay("soon"), lambda: Pulse("5")])
def test_what_they_refuse(make):
    with pytest.raises(ValueError, match=r"out of range|is not a time"):
        make()


class Lamps(Logic):
    start = Input("start")
    late: Output = Output("Local:2:O.Data.0")
    delay = OnDelay("10 ms")
    presses = Counter(2)

    def every_scan(self):
        self.late = self.delay(self.start)
        self.presses(self.start)


def test_they_run_in_the_time_of_the_scan_and_begin_anew_after_program_mode():
    bench = SequenceBench(Lamps).press(0).scan(5)
    assert not bench.lamp(0)
    bench.scan()
    assert bench.lamp(0)
    assert (bool(bench.logic.delay), bench.logic.presses.value) == (True, 1)
    bench.restart().scan()
    assert (bench.lamp(0), bench.logic.presses.value) == (False, 1)


def test_instances_share_nothing():
    one, other = SequenceBench(Lamps), SequenceBench(Lamps)
    one.press(0).scan(10)
    other.scan(10)
    assert (one.lamp(0), other.lamp(0)) == (True, False)


def test_a_timer_needs_the_time_of_a_rack():
    with pytest.raises(ValueError, match="has no time before the first scan"):
        OnDelay("1 s")(True)

    class Made(Logic):
        def __init__(self):
            self.delay = OnDelay("1 s")

    with pytest.raises(ValueError, match=r"test_blocks\.py:\d+: delay is made by an instance"):
        SequenceBench(Made)
