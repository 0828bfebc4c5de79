"""Sequences of a PLC program's commands: configure, home, move, hold, blend, follow, and mistakes.

A single command rarely reaches a deep state: homing, a hold or a blend move takes several images in order,
with waits between them. An `Act` is a self-contained series of images. It begins with Reset Errors, so that
an earlier mistake does not lock the module, and ends with a command word of 0.

    act = Act("held move", showings)
    showing       image       until
    1             RESET       4 ms have passed
    2             0           4 ms have passed
    3             RELATIVE    20 ms have passed
    4             HOLD        a completion or error bit is set, or 20 s have passed
    5             0           4 ms have passed

Every draw chooses from fewer than 100 values. From larger ranges, Hypothesis would also draw constants of 100
or more that it finds in loaded modules, so examples would depend on which modules are loaded.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from hypothesis import strategies as st

from ..amci3601 import (
    ALL_INPUTS,
    COMPLETION_BITS,
    ERROR_BITS,
    KNOWN,
    Acceleration,
    BlendHeader,
    BlendSegment,
    Configuration,
    Direction,
    FindHome,
    Firmware,
    Follower,
    Hold,
    Idle,
    InputBit,
    Manual,
    Move,
    MoveKind,
    PresetPosition,
    ResetErrors,
    Resume,
    RunBlend,
    StatusMsw,
    StoreMinimumRegistration,
)
from ..amci3601.parameters import LIMITS_3601, require
from ..image import Image
from .blends import handshake

SETTLE_MS = 4
"""Time to show an image with an immediate effect: two RPIs."""

LONGEST_MS = 20_000
"""Maximum wait for the end of a motion."""

START_MAX = 100_000
"""Maximum starting speed, steps/s; ten times this speed is still legal."""

MOVE_ENDED = COMPLETION_BITS | ERROR_BITS & ~StatusMsw.POSITION_INVALID


class Showing(NamedTuple):
    """An output image and how long it is shown."""

    image: Image
    ms: int = SETTLE_MS  # duration, or maximum duration if `waits` is set
    waits: bool = False  # whether it ends when the module shows the end of a motion or an error

    def is_over(self, inputs: Image, shown_ms: float) -> bool:
        """Return whether the next image is due after `shown_ms` (at least `SETTLE_MS`), given inputs."""
        has_ended = self.waits and shown_ms >= SETTLE_MS and bool(inputs[0] & MOVE_ENDED)
        return has_ended or shown_ms >= self.ms


class Act(NamedTuple):
    """A series of images with one purpose, such as "home" or "held move"."""

    name: str
    showings: tuple[Showing, ...]

    def __repr__(self) -> str:
        words = "; ".join(" ".join(map(str, showing.image)) for showing in self.showings)
        return f"<Act {self.name}: {words}>"


IDLE = Showing(Idle().to_image())
RESET = (Showing(ResetErrors().to_image()), IDLE)

DIRECTIONS = tuple(Direction)
SPEED_MULTIPLES = (5, 2, 10, 1)
RATE_PAIRS = ((100, 50), (1000, 1000), (20, 10))
STEPS = (1000, 300, -700, 5000, 20, -3000, 1)
RUN_MS = (20, 100, 4, 400)
SHAPES = tuple(Acceleration)
RATIOS = ((1, 1), (2, 1), (1, 7), (3, 2))


def acting(name: str, *showings: Showing) -> Act:
    """Return an act that starts without errors and ends with a command word of 0."""
    return Act(name, (*RESET, *showings, IDLE))


def waiting(image: Image) -> Showing:
    """Return a showing of an image that lasts until the end of a motion."""
    return Showing(image, LONGEST_MS, waits=True)


def configuring(starting_speed: int = 1000) -> Act:
    """Return the act that configures an axis for `acts`; the starting speed is 1 to 100,000 steps/s.

    It has a home switch, emergency stop, external input and both end limits, active high, and a quadrature
    encoder.
    """
    require("starting_speed", starting_speed, 1, START_MAX)
    configuration = Configuration(
        inputs_used=ALL_INPUTS & ~InputBit.CAPTURE.value,
        active_high=ALL_INPUTS,
        quadrature_encoder=True,
        starting_speed=starting_speed,
    )
    return Act("configure", (Showing(configuration.to_image()), IDLE))


def acts(starting_speed: int = 1000, firmware: Firmware = KNOWN[-1]) -> st.SearchStrategy[Act]:
    """Return a strategy of acts on a configured axis, the simplest first.

    They are waits, moves with and without a hold, homing, manual moves, presets, blend moves and mistakes.
    Firmware 3.1 and later add registration moves; 4.1 adds the encoder follower.
    """
    require("starting_speed", starting_speed, 1, START_MAX)
    speeds = tuple(starting_speed * multiple for multiple in SPEED_MULTIPLES)
    kinds = [_waits(), _moves(speeds), _homes(speeds), _held_moves(speeds), _blends(speeds)]
    kinds += [_manuals(speeds), _presets(), st.just(configuring(starting_speed)), _mistakes(starting_speed)]
    if firmware.registration:
        kinds.append(_registrations(speeds))
    if firmware.follower:
        kinds.append(_followers())
    return st.one_of(*kinds)


def sequences(
    starting_speed: int = 1000, firmware: Firmware = KNOWN[-1], *, most: int = 10
) -> st.SearchStrategy[list[Act]]:
    """Return a strategy of whole sequences: the configuration, then at most `most` acts (1 to 99)."""
    require("most", most, 1, 99)
    configuration = configuring(starting_speed)
    return st.lists(acts(starting_speed, firmware), min_size=1, max_size=most).map(
        lambda further_acts: [configuration, *further_acts]
    )


# -- kinds of acts ----------------------------------------------------------------------------------


def _one_of(values: Sequence[int]) -> st.SearchStrategy[int]:
    return st.sampled_from(values)


def _move_of(kind: MoveKind, steps: int, speed: int, rates: tuple[int, int], shape: Acceleration) -> Image:
    return Move(kind, steps, speed, rates[0], rates[1], shape).to_image()


def _plain_moves(speeds: Sequence[int]) -> st.SearchStrategy[Image]:
    """Return a strategy of images with a relative or absolute move."""
    return st.builds(
        _move_of,
        st.sampled_from((MoveKind.RELATIVE, MoveKind.ABSOLUTE)),
        _one_of(STEPS),
        _one_of(speeds),
        st.sampled_from(RATE_PAIRS),
        st.sampled_from(SHAPES),
    )


def _waits() -> st.SearchStrategy[Act]:
    return _one_of(RUN_MS).map(lambda ms: acting("wait", Showing(IDLE.image, ms)))


def _moves(speeds: Sequence[int]) -> st.SearchStrategy[Act]:
    return _plain_moves(speeds).map(lambda image: acting("move", waiting(image)))


def _held_moves(speeds: Sequence[int]) -> st.SearchStrategy[Act]:
    """Return a strategy of long moves that are held after some time; some are then resumed."""

    def held(image: Image, ms: int, speed: int, resumed: bool) -> Act:
        showings = [Showing(image, ms), waiting(Hold().to_image())]
        if resumed:
            showings += [IDLE, waiting(Resume(speed, 100, 50).to_image())]
        return acting("held move", *showings)

    long_moves = st.builds(
        _move_of,
        st.just(MoveKind.RELATIVE),
        st.sampled_from((5000, -5000)),
        _one_of(speeds),
        st.sampled_from(RATE_PAIRS),
        st.sampled_from(SHAPES),
    )
    return st.builds(held, long_moves, _one_of(RUN_MS), _one_of(speeds), st.booleans())


def _homes(speeds: Sequence[int]) -> st.SearchStrategy[Act]:
    def home(direction: Direction, speed: int, rates: tuple[int, int]) -> Act:
        return acting("home", waiting(FindHome(direction, speed, *rates).to_image()))

    return st.builds(home, st.sampled_from(DIRECTIONS), _one_of(speeds), st.sampled_from(RATE_PAIRS))


def _manual_of(direction: Direction, speed: int, rates: tuple[int, int], steps: int) -> Image:
    return Manual(direction, speed, rates[0], rates[1], steps).to_image()


def _released(image: Image) -> Image:
    """Return the words of a manual move with its bit cleared and its parameters unchanged."""
    words = image.copy()
    words[0] = 0
    return words


def _manuals(speeds: Sequence[int]) -> st.SearchStrategy[Act]:
    """Return a strategy of manual moves that run for some time, until their bit is cleared."""

    def manual(image: Image, ms: int) -> Act:
        return acting("manual move", Showing(image, ms), waiting(_released(image)))

    images = st.builds(
        _manual_of,
        st.sampled_from(DIRECTIONS),
        _one_of(speeds),
        st.sampled_from(RATE_PAIRS),
        st.just(0),
    )
    return st.builds(manual, images, _one_of(RUN_MS))


def _registrations(speeds: Sequence[int]) -> st.SearchStrategy[Act]:
    """Return a strategy of registration moves, each after storing its minimum distance."""

    def registration(image: Image, ms: int, minimum_steps: int) -> Act:
        store = Showing(StoreMinimumRegistration(minimum_steps).to_image())
        return acting("registration move", store, IDLE, Showing(image, ms), waiting(_released(image)))

    images = st.builds(
        _manual_of,
        st.sampled_from(DIRECTIONS),
        _one_of(speeds),
        st.sampled_from(RATE_PAIRS[:2]),
        st.sampled_from((3000, 500, 1)),
    )
    return st.builds(registration, images, _one_of(RUN_MS), st.sampled_from((0, 100, 1000)))


def _presets() -> st.SearchStrategy[Act]:
    return _one_of((0, *STEPS)).map(lambda value: acting("preset", Showing(PresetPosition(value).to_image())))


def _blends(speeds: Sequence[int]) -> st.SearchStrategy[Act]:
    """Return a strategy of blends of two segments that are long enough for their ramps.

    A ramp takes v * v / 2a steps at 1000 steps/ms/s, and twice as many with an S-curve.
    """

    def blend(direction: Direction, first: int, second: int, shape: Acceleration) -> Act:
        # segments in sequence must have different speeds
        nearest_speed = first + 1 if first < LIMITS_3601.speed else first - 1
        other_speed = second if second != first else nearest_speed
        length = max(1000, max(first, other_speed) ** 2 // 250_000)
        header = BlendHeader((shape, shape), 1000)
        segments = [BlendSegment(length, speed, 1000) for speed in (first, other_speed)]
        blocks = [header.to_image(), *(segment.to_image() for segment in segments)]
        run_blend = waiting(RunBlend(direction).to_image())
        return acting("blend move", *(Showing(image) for image in handshake(blocks)), run_blend)

    return st.builds(
        blend, st.sampled_from(DIRECTIONS), _one_of(speeds), _one_of(speeds), st.sampled_from(SHAPES)
    )


def _followers() -> st.SearchStrategy[Act]:
    def follower(direction: Direction, ratio: tuple[int, int], ms: int) -> Act:
        return acting("follower", Showing(Follower(direction, *ratio, 0, 0).to_image(), ms))

    return st.builds(follower, st.sampled_from(DIRECTIONS), st.sampled_from(RATIOS), _one_of(RUN_MS))


def _mistakes(starting_speed: int) -> st.SearchStrategy[Act]:
    """Return a strategy of acts with one illegal image, alone or during a move."""
    fast = 5 * starting_speed
    move = Move(MoveKind.RELATIVE, 3000, fast, 100, 50).to_image()
    wrong_images = [Hold().to_image(), Resume(fast, 100, 50).to_image()]
    for changes in (
        {0: 0x0003},  # two commands at once
        {4: 0, 5: 0},  # no speed
        {4: 0, 5: 1000},  # an illegal pair
        {6: 0},  # no acceleration
        {7: 2001},
        {2: 1, 3: -1},  # opposite signs
        {0: 0x0020},  # Find Home with a target
        {0: 0x0200},  # a preset with a speed
        {0: 0x1000},  # Run Blend with data
        {0: 0x4000},  # no command
    ):
        image = move.copy()
        for index, word in changes.items():
            image[index] = word
        wrong_images.append(image)
    mistakes_alone = [acting("mistake", Showing(image)) for image in wrong_images]
    # Hold during a move is not a mistake.
    mistakes_in_move = [
        acting("mistake in a move", Showing(move, 20), Showing(image), waiting(IDLE.image))
        for image in wrong_images[1:]
    ]
    return st.sampled_from(mistakes_alone + mistakes_in_move)
