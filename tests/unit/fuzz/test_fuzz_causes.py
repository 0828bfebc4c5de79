"""Failures of one invariant are kept apart by rule or place, and the search goes on behind a known one."""

from __future__ import annotations

from pathlib import Path

import pytest
from scanrack.io_images.amci3601 import Configuration, Idle, InputBit, Move, MoveKind, StatusView
from scanrack.jobs import Kind
from scanrack.jobs.fuzz import STANDARD, Press, Scenario, TrialBench, always, never, search, undisturbed
from scanrack.runtime import RackSpec

MS = 1_000_000
USED = InputBit.HOME | InputBit.EXTERNAL | InputBit.ESTOP | InputBit.CW_LIMIT | InputBit.CCW_LIMIT
WORDS = Configuration(inputs_used=USED, step_and_direction=True, starting_speed=500).to_image()
IDLE = Idle().to_image()
MOVE = Move(MoveKind.ABSOLUTE, 2000, speed=8000, acceleration=50, deceleration=50).to_image()
HERE = Path(__file__).name
SPEC = RackSpec.model_validate({"program": "none.py", "slot": [{"number": 1, "module": "amci3601"}]})


def line_of(text):
    """The number of the line of this file that ends with a remark."""
    lines = Path(__file__).read_text(encoding="utf-8").splitlines()
    return next(number for number, line in enumerate(lines, 1) if line.endswith(f"# {text}"))


def configured(go):
    """Return a maker of programs that configure the module, and then do what `go` says."""

    def logic(scan):
        status, out = StatusView(scan.slot[1].inputs), scan.slot[1].outputs
        if scan.number < 3:
            out.load(WORDS)
        elif status.MODE_CONFIG:
            out.load(IDLE)
        else:
            go(status, out, scan)

    return lambda: logic


def two_ways(status, out, _scan):
    if status.IN_HOME:
        out[0] = 3  # by home
    elif status.IN_EXTERNAL:
        out[0] = 0x0180  # by external
    else:
        out.load(IDLE)


def bench(program, *invariants):
    return TrialBench(SPEC, program, invariants, 150)


def found(report):
    return {each.broken.cause: each for each in report.found}


@pytest.mark.slow
def test_two_places_are_two_failures_each_with_its_own_smallest_scenario():
    planted = bench(configured(two_ways), STANDARD["one-motion"])
    by_cause = found(search(planted, {Kind.INPUTS}, examples=80))
    home, external = f"{HERE}:{line_of('by home')}", f"{HERE}:{line_of('by external')}"
    assert set(by_cause) == {home, external}
    assert [each.input for each in by_cause[home].scenario.presses] == [InputBit.HOME]
    assert [each.input for each in by_cause[external].scenario.presses] == [InputBit.EXTERNAL]


@pytest.mark.slow
def test_behind_a_failure_that_always_happens_another_is_found():
    """It sets two motion bits by itself at 20 ms; and, which is hidden behind that, later on a press."""

    def go(status, out, scan):
        if scan.number == 10:
            out[0] = 3  # by itself
        else:
            two_ways(status, out, scan)

    planted = bench(configured(go), STANDARD["one-motion"])
    at_once = undisturbed(planted, Scenario())
    assert [each.broken.cause for each in at_once] == [f"{HERE}:{line_of('by itself')}"]
    known = [each.broken.key for each in at_once]
    behind = found(search(planted, {Kind.INPUTS}, examples=80, known=known))
    assert set(behind) == {f"{HERE}:{line_of('by home')}", f"{HERE}:{line_of('by external')}"}


def test_a_failure_counts_once_until_it_holds_again():
    @never
    def pressed(now):
        return now.slot[1].status.IN_HOME

    press = Press(1, InputBit.HOME, True, 20 * MS, 60 * MS)
    planted = bench(configured(lambda _status, out, _scan: out.load(IDLE)), pressed)
    first = planted.run(Scenario(presses=(press,)))
    again = planted.run(Scenario(presses=(press,)), without={first.broken.key})
    assert (first.broken.now_ns, again.broken) == (22 * MS, None)  # the first scan after the press


@pytest.mark.slow
def test_rules_tell_failures_apart_before_places_do():
    """An absolute move without a position is refused by CMD-06, two motion bits by another rule."""

    def go(status, out, _scan):
        if status.IN_HOME:
            out[0] = 3
        else:
            out.load(MOVE if status.IN_EXTERNAL else IDLE)

    planted = bench(configured(go), STANDARD["no-command-error"])
    causes = set(found(search(planted, {Kind.INPUTS}, examples=80)))
    assert "CMD-06" in causes
    assert len(causes) == 2
    assert all(cause.startswith("CMD-") for cause in causes)


def changed_long_before(out, number):
    if number == 5:
        out[0] = 1  # long before


def changed_and_changed_back(out, number):
    if number == 5:
        out[0] = 1
    if number == 20:
        out[0] = 0
        out[0] = 1  # back again


def changed_and_changed_back_only(out, number):
    if number == 5:
        out[0] = 1
        out[0] = 0  # nothing remains


def changed_just_before(out, number):
    if number in (5, 99):
        out[0] = number  # just before


@pytest.mark.parametrize(
    ("change", "remark"),
    [
        (changed_long_before, "long before"),
        (changed_and_changed_back, "back again"),
        (changed_and_changed_back_only, "nothing remains"),
        (changed_just_before, "just before"),
    ],
)
def test_the_line_that_last_changed_an_output_is_found_wherever_it_ran(change, remark):
    """Only the last scans before the failure in scan 100 are traced at first, later as many as it takes."""

    @always
    def before_scan_100(now):
        return now.scan < 100

    planted = bench(lambda: lambda scan: change(scan.slot[1].outputs, scan.number), before_scan_100)
    broken = planted.run(Scenario()).broken
    assert (broken.scan, broken.cause) == (100, f"{HERE}:{line_of(remark)}")
