"""One list of tests for three hardwares: a 3601, and the adapters that take its place [chapters 2 to 6].

What a story or a configuration expects is what the 3601's manual says of it; where an adapter's
controller can't do it, that it says so in the 3601's own error bits, before anything moves.

The stories of the one list for three hardwares.

What a story expects is what the 3601's manual says. Times are long enough for the slowest
hardware: at 5,000 steps/s and ramps of 20 steps/ms/s a move of n steps takes a 3601 0.16 s + n / 5000;
a poll over a line and the gentler ramps of a PMC006 add less than a second.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import pytest
from scanrack.io_images import Image
from scanrack.io_images.amci3601 import (
    Acceleration,
    BlendHeader,
    BlendSegment,
    Direction,
    FindHome,
    Follower,
    Hold,
    ImmediateStop,
    InputBit,
    Manual,
    Move,
    MoveKind,
    PresetEncoder,
    PresetPosition,
    ResetErrors,
    Resume,
    RunBlend,
)
from scanrack.runtime.machine import Switch
from three_hardwares import (
    CONFIGURATION,
    HARDWARES,
    IDLE,
    INPUTS,
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


def released(words: Image) -> Image:
    """Return the words of a command without its bit, with its parameters."""
    return Image([0, *list(words)[1:]])


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


def configured(refused: Mapping[str, Refusal] | None = None, **changed: Any) -> tuple[Step, ...]:
    """Return how a story begins whose configuration has something else in it."""
    words = replace(CONFIGURATION, **changed).to_image()
    return replace(START[0], words=words, refused=refused or {}), *START[1:]


NEAR_HOME = FindHome(CW, 5000, 20, 20, proximity=True).to_image()

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

HEADER = BlendHeader((Acceleration.CONSTANT, Acceleration.CONSTANT), 20).to_image()
SEGMENTS = BlendSegment(4000, 3000, 20).to_image(), BlendSegment(3500, 5000, 20).to_image()
BETWEEN_BLOCKS = Step(Image([0, 256]), 100, set(), 0)


def blend_move(refused: dict[str, Refusal]) -> tuple[Step, ...]:
    """Return the steps of storing a profile of two segments and running it CCW."""
    blocks = [
        Step(HEADER, 100, {"BLEND_ACK"}, 0, refused),
        BETWEEN_BLOCKS,
        Step(SEGMENTS[0], 100, {"BLEND_ACK"}, 0),
        BETWEEN_BLOCKS,
        Step(SEGMENTS[1], 100, {"BLEND_ACK"}, 0),
        BETWEEN_BLOCKS,
    ]
    run = Step(RunBlend(CCW).to_image(), 8000, DONE, -7500)
    return (*blocks, Step(IDLE, 100, set(), 0), run)


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
        "a position that is not known is not a place to go from",
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
    Story(
        "a manual move lasts as long as its bit",
        (
            Step(manual(CW), 1000, {"MOVING_CW"}, (3000, 5000)),
            Step(IDLE, 1000, {"STOPPED"}, (3000, 6000)),
            Step(manual(CCW, 1000), 500, {"MOVING_CCW"}),
            Step(IDLE, 1000, {"STOPPED"}, (2000, 5800)),
        ),
    ),
    Story(
        "an immediate stop at rest",
        (Step(ImmediateStop().to_image(), 500, set(), 0),),
    ),
    Story(
        "another speed in a manual move",
        (
            Step(manual(CW), 1000, {"MOVING_CW"}),
            Step(manual(CW, 3000), 1500, {"MOVING_CW"}, None, NO_RESPEED),
        ),
    ),
    Story(
        "a limit ends a move, and is left by hand",
        (
            Step(absolute(20_000), 4000, {"STOPPED", "INPUT_ERROR", "POSITION_INVALID"}, (9000, 9500)),
            Step(IDLE, 100, {"STOPPED", "INPUT_ERROR", "POSITION_INVALID"}),
            Step(ResetErrors().to_image(), 100, {"STOPPED", "POSITION_INVALID"}),
            Step(IDLE, 100, {"STOPPED", "POSITION_INVALID"}),
            Step(manual(CCW, 2000), 1500, {"MOVING_CCW", "POSITION_INVALID"}),
            Step(IDLE, 1000, {"STOPPED", "POSITION_INVALID"}, (0, 9000)),
        ),
        (CW_LIMIT, CCW_LIMIT),
    ),
    Story(
        "a manual move into a limit",
        (Step(manual(CCW), 4000, {"STOPPED", "INPUT_ERROR", "POSITION_INVALID"}, (-9500, -9000)),),
        (CW_LIMIT, CCW_LIMIT),
    ),
    Story(
        "an emergency stop ends a move at once",
        (
            MOVING_CW,
            Step(
                None,
                500,
                {"STOPPED", "INPUT_ERROR", "POSITION_INVALID"},
                (2000, 7000),
                inputs={InputBit.ESTOP: True},
            ),
            Step(IDLE, 100, {"STOPPED", "INPUT_ERROR", "POSITION_INVALID"}),
            Step(None, 100, {"STOPPED", "INPUT_ERROR", "POSITION_INVALID"}, inputs={InputBit.ESTOP: False}),
            Step(ResetErrors().to_image(), 100, {"STOPPED", "POSITION_INVALID"}),
        ),
    ),
    Story(
        "home on the CCW side, and from there",
        (
            Step(FindHome(CCW, 2000, 20, 20).to_image(), 9000, {"AT_HOME"}, 0),
            Step(IDLE, 100, {"AT_HOME"}, 0),
            Step(absolute(5000), 3000, DONE, 5000),
        ),
        (HOME_SWITCH,),
        begin=START[:2],
    ),
    Story(
        "home on the CW side",
        (Step(FindHome(CW, 2000, 20, 20).to_image(), 9000, {"AT_HOME"}, 0, NO_HOME_CW),),
        (Switch(InputBit.HOME, 3000, 4000),),
    ),
    Story(
        "presets to the ends of the range",
        (
            Step(PresetPosition(8_388_607).to_image(), 100, set(), 8_388_607),
            Step(IDLE, 100, set()),
            Step(absolute(8_388_507), 1000, DONE, 8_388_507),
            Step(IDLE, 100, DONE),
            Step(PresetPosition(-8_388_607).to_image(), 100, DONE, -8_388_607),
        ),
    ),
    Story(
        "wrong parameters are told by the 3601's own rules, on all three",
        tuple(
            step
            for words in (
                relative(100, 999),  # below the starting speed
                Image([2, 0, 0, 100, 1000, 1, 20, 20]),  # 1,000,001 steps/s
                Image([2, 0, 0, 100, 5, 0, 0, 20]),  # no acceleration
                Image([2, 0, 0, 100, 5, 0, 20, 2001]),
                Image([2, 0, 1, -100, 5, 0, 20, 20]),  # words of two signs
            )
            for step in (
                Step(words, 300, PROFILE, 0),
                Step(IDLE, 100, PROFILE),
                Step(ResetErrors().to_image(), 100, set()),
                Step(IDLE, 100, set()),
            )
        ),
    ),
    Story(
        "two commands at once",
        (Step(Image([3, 0, 0, 100, 5, 0, 20, 20]), 500, WRONG, 0),),
    ),
    Story(
        "the PLC leaves run mode in a move",
        (
            MOVING_CW,
            Step(None, 500, {"STOPPED", "POSITION_INVALID"}, (2000, 7000), running=False),
            Step(IDLE, 500, {"STOPPED", "POSITION_INVALID"}, running=True),
        ),
    ),
    Story(
        "what is faster than the hardware is refused, and what is slower",
        (
            Step(relative(100, 40_000, 100, 100), 3000, DONE, 100),
            Step(IDLE, 100, DONE),
            Step(relative(9000, 60_000, 100, 100), 3000, DONE, 9100, {PCL601: Refusal(PROFILE, "speed")}),
            Step(IDLE, 100, DONE),
            Step(relative(-9000, 300_000, 100, 100), 3000, DONE, 100, {PMC006: Refusal(PROFILE, "speed")}),
        ),
    ),
    Story(
        "gentle ramps",
        (Step(relative(9000, 5000, 5, 5), 6000, DONE, 9000, {PMC006: Refusal(PROFILE, "rate")}),),
    ),
    Story(
        "a registration move goes on by its distance from the release of its bit",
        (
            Step(manual(CW, 5000, 3000), 1000, {"MOVING_CW"}, (3000, 5000), NO_REGISTRATION),
            Step(released(manual(CW, 5000, 3000)), 3000, {"STOPPED"}, (6000, 9000)),
        ),
    ),
    Story(
        "a registration move whose distance is changed on the way",
        (
            Step(manual(CW, 5000, 3000), 1000, {"MOVING_CW"}, (3000, 5000), NO_REGISTRATION),
            Step(IDLE, 1500, PROFILE | {"STOPPED"}, (3000, 6000)),
        ),
    ),
    Story("a blend move is refused at its first block", blend_move(NO_BLEND)),
    Story("a blend move by option ends where its segments end", blend_move({}), options=SEGMENTED),
    Story(
        "hold by option",
        (
            MOVING_CW,
            Step(Hold().to_image(), 1000, {"HOLD_STATE"}, (3000, 8000)),
            Step(IDLE, 100, {"HOLD_STATE"}),
            Step(Resume(4000, 50, 50).to_image(), 8000, DONE, 20_000),
        ),
        options={PMC006: {"hold": "immediate"}},
    ),
    Story(
        "another speed in a manual move by option",
        (
            Step(manual(CW), 1000, {"MOVING_CW"}),
            Step(manual(CW, 3000), 1500, {"MOVING_CW"}),
            Step(IDLE, 1000, {"STOPPED"}, (7000, 12_000)),
        ),
        options={PCL601: {"respeed": "restart"}, PMC006: {"respeed": "restart"}},
    ),
    Story(
        "registration by option",
        (
            Step(manual(CW, 5000, 5000), 1000, {"MOVING_CW"}, (3000, 5000)),
            Step(released(manual(CW, 5000, 5000)), 5000, {"STOPPED"}, (8000, 11_000)),
        ),
        options={PCL601: {"registration": "polled"}, PMC006: {"registration": "polled"}},
    ),
    Story(
        "normally closed limits by option",
        (
            Step(relative(12_000), 4000, {"STOPPED", "INPUT_ERROR", "POSITION_INVALID"}, (9000, 9200)),
            Step(IDLE, 100, {"STOPPED", "INPUT_ERROR", "POSITION_INVALID"}),
            Step(ResetErrors().to_image(), 100, {"STOPPED", "POSITION_INVALID"}),
            Step(IDLE, 100, {"STOPPED", "POSITION_INVALID"}),
            Step(manual(CCW), 1000, {"MOVING_CCW", "POSITION_INVALID"}, (3000, 8000)),
            Step(IDLE, 1000, {"STOPPED", "POSITION_INVALID"}),
        ),
        (replace(CW_LIMIT, normally_closed=True), replace(CCW_LIMIT, normally_closed=True)),
        {PCL601: {"limit_sense": "inputs"}},
        configured(
            {PMC006: Refusal({"CONFIG_ERROR"}, "levels of home switch and CCW limit")},
            active_high=InputBit.HOME | InputBit.ESTOP,
        ),
    ),
    Story(
        "home with backplane proximity by option",
        (
            Step(FindHome(CW, 5000, 20, 20).to_image(), 1000, {"MOVING_CW"}, (1000, 5000)),
            Step(NEAR_HOME, 1000, {"MOVING_CW", "HOME_PROX_ECHO"}, (3000, 8000)),
            Step(None, 200, {"AT_HOME", "HOME_PROX_ECHO"}, 0, inputs={InputBit.HOME: True}),
            Step(IDLE, 100, {"AT_HOME"}, 0),
        ),
        options={PCL601: {"proximity": "jumper"}},
        begin=configured(
            {PMC006: Refusal({"CONFIG_ERROR"}, "backplane home proximity")}, backplane_proximity=True
        ),
    ),
)

ENCODER_START = configured({PMC006: Refusal({"CONFIG_ERROR"}, "encoder")}, quadrature_encoder=True)

ENCODER_STORIES = (
    Story(
        "the encoder is preset",
        (Step(PresetEncoder(500).to_image(), 200, set(), 0),),
        begin=ENCODER_START,
    ),
    Story(
        "an encoder move",
        (
            Step(
                Move(MoveKind.RELATIVE, 1000, 5000, 20, 20, encoder=True).to_image(),
                500,
                {"MOVING_CW"},
                (1, 3000),
                {PCL601: Refusal(PROFILE, "encoder move")},
            ),
        ),
        begin=ENCODER_START,
    ),
    Story(
        "an encoder follower",
        (
            Step(
                Follower(CW, 1, 1, 20, 20).to_image(),
                200,
                {"ENC_FOLLOWER"},
                0,
                {PCL601: Refusal({"COMMAND_ERROR"}, "encoder follower")},
            ),
        ),
        begin=ENCODER_START,
    ),
)


CAPTURE, EXTERNAL = InputBit.CAPTURE, InputBit.EXTERNAL


def config(**changed: Any) -> Image:
    """Return the words of the usual configuration with something else in it."""
    return replace(CONFIGURATION, **changed).to_image()


CONFIGURATIONS = {
    "none refuses": (CONFIGURATION.to_image(), {}),
    "capture": (config(inputs_used=INPUTS | CAPTURE), {PMC006: "capture input"}),
    "external": (config(inputs_used=INPUTS | EXTERNAL), {PMC006: "external input"}),
    "slow": (config(starting_speed=64), {PMC006: "starting speed"}),
    "5,000": (config(starting_speed=5000), {}),
    "fast": (config(starting_speed=5001), {PCL601: "starting speed"}),
    "very fast": (config(starting_speed=30_001), {PCL601: "starting speed", PMC006: "starting speed"}),
    "pulses": (config(step_and_direction=False), {PCL601: "CW/CCW pulses"}),
    "encoder": (config(quadrature_encoder=True), {PMC006: "encoder"}),
    "diagnostic": (
        config(diagnostic_feedback=True),
        {PCL601: "diagnostic feedback", PMC006: "diagnostic feedback"},
    ),
    "normally closed limits": (
        config(active_high=0x3F & ~(InputBit.CW_LIMIT | InputBit.CCW_LIMIT)),
        {PCL601: "normally closed end limit", PMC006: "levels of home switch and CCW limit"},
    ),
    "normally closed home switch and limits": (
        config(active_high=InputBit.ESTOP),
        {PCL601: "normally closed end limit"},
    ),
    "normally closed home switch": (
        config(inputs_used=InputBit.HOME | InputBit.CW_LIMIT, active_high=InputBit.CW_LIMIT),
        {PCL601: "normally closed home switch or emergency stop"},
    ),
}


@pytest.mark.parametrize("hardware", HARDWARES)
@pytest.mark.parametrize("name", CONFIGURATIONS)
def test_one_list_of_configurations(name, hardware):
    words, reasons = CONFIGURATIONS[name]
    refused = {each: Refusal({"CONFIG_ERROR"}, reason) for each, reason in reasons.items()}
    Teller(hardware, ()).tell([Step(words, 600, {"MODE_CONFIG"}, None, refused)])


@pytest.mark.slow
@pytest.mark.parametrize("hardware", HARDWARES)
@pytest.mark.parametrize("story", STORIES + ENCODER_STORIES, ids=lambda story: story.name)
def test_one_story_three_hardwares(story, hardware):
    teller = Teller(hardware, story.switches, story.options.get(hardware))
    teller.tell((*story.begin, *story.steps))
