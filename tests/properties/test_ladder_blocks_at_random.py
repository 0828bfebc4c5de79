"""Blocks in any order, for any time: the laws of their outputs, and no command that the 3601 refuses."""

import pytest
from amounts import amount
from blocks3601 import ERROR_STOP, BlocksBench
from hypothesis import given, settings
from hypothesis import strategies as st

LEGAL = {
    "SetPosition": {"Position": 100},
    "Move": {"Position": 2_000},
    "Relative": {"Distance": -700},
    "Velocity": {"Velocity": -3_000},
    "Halt": {},
    "Stop": {},
    "Reset": {},
    "Register": {"Distance": 3_000},
    "Minimum": {"Distance": 10},
    "Probe": {},
}

RESULTS = ("Done", "CommandAborted", "Error")

# a request that comes one to five scans after another meets the axis in each of its steps
scans = st.integers(1, 5) | st.integers(1, 400)
steps = st.lists(st.tuples(st.sampled_from(sorted(LEGAL)), st.booleans(), scans), min_size=1, max_size=12)

LONGEST = 3_000
"""Scans in which every motion of `LEGAL` but a manual one ends."""


@pytest.mark.slow
@pytest.mark.parametrize("rpi_ms", [None, 5])
@settings(max_examples=amount(8))
@given(steps=steps)
def test_laws_of_the_outputs(rpi_ms, steps):
    """One of Busy and the results at most; Active within Busy; an ErrorID with Error; no refused command.

    CMD-07 alone may come: a Hold that reaches a move in the moment of its end. The axis resets it itself.
    """
    bench = BlocksBench.ready(rpi_ms=rpi_ms)
    executing: set[str] = set()
    said = {each: bench.said(each) for each in LEGAL}
    for name, on, scans in steps:
        if on:
            bench.go(name, **LEGAL[name])
            executing.add(name)
        else:
            bench.drop(name)
            executing.discard(name)
        for scan in range(scans):
            bench.scan()
            for each in LEGAL:
                said[each] = check_law(bench, each, said[each], executing)
            if scan > 40 and bench.state == 1:
                break  # at rest: nothing new comes
    assert set(bench.diary.fired) <= {"CMD-07", "POS-02"}
    assert bench.state != ERROR_STOP
    assert_all_ends(bench)


def assert_all_ends(bench):
    """Every request ends: an axis at rest that waits for nothing has no block that is Busy."""
    bench.drop(*LEGAL)
    for _ in range(LONGEST):
        bench.scan()
        if bench.tags["Axis.Step"] == 0 or bench.said("Velocity") >= {"InVelocity"}:
            break
    bench.scan(2)  # a block sees its result in the scan behind the axis's
    if bench.tags["Axis.Step"] == 0:
        busy = {each for each in LEGAL if "Busy" in bench.said(each)}
        assert busy <= {"Probe"}, f"at rest, and still busy: {busy}"


def check_law(bench, name, before, executing):
    """Check what a block says after a scan, `before` being what it said before it; return it."""
    said = bench.said(name)
    results = said.intersection(RESULTS)
    assert len(results) + ("Busy" in said) <= 1, (name, said)
    assert "Active" not in said or "Busy" in said, (name, said)
    assert (bench.tags[f"{name}.ErrorID"] != 0) == ("Error" in said), (name, said)
    if name in executing:
        assert said, f"{name}.Execute is on and nothing is told"
    elif results:
        assert "Busy" in before or not before, f"{name} shows {results} for more than a scan"
    return said


def test_every_image_is_a_whole_command():
    """All eight words change in one scan: those of a move are never seen beside the bit of another."""
    bench = BlocksBench.ready()
    bench.diary.images.clear()
    bench.go("Move", Position=2_001).until("Move", "Done").go("Velocity", Velocity=3_002).run(300)
    bench.go("Relative", Distance=-4_003, Velocity=2_004).until("Relative", "Done").go("Halt").run(50)
    rates = (20, 10)
    wholes = {
        (0, 0, 0, 0, 0, 0, 0, 0),
        (1, 0, 2, 1, 5, 0, *rates),
        (0, 0, 2, 1, 5, 0, *rates),  # its command word zeroed once it moves
        (0x80, 0, 0, 0, 3, 2, *rates),
        (0, 0, 0, 0, 3, 2, *rates),  # let go; the deceleration stays
        (2, 0, -4, -3, 2, 4, *rates),
        (0, 0, -4, -3, 2, 4, *rates),
    }
    assert set(bench.diary.images) == wholes


PAIRS = [("SetPosition", "Relative"), ("Move", "Halt"), ("Reset", "Move")]


@pytest.mark.parametrize("scans", range(1, 12))
@pytest.mark.parametrize(("first", "second"), PAIRS)
def test_a_request_during_another_one_is_carried_out(first, second, scans):
    """However soon the second request comes: the axis takes it, and it ends."""
    bench = BlocksBench.ready()
    bench.go(first, **LEGAL[first]).scan(scans).go(second, **LEGAL[second]).until(second, "Done", 2_000)
    assert bench.position == {"Relative": 100 - 700, "Move": 2_000}.get(second, bench.position)


def test_a_request_that_waited_for_an_axis_that_failed_is_refused():
    """The first move has an illegal profile: the second one, a scan later, meets ErrorStop [ErrorID 64]."""
    bench = BlocksBench.ready()
    bench.go("Move", Position=2_000, Velocity=5).scan().go("Relative", Distance=-700).run(100)
    assert (bench.state, bench.position) == (ERROR_STOP, 0)
    assert (bench.said("Relative"), bench.tags["Relative.ErrorID"]) == ({"Error"}, 64)
