"""Commands: meaning to words and back, words to meaning and back, and nothing illegal gets through."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scanrack.io_images.amci3601 import (
    LIMITS_3601,
    Acceleration,
    Direction,
    FindHome,
    Follower,
    Hold,
    Idle,
    ImmediateStop,
    Manual,
    Move,
    MoveKind,
    Parameters,
    PresetEncoder,
    PresetPosition,
    ResetErrors,
    Resume,
    RunBlend,
    StoreMinimumRegistration,
    decode,
)
from scanrack.io_images.image import Image

often = settings(max_examples=5 * settings().max_examples)
very_often = settings(max_examples=20 * settings().max_examples)

WORD = st.integers(-32_768, 32_767)
TARGET = st.integers(-8_388_608, 8_388_607)
DISTANCE = st.integers(0, 8_388_607)
SPEED = st.integers(1, 1_000_000)
RATE = st.integers(1, 2000)
RATE_OR_NONE = st.integers(0, 2000)
RATIO = st.integers(1, 32_767)
DIRECTION = st.sampled_from(Direction)
SHAPE = st.sampled_from(Acceleration)
# Words 1 to 7 that mean nothing: bits 7 to 10 of the first are clear.
LEFT_OVER = st.tuples(WORD.map(lambda word: word & ~0x0780), *[WORD] * 6)

COMMANDS = st.one_of(
    st.builds(Idle, LEFT_OVER),
    st.builds(
        Move, st.sampled_from(MoveKind), TARGET, SPEED, RATE, RATE, SHAPE, st.booleans(), st.booleans()
    ),
    st.builds(Hold, st.tuples(*[WORD] * 7)),
    st.builds(Resume, SPEED, RATE, RATE, SHAPE, st.booleans(), st.tuples(WORD, WORD)),
    st.builds(ImmediateStop, st.tuples(*[WORD] * 7)),
    st.builds(FindHome, DIRECTION, SPEED, RATE, RATE, st.booleans()),
    st.builds(
        Manual,
        DIRECTION,
        st.integers(0, 1_000_000),
        RATE_OR_NONE,
        RATE_OR_NONE,
        DISTANCE,
        SHAPE,
        st.booleans(),
    ),
    st.builds(PresetPosition, TARGET),
    st.builds(PresetEncoder, TARGET),
    st.builds(ResetErrors, st.tuples(*[WORD] * 6)),
    st.builds(RunBlend, DIRECTION),
    st.builds(Follower, st.none() | DIRECTION, RATIO, RATIO, RATE_OR_NONE, RATE_OR_NONE),
    st.builds(StoreMinimumRegistration, DISTANCE),
)

EDGES = st.sampled_from([0, 1, -1, 608, 999, 1000, -608, -999, -1000, 1001, 2000, 2001, 8388, -8388, 8389])


@st.composite
def spoiled(draw):
    """Words of a command with one word changed: by a bit, to an edge value, or to anything."""
    words = list(draw(COMMANDS).to_image())
    index = draw(st.integers(0, 7))
    flipped = st.integers(0, 15).map(lambda bit: words[index] & 0xFFFF ^ 1 << bit)
    words[index] = draw(st.one_of(flipped, EDGES, WORD))
    return list(Image(words))


def legal(words):
    """The manual's demands on the eight words of each command, written out a second time."""
    msw, lsw = words[0] & 0xFFFF, words[1] & 0xFFFF
    if msw & 0x8000:
        return False
    if msw == 0 and lsw & 0x0300:
        return False  # a block of a blend profile
    if msw in (0x0000, 0x0080, 0x0100) and lsw & 0x0080:
        ratios = all(word >= 1 for word in words[2:4])
        return lsw == 0x0080 and ratios and words[4:6] == [0, 0] and rates(words, 0)
    if msw == 0 and lsw & 0x0400:
        return lsw == 0x0400 and pair(words[2:4], 0, 8_388_607) and words[4:] == [0, 0, 0, 0]
    if msw in (0x0000, 0x0004, 0x0010):
        return True  # nothing, Hold, Immediate Stop: the rest is not looked at
    if msw == 0x0800:
        return lsw == 0
    if msw in (0x1000, 0x2000):
        return words[1:] == [0] * 7
    if msw in (0x0200, 0x0400):
        return lsw == 0 and pair(words[2:4], -8_388_608, 8_388_607) and words[4:] == [0, 0, 0, 0]
    if msw in (0x0080, 0x0100):
        target, speed = pair(words[2:4], 0, 8_388_607), pair(words[4:6], 0, 1_000_000)
        return shaped(lsw, 0x1003) and target and speed and rates(words, 0)
    profile = pair(words[4:6], 1, 1_000_000) and rates(words, 1)
    if msw in (0x0001, 0x0002):
        return shaped(lsw, 0x1007) and pair(words[2:4], -8_388_608, 8_388_607) and profile
    if msw == 0x0008:
        return shaped(lsw, 0x1003) and profile
    if msw in (0x0020, 0x0040):
        return shaped(lsw, 0x1000) and words[2:4] == [0, 0] and profile
    return False  # no such bit, or several


def pair(words, least, greatest):
    msw, lsw = words
    same_sign = not (msw < 0 < lsw or lsw < 0 < msw)
    return same_sign and abs(lsw) <= 999 and least <= 1000 * msw + lsw <= greatest


def rates(words, least):
    return all(least <= word <= 2000 for word in words[6:])


def shaped(lsw, allowed):
    return lsw & ~allowed == 0 and lsw & 3 != 2


@given(COMMANDS)
@often
def test_meaning_to_words_to_meaning(command):
    image = command.to_image()
    assert legal(list(image))
    assert decode(image) == command


@pytest.mark.slow
@given(spoiled() | st.lists(WORD, min_size=8, max_size=8))
@very_often
def test_words_to_meaning_to_words(words):
    if legal(words):
        assert list(decode(Image(words)).to_image()) == words
    else:
        with pytest.raises(ValueError, match=r"word|out of range|acceleration type"):
            decode(Image(words))


@pytest.mark.parametrize("number", range(16))
def test_every_command_bit_with_many_lsws(number):
    """Each LSW bit alone and each pair of them, with parameters that suit a profile move."""
    for lsw in {1 << one | 1 << other for one in range(16) for other in range(16)} | {0}:
        words = list(Image((1 << number, lsw, 0, 0, 1, 0, 20, 10)))
        assert accepted(words) is legal(words), f"LSW {lsw:04X}h"


def accepted(words):
    try:
        return list(decode(Image(words)).to_image()) == words
    except ValueError:
        return False


@given(st.lists(WORD | EDGES, min_size=8, max_size=8))
@often
def test_parameters_judge_like_the_manual(words):
    parameters = Parameters.read(words)
    target, speed = words[2:4], words[4:6]
    whole = (-32_768_999, 32_767_999)
    assert parameters.target == (1000 * target[0] + target[1] if pair(target, *whole) else None)
    assert parameters.speed == (1000 * speed[0] + speed[1] if pair(speed, *whole) else None)
    assert parameters.target_in_range is pair(target, -8_388_608, 8_388_607)
    assert LIMITS_3601.takes_speed(parameters.speed) is pair(speed, 1, 1_000_000)
    assert parameters.rates_in_range(LIMITS_3601) is rates(words, 1)
    assert (parameters.acceleration, parameters.deceleration) == (words[6], words[7])


@pytest.mark.parametrize(
    ("make", "count"),
    [
        (Idle, 7),
        (Hold, 7),
        (ImmediateStop, 7),
        (ResetErrors, 6),
        (lambda w: Resume(1, 1, 1, target_words=w), 2),
    ],
)
def test_left_over_words_are_words(make, count):
    with pytest.raises(ValueError, match=f"{count + 1} words, not {count}"):
        make((0,) * (count + 1))
    with pytest.raises(ValueError, match="32768 is out of range"):
        make((0,) * (count - 1) + (32_768,))


@pytest.mark.parametrize("bit", [7, 8, 9, 10])
def test_no_command_has_no_bits_that_mean_one(bit):
    with pytest.raises(ValueError, match="bits 7 to 10"):
        Idle((1 << bit, 0, 0, 0, 0, 0, 0))
