"""Random runs of the module, runs of both adapters and all golden recordings keep the contracts of the 3601.

The rows that are planted say a little more than the manual. Each is found out, so the search is not blind.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from adapterbench import BENCHES, CONFIGURE_006, move
from amounts import amount
from contracts3601 import Broken, check_of, play, wild
from hypothesis import given, settings
from hypothesis import strategies as st
from scanrack.io_images.amci3601 import CommandLsw, CommandMsw, StatusLsw
from scanrack.io_images.amci3601.contracts import Contract, contracts_of
from scanrack.io_images.amci3601.contracts import rows as the
from scanrack.io_images.amci3601.contracts.fact import now, sent, was
from scanrack.runtime.modules.amci3601 import CommandLayer
from scanrack.runtime.modules.amci3601.latches import STOPPED
from scanrack.traces import open_trace
from stories3601 import scripts

SHOWS_A_CUT = 37
"""A seed whose run ends a motion without a ramp."""

GOLDEN = Path(__file__).parents[2] / "tests" / "golden" / "recordings"
AFTER_CONFIGURATION = the.IN_COMMAND_MODE & was(the.OK) & was(the.MODE)
SAY_TOO_MUCH = {
    "lost only with Stopped": the.rises(the.POSITION_INVALID).only_with(now(the.STOPPED) | the.POWERED_UP),
    "lost only in run mode": the.rises(the.POSITION_INVALID).only_with(now(the.STOPPED, the.HOME_INVALID)),
    "found only by Preset": the.falls(the.POSITION_INVALID).only_with(sent(the.PRESET)),
    "found only at home": the.falls(the.POSITION_INVALID).only_with(now(the.AT_HOME)),
    "complete only after a motion": the.rises(the.MOVE_COMPLETE).only_with(was(*the.MOVING)),
    "complete only while commanded": the.rises(the.MOVE_COMPLETE).only_with(sent(*the.STARTS)),
    "held only after a motion": the.rises(the.HOLD_STATE).only_with(was(*the.MOVING)),
    "command error only reset": the.falls(the.COMMAND_ERROR).only_with(sent(the.RESET)),
    "input error only reset": the.falls(the.INPUT_ERROR).only_with(sent(the.RESET)),
    "home invalid only reset": the.falls(the.HOME_INVALID).only_with(sent(the.RESET)),
    "no motion on a limit": (the.IN_COMMAND_MODE & now(StatusLsw.IN_CW_LIMIT)).only_with(~now(*the.MOVING)),
    "complete and valid": (the.IN_COMMAND_MODE & now(the.MOVE_COMPLETE)).only_with(
        ~now(the.POSITION_INVALID)
    ),
    "emergency stop is an error": (the.IN_COMMAND_MODE & now(StatusLsw.IN_ESTOP)).only_with(
        now(the.INPUT_ERROR)
    ),
    "emergency stop ends all": (the.IN_COMMAND_MODE & now(StatusLsw.IN_ESTOP)).only_with(~now(*the.MOVING)),
    "acknowledged only on command": (the.IN_COMMAND_MODE & now(the.BLEND_ACK)).only_with(sent(the.TRANSMIT)),
    "locked also without a result": (
        the.STAYS_IN_COMMAND_MODE & was(the.COMMAND_ERROR) & ~was(*the.MOVING)
    ).only_with(~now(*the.MOVING)),
    "motion only on command": (the.STAYS_IN_COMMAND_MODE & ~was(*the.MOVING) & now(*the.MOVING)).only_with(
        sent(*the.STARTS) | sent(the.FOLLOW)
    ),
    "home stays zero": (the.IN_COMMAND_MODE & now(the.AT_HOME)).only_with(the.words(0, 0, 2, 3)),
    "never preset after a configuration": AFTER_CONFIGURATION.only_with(now(the.POSITION_INVALID)),
    "echo of the proximity": the.STAYS_IN_COMMAND_MODE.only_with(
        now(StatusLsw.HOME_PROX_ECHO).same_as(sent(CommandLsw.HOME_PROXIMITY))
    ),
    "configuration left only on command": AFTER_CONFIGURATION.only_with(~sent(CommandMsw.MODE_CONFIG)),
    "home only after a motion": the.rises(the.AT_HOME).only_with(was(*the.MOVING)),
    "no negative rest": the.IN_COMMAND_MODE.only_with(the.words(0, 999, 3)),
}


@settings(max_examples=amount(25), deadline=None)
@given(seed=st.integers(0, 1 << 32))
def test_no_run_at_random_breaks_one(seed):
    wild(seed, 200)


@settings(max_examples=amount(15), deadline=None)
@given(script=scripts(), ticks=st.sampled_from((None, 4, 40, 4000)), seed=st.none() | st.integers(0, 1 << 32))
def test_no_story_breaks_one(script, ticks, seed):
    play(script, ticks, seed)


def recorded():
    """Yield inputs before, outputs and inputs of each scan of the golden recordings."""
    for path in sorted(GOLDEN.glob("*.mcap")):
        was, sent = None, None
        with open_trace(path) as trace:
            for scan in trace.scans():
                slot = min(scan.places)
                inputs = tuple(scan.inputs(slot))
                yield path.stem, inputs, was, sent
                was, sent = inputs, tuple(scan.outputs(slot))


def test_no_golden_recording_breaks_one():
    check = check_of()
    assert [each for each in recorded() if check(*each[1:])] == []


@pytest.mark.slow
def test_rows_that_say_more_than_the_manual_are_found_out():
    left = {name: Contract(name, name, (), fact) for name, fact in SAY_TOO_MUCH.items()}
    for _, *images in recorded():
        drop(left, check_of_all(left), images)
    for seed in range(400):
        check = check_of_all(left)
        if not left:
            break

        def noted(now, was, sent, check=check):
            drop(left, check, (now, was, sent))
            return ()

        wild(seed, 200, noted)
    assert sorted(left) == []


_checks: dict[tuple[str, ...], object] = {}


def check_of_all(left):
    """Return the check of the rows that are left, compiled once for each choice."""
    key = tuple(left)
    if key not in _checks:
        _checks[key] = check_of(tuple(left.values()))
    return _checks[key]


def drop(left, check, images):
    """Drop the rows that images break."""
    for row in check(*images):
        left.pop(row.name, None)


@pytest.mark.parametrize("kind", ["PCL601", "PMC006", "drive"])
def test_adapters_keep_the_rows_that_say_so(kind):
    """A move, a hold, a reversed and a manual move, with the line down in one of them."""
    options: Any = {"hold": "immediate", "registration": "polled"} if kind == "PMC006" else {}
    bench = BENCHES[kind](**options)
    check, images, update = check_of(contracts_of(adapter=True)), [], bench.module.update

    def watched(now_ns, outputs):
        image = update(now_ns, outputs)
        images.append(tuple(image))
        assert check(images[-1], *((images[-2], tuple(outputs)) if len(images) > 1 else (None, None))) == []
        return image

    bench.module.update = watched  # type: ignore[method-assign]
    bench.configured(*CONFIGURE_006) if kind == "PCL601" else bench.configured()
    rates = (4, 0, 100, 100)
    for words in (
        *move(1500, 4000, 100, 100),
        (4,),
        (8, 0, 0, 0, *rates),
        (128, 0, 0, 0, *rates),
        (),
        (0x10,),
    ):
        bench.give(*(words if isinstance(words, tuple) else (words,)), ms=150)
    line = bench.module.controller.line
    line.take_down()
    bench.run(600)
    line.put_up()
    bench.run(300)
    assert len({image[0] for image in images}) > 5


def test_a_module_that_forgets_stopped_is_found(monkeypatch):
    """The motion ends without Stopped (chapter 6, Stopped 2 to 4)."""
    finish = CommandLayer.finish

    def without_stopped(layer, now_ns, completion, how):
        finish(layer, now_ns, completion & ~STOPPED, how)

    monkeypatch.setattr(CommandLayer, "finish", without_stopped)
    with pytest.raises(Broken, match="position lost"):
        wild(SHOWS_A_CUT, 200)
