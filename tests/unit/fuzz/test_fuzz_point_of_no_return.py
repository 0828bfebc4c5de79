"""The instant of no return is where the conditions say; `benchmarks/inevitable.py` measures all ten."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from inevitable_programs import failures
from scanrack.jobs.fuzz import Counterexample, Scenario, job
from scanrack.jobs.fuzz.explain.futures import PointOfNoReturn, find_point_of_no_return
from scanrack.jobs.fuzz.run import BrokenInvariant

PLANTED = dict(failures())
RECORDING = Path(__file__).parents[2] / "golden" / "recordings" / "cmd-32-follower-speed.mcap"


@pytest.mark.slow
def test_two_buttons_in_one_scan_are_the_instant() -> None:
    planted = PLANTED["same scan"]
    found = find_point_of_no_return(*planted.found())
    assert found is not None
    assert (found.before, found.scan, found.many) == (planted.scan - 1, planted.scan, 40)
    assert found.lines[1:] == [
        "  0.154 s: input a of slot 2 is operated for 8 ms",
        "  0.154 s: input b of slot 2 is operated for 18 ms",
    ]


def test_the_failures_happen_where_their_arithmetic_says() -> None:
    for planted in PLANTED.values():
        planted.found()


def test_no_instant_is_told_without_time_to_look_for_it() -> None:
    planted = next(iter(PLANTED.values()))
    assert find_point_of_no_return(*planted.found(), has_time=lambda: False) is None


def test_what_a_report_says() -> None:
    sudden = PointOfNoReturn(4, 5, 10_000_000, 0, 37, 0, ("HOME of slot 1 came on",))
    assert sudden.lines == [
        "inevitable from scan 5 (0.01 s): 37 of 40 random futures fail from there, none from scan 4:",
        "  HOME of slot 1 came on",
    ]
    slow = PointOfNoReturn(1638, 1639, 3_278_000_000, 14, 21, 3)
    assert slow.lines == ["no clear instant: 3 fail from 0 s, 21 of 40 random futures fail from 3.278 s"]
    at_once = PointOfNoReturn(-1, 0, 0, 0, 38, 38)
    assert at_once.lines == ["inevitable from power-up: 38 of 40 random futures fail"]


@pytest.mark.parametrize(("many", "marked"), [(40, True), (21, False)])
def test_the_chart_marks_the_instant_beside_the_failure(tmp_path, many, marked) -> None:
    """Only an instant at which the share of failing futures rises by most of them has a line."""
    shutil.copy(RECORDING, tmp_path / "trace.mcap")
    found = Counterexample(Scenario(), BrokenInvariant("held", "It holds", 9, 18_000_000, "it does not"), 1)
    page = job._draw_chart(found, PointOfNoReturn(4, 5, 10_000_000, 0, many, 0), tmp_path)[0]
    text = Path(page).read_text(encoding="utf-8")
    assert "held is broken" in text
    assert ("inevitable from scan 5 (0.01 s): 40 of 40 random futures fail from there" in text) is marked
