"""Sequences of commands: what they reach, how they shrink, that they replay, what they depend on."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from amounts import amount
from hypothesis import HealthCheck, Phase, find, given, seed, settings
from hypothesis.database import InMemoryExampleDatabase
from hypothesis.stateful import run_state_machine_as_test
from scanrack.io_images import Image
from scanrack.io_images import strategies as images
from scanrack.io_images.amci3601 import KNOWN, CommandLsw, Firmware, StatusLsw, StatusMsw

PAGE = (Path(__file__).parents[2] / "docs" / "strategies.md").read_text(encoding="utf-8")
SLOW = [HealthCheck.too_slow, HealthCheck.data_too_large]


def axis_of_the_page():
    """Return the state machine of docs/strategies.md."""
    block = next(
        block for block in re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL) if "class Axis" in block
    )
    names = {"images": images, "Image": Image}
    exec(compile(block, "docs/strategies.md", "exec"), names)
    return names["Axis"]


def never(bit):
    """Return the state machine of the page with a law that a bit breaks as soon as it is reached."""

    axis: Any = axis_of_the_page()

    class Broken(axis):
        def play(self, act):
            self.played.append(act.name)
            super().play(act)

        def __init__(self):
            self.played = []
            super().__init__()

        def check(self, msw, lsw):
            word = msw if isinstance(bit, StatusMsw) else lsw
            assert not word & bit, f"{bit.name} after {self.played}"

    return Broken


def run(machine, phases=(Phase.generate, Phase.shrink), **chosen):
    chosen_settings = settings(
        deadline=None, stateful_step_count=8, suppress_health_check=SLOW, phases=phases, **chosen
    )
    run_state_machine_as_test(machine, settings=chosen_settings)


@pytest.mark.slow
def test_a_hundred_machines_reach_the_deep_states():
    axis = axis_of_the_page()
    run(axis, max_examples=100, derandomize=True, database=None)
    wanted = {"AT_HOME", "HOLD_STATE", "BLEND_RUNNING", "MOVE_COMPLETE", "STOPPED", "BLEND_ACK"}
    wanted |= {
        "ENC_FOLLOWER",
        "MIN_REG_NONZERO",
        "COMMAND_ERROR",
        "INVALID_PROFILE",
        "HOME_INVALID",
        "IN_HOME",
    }
    assert wanted - set(axis.reached) == set()
    assert axis.reached["COMMAND_ERROR"] < axis.reached["MODULE_OK"] / 20


@pytest.mark.slow
@pytest.mark.parametrize(
    ("bit", "last"),
    [
        (StatusMsw.AT_HOME, "home"),
        (StatusMsw.HOLD_STATE, "held move"),
        (StatusLsw.BLEND_RUNNING, "blend move"),
    ],
    ids=lambda value: getattr(value, "name", None),
)
def test_a_failure_shrinks_to_the_one_act_that_it_takes_and_is_replayed(bit, last):
    database = InMemoryExampleDatabase()
    with pytest.raises(AssertionError) as caught:
        run(seed(0)(never(bit)), max_examples=100, derandomize=False, database=database)
    assert f"{bit.name} after ['configure', '{last}']" in str(caught.value)
    replayed = never(bit)
    with pytest.raises(AssertionError) as again:  # without a draw of its own
        run(replayed, max_examples=1, phases=[Phase.reuse], database=database)
    assert str(again.value) == str(caught.value)


DRAW = """
import sys, hashlib, json
sys.path.insert(0, {folder!r})
{imports}
from hypothesis import HealthCheck, Phase, given, settings
from scanrack.io_images import strategies as images
digest = hashlib.sha256()

@settings(max_examples=60, derandomize=True, database=None, deadline=None, phases=[Phase.generate],
          suppress_health_check=list(HealthCheck))
@given(images.sequences())
def draw(acts):
    digest.update(repr(acts).encode())

draw()
print(digest.hexdigest())
"""


@pytest.mark.slow
def test_the_same_sequences_are_drawn_whatever_modules_are_loaded(tmp_path):
    """Hypothesis takes constants from a user's modules: here every number that a draw could take for one."""
    numbers = ", ".join(map(str, range(100, 3_000)))
    (tmp_path / "mine.py").write_text(
        f"NUMBERS = [{numbers}]\nBYTES = [b'abc', b'\\x01\\x02']\n", encoding="utf-8"
    )
    drawn = []
    for imports in ("", "import mine", "import scanrack.runtime.modules.amci3601, scanrack.traces"):
        code = DRAW.format(folder=str(tmp_path), imports=imports)
        done = subprocess.run(
            [sys.executable, "-c", code],
            capture_output=True,
            text=True,
            check=True,
            cwd=tmp_path,
            encoding="utf-8",
        )
        drawn.append(done.stdout)
    assert len(set(drawn)) == 1


@pytest.mark.slow
def test_the_plainest_sequence():
    """Configuring once more takes no draw but that of the kind, so it is the plainest act."""
    every_phase = settings(phases=list(Phase))
    plainest = find(images.sequences(), lambda acts: True, settings=every_phase)
    assert [act.name for act in plainest] == ["configure", "configure"]


@seed(0)
@given(images.sequences(firmware=Firmware(2, 0)))
@settings(max_examples=50)
def test_old_firmware_is_given_nothing_that_it_does_not_know(acts):
    assert {act.name for act in acts}.isdisjoint({"registration move", "follower"})
    newer = (CommandLsw.ENC_FOLLOWER | CommandLsw.STORE_MIN_REG).value
    assert not any(
        showing.image[1] & newer for act in acts for showing in act.showings if showing.image[0] >= 0
    )


@pytest.mark.slow
@pytest.mark.parametrize("starting_speed", [1, 1000, 100_000])
@pytest.mark.parametrize("firmware", KNOWN, ids=str)
def test_every_starting_speed_gives_legal_words(starting_speed, firmware):
    """The classes of the commands refuse anything else when the words are made."""

    @given(images.sequences(starting_speed, firmware, most=20))
    @settings(max_examples=amount(10), derandomize=True, database=None)
    def drawn(acts):
        assert acts[0] == images.configuring(starting_speed)

    drawn()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: images.acts(0), "starting_speed 0 is out of range: must be 1 to 100000"),
        (lambda: images.configuring(100_001), "starting_speed 100001 is out of range"),
        (lambda: images.sequences(most=0), "most 0 is out of range: must be 1 to 99"),
    ],
)
def test_what_is_out_of_range_is_refused(call, message):
    with pytest.raises(ValueError, match=message):
        call()


def test_an_image_is_shown_until_the_motion_has_ended():
    shown = images.waiting(Image((2,)))
    assert not shown.is_over(Image((StatusMsw.MOVE_COMPLETE.value,)), 2)  # that of the move before
    assert not shown.is_over(Image((StatusMsw.MOVING_CW.value,)), 19_998)
    assert shown.is_over(Image((StatusMsw.MOVE_COMPLETE.value,)), 4)
    assert shown.is_over(Image(), 20_000)
    assert not images.Showing(Image(), 100).is_over(Image((StatusMsw.STOPPED.value,)), 98)
