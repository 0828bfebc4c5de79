"""Scans by rows show what scans by phases show: every image, event and instant, and the trace's bytes.

Waiting and the least size of a block are set to 1, so that blocks begin and end at every odd place.
"""

from __future__ import annotations

import pytest
from ahead3601 import Rig, played, replayed
from hypothesis import given, settings
from scanrack.runtime.loop import ahead, scans_ahead
from steps3601 import Wait
from stories3601 import THEMES
from stories_ahead import stories

pytestmark = pytest.mark.slow


@pytest.fixture(autouse=True)
def _impatient(monkeypatch):
    monkeypatch.setattr(scans_ahead, "LEAST_ROWS", 1)
    for name, value in (("SHORTEST_WAIT", 1), ("LONGEST_WAIT", 2), ("FEWEST_ROWS", 40)):
        monkeypatch.setattr(ahead.Patience, name, value)


@pytest.mark.parametrize("theme", THEMES)
def test_rows_show_what_phases_show(theme):
    @settings(max_examples=settings().max_examples // 3)
    @given(story=stories(theme))
    def lockstep(story):
        script = played(*story)
        assert_same(replayed(script, ahead=False), replayed(script, ahead=True))

    lockstep()


def assert_same(slow: Rig, fast: Rig):
    """Compare all that the listeners have been told, and what the logic could see of the exchange."""
    for ours, theirs in zip(fast.diary.told, slow.diary.told, strict=False):
        assert ours == theirs
    assert len(fast.diary.told) == len(slow.diary.told)
    assert fast.fresh == slow.fresh
    assert fast.seen == slow.seen
    assert fast.stepper.indicators == slow.stepper.indicators
    assert fast.stepper.machine_at(fast.cpu.now_ns).shaft == slow.stepper.machine_at(slow.cpu.now_ns).shaft


@pytest.mark.parametrize("theme", ["moves", "encoder"])
def test_traces_are_equal_byte_for_byte(tmp_path, theme):
    @settings(max_examples=settings().max_examples // 6)
    @given(story=stories(theme))
    def same_bytes(story):
        world, steps = story
        script = played(world, [*steps, Wait(2_000)])
        replayed(script, ahead=False, trace=tmp_path / "slow.mcap")
        replayed(script, ahead=True, trace=tmp_path / "fast.mcap")
        assert (tmp_path / "fast.mcap").read_bytes() == (tmp_path / "slow.mcap").read_bytes()

    same_bytes()
