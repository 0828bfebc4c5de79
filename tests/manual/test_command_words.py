"""Chapters 4 and 5: the command words and what they carry."""

import pytest
from scanrack.io_images.amci3601 import (
    Acceleration,
    CommandLsw,
    CommandMsw,
    Direction,
    FindHome,
    Follower,
    Hold,
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
    decode,
)
from scanrack.io_images.image import Image

CW, CCW = Direction.CW, Direction.CCW

# Chapter 5, Command Word MSW: bit number and a command that sets it.
MSW = [
    (0, CommandMsw.ABSOLUTE_MOVE, Move(MoveKind.ABSOLUTE, 7500, 5000, 20, 10)),
    (1, CommandMsw.RELATIVE_MOVE, Move(MoveKind.RELATIVE, 7500, 5000, 20, 10)),
    (2, CommandMsw.HOLD_MOVE, Hold()),
    (3, CommandMsw.RESUME_MOVE, Resume(5000, 20, 10)),
    (4, CommandMsw.IMMEDIATE_STOP, ImmediateStop()),
    (5, CommandMsw.FIND_HOME_CW, FindHome(CW, 5000, 20, 10)),
    (6, CommandMsw.FIND_HOME_CCW, FindHome(CCW, 5000, 20, 10)),
    (7, CommandMsw.MANUAL_CW, Manual(CW, 5000, 20, 10)),
    (8, CommandMsw.MANUAL_CCW, Manual(CCW, 5000, 20, 10)),
    (9, CommandMsw.PRESET_POSITION, PresetPosition(0)),
    (10, CommandMsw.PRESET_ENCODER, PresetEncoder(0)),
    (11, CommandMsw.RESET_ERRORS, ResetErrors()),
    (12, CommandMsw.RUN_BLEND_CW, RunBlend(CW)),
    (13, CommandMsw.RUN_BLEND_CCW, RunBlend(CCW)),
]


@pytest.mark.parametrize(
    ("number", "bit", "command"),
    [pytest.param(*row, id=f"chapter 5 Command Word MSW bit {row[0]}") for row in MSW],
)
def test_command_msw(number, bit, command):
    assert bit.value == 1 << number
    image = command.to_image()
    assert image[0] == 1 << number
    assert decode(image) == command


@pytest.mark.parametrize(
    ("number", "bit"),
    [
        pytest.param(number, bit, id=f"chapter 5 Command Word LSW bit {number}")
        for number, bit in {
            0: CommandLsw.S_CURVE,
            1: CommandLsw.TRAPEZOIDAL,
            2: CommandLsw.ENCODER_MOVE,
            7: CommandLsw.ENC_FOLLOWER,
            8: CommandLsw.BLEND_PROGRAM,
            9: CommandLsw.BLEND_TRANSMIT,
            10: CommandLsw.STORE_MIN_REG,
            12: CommandLsw.HOME_PROXIMITY,
        }.items()
    ],
)
def test_command_lsw(number, bit):
    assert bit.value == 1 << number


@pytest.mark.parametrize(
    ("shape", "bits"),
    [
        pytest.param(Acceleration.CONSTANT, 0b00, id="chapter 5 Command Word LSW bit 0 reset"),
        pytest.param(Acceleration.TRIANGULAR, 0b01, id="chapter 5 Command Word LSW bit 1 reset"),
        pytest.param(Acceleration.TRAPEZOIDAL, 0b11, id="chapter 5 Command Word LSW bit 1 set"),
    ],
)
def test_acceleration_bits(shape, bits):
    assert Move(MoveKind.RELATIVE, 1, 1, 1, 1, shape).to_image()[1] == bits
    assert Resume(1, 1, 1, shape).to_image()[1] == bits
    assert Manual(CW, 1, 1, 1, shape=shape).to_image()[1] == bits


def test_move_words():
    """Chapter 5, Generic Output Data: position in words 2 and 3, speed in 4 and 5, rates in 6 and 7."""
    move = Move(MoveKind.ABSOLUTE, -12_345, 12_000, 2000, 1, encoder=True)
    assert list(move.to_image()) == [0x0001, 0x0004, -12, -345, 12, 0, 2000, 1]


def test_minimum_registration_words():
    """Chapter 4, Registration Move, New Command Bit: word 1 is 1024 decimal, words 4 to 7 are zero."""
    assert list(StoreMinimumRegistration(8_388_607).to_image()) == [0, 1024, 8388, 607, 0, 0, 0, 0]
    assert decode(Image([0, 1024, 0, 345])) == StoreMinimumRegistration(345)


def test_registration_steps_ride_in_the_target_words():
    """Chapter 4, Registration Move."""
    assert list(Manual(CW, 5000, 20, 10, registration=12_345).to_image()) == [128, 0, 12, 345, 5, 0, 20, 10]


def test_follower_words():
    """Chapter 4, Encoder Follower: multiplier in word 2, divisor in word 3, words 4 and 5 zero."""
    assert list(Follower(CW, 32_767, 1, 2000, 0).to_image()) == [1 << 7, 1 << 7, 32_767, 1, 0, 0, 2000, 0]
    assert list(Follower(CCW, 1, 3).to_image()) == [1 << 8, 1 << 7, 1, 3, 0, 0, 0, 0]
    assert list(Follower(None, 1, 1).to_image()) == [0, 1 << 7, 1, 1, 0, 0, 0, 0]


@pytest.mark.parametrize(
    ("command", "least", "greatest"),
    [
        pytest.param(
            lambda v: Move(MoveKind.ABSOLUTE, v, 1, 1, 1), -8_388_608, 8_388_607, id="chapter 5 note 4"
        ),
        pytest.param(lambda v: Move(MoveKind.ABSOLUTE, 0, v, 1, 1), 1, 1_000_000, id="chapter 5 note 6"),
        pytest.param(lambda v: Move(MoveKind.ABSOLUTE, 0, 1, v, 1), 1, 2000, id="chapter 5 note 8: up"),
        pytest.param(lambda v: Move(MoveKind.ABSOLUTE, 0, 1, 1, v), 1, 2000, id="chapter 5 note 8: down"),
        pytest.param(lambda v: FindHome(CW, v, 1, 1), 1, 1_000_000, id="chapter 4 Find Home: speed"),
        pytest.param(lambda v: FindHome(CW, 1, v, 1), 1, 2000, id="chapter 4 Find Home: acceleration"),
        pytest.param(lambda v: FindHome(CW, 1, 1, v), 1, 2000, id="chapter 4 Find Home: deceleration"),
        pytest.param(lambda v: Manual(CW, v), 0, 1_000_000, id="chapter 4 Manual Move: one shot to fastest"),
        pytest.param(lambda v: Manual(CW, 1, 1, 1, v), 0, 8_388_607, id="chapter 4 Registration Move"),
        pytest.param(lambda v: Resume(v, 1, 1), 1, 1_000_000, id="chapter 4 Resume Move"),
        pytest.param(PresetPosition, -8_388_608, 8_388_607, id="chapter 4 Preset Current Position"),
        pytest.param(PresetEncoder, -8_388_608, 8_388_607, id="chapter 4 Preset Encoder Position"),
        pytest.param(StoreMinimumRegistration, 0, 8_388_607, id="chapter 4 Minimum Registration"),
        pytest.param(lambda v: Follower(CW, v, 1), 1, 32_767, id="chapter 4 Encoder Follower: multiplier"),
        pytest.param(lambda v: Follower(CW, 1, v), 1, 32_767, id="chapter 4 Encoder Follower: divisor"),
        pytest.param(lambda v: Follower(CW, 1, 1, v), 0, 2000, id="chapter 4 Encoder Follower: up"),
        pytest.param(lambda v: Follower(CW, 1, 1, 0, v), 0, 2000, id="chapter 4 Encoder Follower: down"),
    ],
)
def test_ranges(command, least, greatest):
    for value in (least, greatest):
        assert decode(command(value).to_image()) == command(value)
    for value in (least - 1, greatest + 1):
        with pytest.raises(ValueError, match=f" {value} is out of range: must be {least} to {greatest}"):
            command(value)
