"""One list of tests for three hardwares: a 3601, and the adapters that take its place [manual, chapters 2 to 6].

What a story expects is what the 3601's manual says. Times are long enough for the slowest
hardware: at 5,000 steps/s and ramps of 20 steps/ms/s a move of n steps takes a 3601 0.16 s + n / 5000;
a poll over a line and the gentler ramps of a PMC006 add less than a second.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import pytest
from scanrack.io_images import Image
from scanrack.io_images.amci3601 import (
    Acceleration,
    Direction,
    Hold,
    ImmediateStop,
    InputBit,
    Manual,
    Move,
    MoveKind,
    PresetPosition,
    ResetErrors,
    Resume,
)
from scanrack.runtime.machine import Switch
from three_hardwares import (
    HARDWARES,
    IDLE,
    PCL601,
    PMC006,
    START,
    Refusal,
    Step,
    Teller,
)

CW, CCW = Direction.CW, Direction.CCW
DONE, WRONG = {"MOVE_COMPLETE"}, {"COMMAND_ERROR"}
PROFILE = {"INVALID_PROFILE", "COMMAND_ERROR"}
HOME_SWITCH = Switch(InputBit.HOME, None, -3000)
CW_LIMIT = Switch(InputBit.CW_LIMIT, 9000, None)
CCW_LIMIT = Switch(InputBit.CCW_LIMIT, None, -9000)


def absolute(target: int, speed: int = 5000, up: int = 20, down: int = 20) -> Image:
    return Move(MoveKind.ABSOLUTE, target, speed, up, down).to_image()


def relative(
    steps: int, speed: int = 5000, up: int = 20, down: int = 20, shape: Acceleration = Acceleration.CONSTANT
) -> Image:
    return Move(MoveKind.RELATIVE, steps, speed, up, down, shape).to_image()


def manual(direction: Direction, speed: int = 5000, registration: int = 0) -> Image:
    return Manual(direction, speed, 100, 100, registration).to_image()


@dataclass(frozen=True)
class Story:
    """A story.

    Attributes:
        name: of the test.
        steps: see `three_hardwares`.
        switches: on the machine.
        options: of a hardware, by its name.
        begin: the steps before the first one.
    """

    name: str
    steps: tuple[Step, ...]
    switches: tuple[Switch, ...] = ()
    options: dict[str, dict] = field(default_factory=dict)
    begin: tuple[Step, ...] = START


MOVING_CW = Step(relative(20_000, 5000, 100, 100), 1000, {"MOVING_CW"}, (2000, 6000))
"""One second of a move that takes four: past the ramp, far from the end."""

NO_HOLD = {PMC006: Refusal({"COMMAND_ERROR"}, "hold")}
NO_RESPEED = {PCL601: Refusal(PROFILE, "speed change"), PMC006: Refusal(PROFILE, "speed change")}
NO_BLEND = {
    PCL601: Refusal({"INVALID_PROFILE"}, "blend move"),
    PMC006: Refusal({"INVALID_PROFILE"}, "blend move"),
}
NO_REGISTRATION = {PMC006: Refusal(PROFILE, "registration move")}
NO_HOME_CW = {PMC006: Refusal({"HOME_INVALID", "COMMAND_ERROR"}, "find home CW")}
SEGMENTED = {PCL601: {"blend": "segmented"}, PMC006: {"blend": "segmented"}}

BLEND_PROGRAM = (
    Step(Image([0, 256]), 100, {"BLEND_MODE", "BLEND_NEXT"}, 0, NO_BLEND),
)

STORIES = (
    Story(
        "moves to and fro",
        (
            Step(absolute(10_000), 4000, DONE, 10_000),
            Step(IDLE, 100, DONE, 10_000),
            Step(absolute(-2500), 5000, DONE, -2500),
            Step(IDLE, 100, DONE, -2500),
            Step(relative(4001), 3000, DONE, 1501),
            Step(IDLE, 100, DONE, 1501),
            Step(absolute(1501), 300, DONE, 1501),  # no way to go: complete at once
        ),
    ),
    Story(
        "ramps of every shape end on the step",
        (
            Step(relative(5000, shape=Acceleration.TRIANGULAR), 4000, DONE, 5000),
            Step(IDLE, 100, DONE),
            Step(relative(-4999, shape=Acceleration.TRAPEZOIDAL), 4000, DONE, 1),
            Step(IDLE, 100, DONE),
            Step(relative(5000, 5000, 20, 10), 4000, DONE, 5001),
        ),
    ),
    Story(
        "moves without a ramp, and too short for one",
        (
            Step(relative(1000, 1000), 2000, DONE, 1000),
            Step(IDLE, 100, DONE),
            Step(relative(-20), 1000, DONE, 980),
            Step(IDLE, 100, DONE),
            Step(relative(1), 1000, DONE, 981),
        ),
    ),
    Story(
        "a command counts once, at its edge",
        (
            Step(relative(100), 1000, DONE, 100),
            Step(relative(200), 1000, DONE, 100),
            Step(IDLE, 100, DONE, 100),
            Step(relative(200), 1000, DONE, 300),
        ),
    ),
    Story(
        "a position that is not known is no place to go from",
        (Step(absolute(100), 500, WRONG | {"POSITION_INVALID"}, 0),),
        begin=START[:2],
    ),
    Story(
        "an immediate stop leaves the position unknown until it is preset",
        (
            MOVING_CW,
            Step(ImmediateStop().to_image(), 500, {"STOPPED", "POSITION_INVALID"}, (2000, 7000)),
            Step(IDLE, 100, {"STOPPED", "POSITION_INVALID"}),
            Step(absolute(0), 500, {"STOPPED", "POSITION_INVALID", "COMMAND_ERROR"}),
            Step(ResetErrors().to_image(), 100, {"STOPPED", "POSITION_INVALID"}),
            Step(PresetPosition(-1234).to_image(), 100, {"STOPPED"}, -1234),
            Step(IDLE, 100, {"STOPPED"}, -1234),
            Step(absolute(0), 2000, DONE, 0),
        ),
    ),
    Story(
        "a move that is held goes on to its target",
        (
            MOVING_CW,
            Step(Hold().to_image(), 1000, {"HOLD_STATE"}, (3000, 8000), NO_HOLD),
            Step(IDLE, 100, {"HOLD_STATE"}),
            Step(Resume(4000, 50, 50).to_image(), 8000, DONE, 20_000),
        ),
    ),
)


@pytest.mark.parametrize("hardware", HARDWARES)
@pytest.mark.parametrize("story", STORIES, ids=lambda story: story.name)
def test_one_story_three_hardwares(story, hardware):
    teller = Teller(hardware, story.switches, story.options.get(hardware))
    teller.tell((*story.begin, *story.steps))
