"""The instant of no return is where the conditions say; `benchmarks/inevitable.py` measures all ten."""

from __future__ import annotations

import pytest
from inevitable_programs import failures
from scanrack.jobs.fuzz.explain.futures import Inevitable, inevitable

PLANTED = dict(failures())


@pytest.mark.slow
def test_two_buttons_in_one_scan_are_the_instant() -> None:
    planted = PLANTED["same scan"]
    found = inevitable(*planted.found())
    assert (found.before, found.scan, found.many) == (planted.scan - 1, planted.scan, 40)
    assert found.lines[1:] == [
        "  0.154 s: input a of slot 2 is operated for 8 ms",
        "  0.154 s: input b of slot 2 is operated for 18 ms",
    ]


def test_the_failures_happen_where_their_arithmetic_says() -> None:
    for planted in PLANTED.values():
        planted.found()


def test_what_a_report_says() -> None:
    sudden = Inevitable(4, 5, 10_000_000, 0, 37, 0, ("HOME of slot 1 came on",))
    assert sudden.lines == [
        "up to scan 4 no future of 40 breaks it, from scan 5 (0.01 s) on 37 do:",
        "  HOME of slot 1 came on",
    ]
    slow = Inevitable(1638, 1639, 3_278_000_000, 14, 21, 3)
    assert slow.lines == ["no single instant: 3 of 40 futures break it from 0 s, 21 from 3.278 s on"]
    assert Inevitable(-1, 0, 0, 0, 38, 38).lines == ["from power-up on 38 of 40 futures break it"]
