"""Legal commands, as objects of `amci3601`; `to_image` returns their words.

Whether the module executes them depends on its state.
"""

from __future__ import annotations

from hypothesis import strategies as st

from ..amci3601 import (
    KNOWN,
    Command,
    Direction,
    FindHome,
    Firmware,
    Follower,
    Hold,
    Idle,
    ImmediateStop,
    Manual,
    Move,
    MoveKind,
    PresetEncoder,
    PresetPosition,
    ResetErrors,
    Resume,
    RunBlend,
    StoreMinimumRegistration,
)
from ..image import WORD_MAX
from ..thousands import PARAMETER_MAX
from .command_values import rates, shapes, speeds, targets

directions = st.sampled_from(Direction)
RELATIVE_FIRST = (MoveKind.RELATIVE, MoveKind.ABSOLUTE)


def moves(starting_speed: int, *, encoder: bool = False) -> st.SearchStrategy[Move]:
    """Return a strategy of absolute and relative moves, in encoder counts if `encoder` is set."""
    return st.builds(
        lambda kind, target, speed, pair, shape: Move(kind, target, speed, pair[0], pair[1], shape, encoder),
        st.sampled_from(RELATIVE_FIRST),
        targets(),
        speeds(starting_speed),
        rates(),
        shapes(),
    )


def resumes(starting_speed: int) -> st.SearchStrategy[Resume]:
    """Return a strategy of Resume commands."""
    return st.builds(
        lambda speed, pair, shape: Resume(speed, pair[0], pair[1], shape),
        speeds(starting_speed),
        rates(),
        shapes(),
    )


def find_homes(starting_speed: int) -> st.SearchStrategy[FindHome]:
    """Return a strategy of Find Home commands."""
    return st.builds(
        lambda direction, speed, pair: FindHome(direction, speed, pair[0], pair[1]),
        directions,
        speeds(starting_speed),
        rates(),
    )


def manual_moves(starting_speed: int) -> st.SearchStrategy[Manual]:
    """Return a strategy of manual moves: with ramps, in constant speed mode, and one-shots."""
    slow_speeds = st.integers(0, starting_speed)
    return st.builds(
        lambda direction, speed, pair, shape: Manual(direction, speed, pair[0], pair[1], shape=shape),
        directions,
        speeds(starting_speed) | slow_speeds,
        rates(),
        shapes(),
    )


def registration_moves(starting_speed: int) -> st.SearchStrategy[Manual]:
    """Return a strategy of registration moves (firmware 3.1); some are shorter than the distance to stop."""
    distances = st.sampled_from([3000, 300, 20_000, 1]) | st.integers(1, 1_000_000)
    return st.builds(
        lambda direction, speed, pair, steps, shape: Manual(direction, speed, pair[0], pair[1], steps, shape),
        directions,
        speeds(starting_speed),
        rates(),
        distances,
        shapes(),
    )


def followers() -> st.SearchStrategy[Follower]:
    """Return a strategy of encoder follower words (firmware 4.1)."""
    ratio = st.sampled_from([1, 2, 7, 1000, WORD_MAX]) | st.integers(1, WORD_MAX)
    rate = st.sampled_from([0, 100, 2000]) | st.integers(0, 2000)
    return st.builds(Follower, st.sampled_from([*Direction, None]), ratio, ratio, rate, rate)


def presets() -> st.SearchStrategy[PresetPosition | PresetEncoder]:
    """Return a strategy of presets of position and encoder value."""
    return st.builds(PresetPosition, targets()) | st.builds(PresetEncoder, targets())


def commands(starting_speed: int, firmware: Firmware = KNOWN[-1]) -> st.SearchStrategy[Command]:
    """Return a strategy of all commands that are legal in a firmware version."""
    stored_minimums = st.builds(StoreMinimumRegistration, st.integers(0, PARAMETER_MAX))
    newer_commands: list[st.SearchStrategy[Command]] = []
    if firmware.registration:
        newer_commands += [registration_moves(starting_speed), stored_minimums]
    if firmware.follower:
        newer_commands.append(followers())
    return st.one_of(
        st.just(Idle()),
        moves(starting_speed),
        manual_moves(starting_speed),
        st.just(Hold()),
        resumes(starting_speed),
        st.just(ImmediateStop()),
        st.just(ResetErrors()),
        find_homes(starting_speed),
        presets(),
        st.builds(RunBlend, directions),
        moves(starting_speed, encoder=True),
        *newer_commands,
    )
