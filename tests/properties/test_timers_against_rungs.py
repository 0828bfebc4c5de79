"""Timers, edges and counters as objects against the instructions of rungs, over random inputs."""

from hypothesis import given
from hypothesis import strategies as st
from ladder_bench import program_of
from scanrack.ladder.python.sequences import Counter, DownCounter, Fall, OffDelay, OnDelay, Rise
from scanrack.ladder.python.sequences.parts import Clock

PROGRAM = program_of(
    "TAG X : BOOL\nTAG R : BOOL\nTAG On : TIMER\nTAG Off : TIMER\nTAG Up : COUNTER\nTAG Down : COUNTER\n"
    "TAG A : BOOL\nTAG B : BOOL\nTAG C : BOOL\nTAG D : BOOL",
    "XIC(X)TON(On,?,?);",
    "XIC(X)TOF(Off,?,?);",
    "XIC(X)CTU(Up,?,?);",
    "XIC(R)RES(Up);",
    "XIC(X)CTD(Down,?,?);",
    "XIC(X)OSR(A,B);",
    "XIC(X)OSF(C,D);",
)

scans = st.lists(st.tuples(st.booleans(), st.integers(1, 40)), max_size=60)
"""Input, and ms since the scan before; the first input is off, since ladders take no edge there."""

presets = st.integers(0, 100)


@given(scans=scans, preset_ms=presets, count=st.integers(1, 8), resets=st.sets(st.integers(0, 60)))
def test_timers_edges_and_counters(scans, preset_ms, count, resets):
    """A CTD counts down from 0, a DownCounter from its preset: they differ by that.

    A ladder judges a counter only while its rung is true, and takes an input that stays on behind a RES for
    another rise; so the presets are from 1 on, and resets come while the input is off.
    """
    engine = PROGRAM.compile()
    tags = engine.tags
    tags["On.PRE"] = tags["Off.PRE"] = preset_ms
    tags["Up.PRE"], tags["Down.PRE"] = count, -count
    clock = Clock()
    on, off = OnDelay(f"{preset_ms} ms"), OffDelay(f"{preset_ms} ms")
    up, down, rise, fall = Counter(count), DownCounter(count), Rise(), Fall()
    for timer in (on, off):
        timer.attach({}, clock)
    down(False, load=True)
    for number, (level, ms) in enumerate([(False, 1), *scans]):
        clock.now_ns += ms * 1_000_000 if number else 0
        reset = number in resets and not level
        tags["X"], tags["R"] = level, reset
        engine.step(ms)
        expected = [tags[name] for name in ("On.DN", "Off.DN", "B", "D")]
        assert [on(level), off(level), rise(level), fall(level)] == expected, number
        assert on.elapsed_ns == min(tags["On.ACC"], preset_ms) * 1_000_000
        assert up(level, reset=reset) == tags["Up.DN"], number
        assert up.value == tags["Up.ACC"]
        assert down(level) == (tags["Down.ACC"] <= -count), number
        assert down.value == count + tags["Down.ACC"]
