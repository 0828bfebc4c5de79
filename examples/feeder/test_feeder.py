"""The feeder as a story: how a program is tested on the bench. Run it with pytest."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from scanrack import open_bench
from scanrack.jobs.bench import Bench

RACK = Path(__file__).with_name("feeder.toml")


@pytest.fixture
def feeder() -> Iterator[Bench]:
    """The feeder, homed and about to begin its first stroke."""
    with open_bench(RACK) as bench:
        bench.run_until("Feeding", within="5 s")
        yield bench


def test_it_looks_for_home_before_it_feeds(feeder: Bench) -> None:
    # the home switch begins at -1,300: where it was found is the new 0
    assert feeder.slot[1].shaft == -1300
    assert feeder.slot[1].status.position == 0


def test_it_strokes_to_and_fro(feeder: Bench) -> None:
    feeder.run_until("Out.Done", within="3 s")
    assert feeder.slot[1].status.position == 6000
    feeder.run_until("Back.Done", within="3 s")
    assert feeder.slot[1].status.position == 0
    assert feeder["Strokes.ACC"] == 1


def test_an_emergency_stop_ends_the_stroke_at_once(feeder: Bench) -> None:
    feeder.run_until("Out.Active", within="1 s")
    feeder.run_until("Trouble", within="10 s")  # the rack file presses the button at 8 s
    assert not feeder.slot[1].moving
    assert "INP-01" in feeder.rules
    assert "slot 1 input IN_ESTOP" in feeder.why("Feeding")  # the position is lost, so it asks for home


def test_it_finds_its_way_back(feeder: Bench) -> None:
    feeder.run_until("Trouble", within="10 s")
    feeder.run_until(lambda bench: not bench["Trouble"], within="5 s")
    feeder.run_until("Homing", within="1 s")
    feeder.run_until("Feeding", within="5 s")
    assert feeder.slot[1].status.position == 0


def test_nothing_moves_while_the_button_is_in(feeder: Bench) -> None:
    feeder.run_until("Trouble", within="10 s")
    shaft = feeder.slot[1].shaft
    feeder.run_for("400 ms")  # of the 500 ms that the button is in
    assert feeder.slot[1].shaft == shaft


def test_a_stroke_waits_for_a_forced_condition(feeder: Bench) -> None:
    feeder.force("OutGo", 0)
    feeder.run_until("Back.Done", within="3 s")
    feeder.run_for("2 s")
    assert feeder["Strokes.ACC"] == 1
    assert "forced" in feeder.why("OutGo")
