"""Every combination of configuration bits against the manual's list, written out a second time."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scanrack.io_images.amci3601 import KNOWN, Configuration, Firmware, check
from scanrack.io_images.image import Image

often = settings(max_examples=5 * settings().max_examples)
NEWEST = KNOWN[-1]


def bit(word, number):
    return word >> number & 1 == 1


def acceptable(words, firmware):
    """Chapter 3, Invalid Configurations, as questions to be answered with yes."""
    msw, lsw, speed_msw, speed_lsw, *unused = words
    capture, home, proximity = bit(msw, 0), bit(msw, 2), bit(msw, 6)
    cw_limit, ccw_limit = bit(msw, 4), bit(msw, 5)
    encoder, feedback, step_and_direction, marker = (bit(msw, number) for number in (8, 9, 10, 12))
    speed = 1000 * speed_msw + speed_lsw
    four_ways = {(True, False, False), (True, True, False), (True, False, True), (False, True, True)}
    return (
        (home, proximity, marker) in four_ways  # items 1, 9 and 10
        and (cw_limit or ccw_limit)  # item 2
        and not (encoder and feedback)  # item 3
        and (encoder or not marker)  # item 4
        and (step_and_direction or not feedback)  # item 5
        and 1 <= speed <= 1_000_000  # item 6
        and 0 <= speed_lsw <= 999  # item 7
        and not any(bit(msw, number) for number in (7, 11, 13, 14))  # item 8
        and not any(bit(lsw, number) for number in range(6, 16))
        and unused == [0, 0, 0, 0]  # item 11
        and (encoder or not capture or firmware != Firmware(2, 0))  # revision 0.1
    )


@pytest.mark.parametrize("firmware", KNOWN, ids=str)
def test_all_8192_combinations_of_bits_0_to_12(firmware):
    accepted = 0
    for bits in range(2**13):
        words = (0x8000 | bits, 0x3F, 1, 0, 0, 0, 0, 0)
        broken = check(words, firmware)
        assert (broken == ()) is acceptable(words, firmware), f"{bits:04X}h: {broken}"
        accepted += broken == ()
    assert accepted > 0


@pytest.mark.slow
def test_every_accepted_combination_is_read_and_written_alike():
    for bits in range(2**13):
        image = Image((0x8000 | bits, bits & 0x3F, 1, 0))
        if check(image.words.tolist(), NEWEST):
            with pytest.raises(ValueError, match="CFG-"):
                Configuration.from_image(image)
        else:
            assert Configuration.from_image(image).to_image() == image


WORDS = st.tuples(
    st.one_of(st.just(0x8434), st.integers(0, 0xFFFF)),
    st.one_of(st.integers(0, 0x3F), st.integers(0, 0xFFFF)),
    st.one_of(st.integers(-2, 2), st.integers(998, 1002), st.integers(-32_768, 32_767)),
    st.one_of(st.integers(-2, 2), st.integers(997, 1002), st.integers(-32_768, 32_767)),
    *[st.one_of(st.just(0), st.just(0), st.integers(-32_768, 32_767))] * 4,
)


@pytest.mark.slow
@given(WORDS, st.sampled_from(KNOWN))
@often
def test_any_words(words, firmware):
    assert (check(words, firmware) == ()) is acceptable(words, firmware)
    image = Image(words)
    assert check(image.words.tolist(), firmware) == check(words, firmware)  # signed or not
    if acceptable(words, firmware) and words[0] & 0x8000:
        assert Configuration.from_image(image, firmware).to_image() == image
    else:
        with pytest.raises(ValueError, match=r"CFG-|bit 15"):
            Configuration.from_image(image, firmware)


@given(st.integers(0, 0x3F), st.integers(0, 0x3F), st.integers(1, 1_000_000))
@often
def test_meaning_to_words_to_meaning(used, levels, speed):
    configuration = Configuration(
        inputs_used=used | 0b01_0100, active_high=levels, step_and_direction=True, starting_speed=speed
    )
    assert Configuration.from_image(configuration.to_image()) == configuration


@pytest.mark.parametrize(
    ("field", "value"),
    [("inputs_used", 0x40), ("inputs_used", -1), ("active_high", 0x40), ("active_high", -1)]
    + [("starting_speed", value) for value in (0, -1, 1_000_001)],
)
def test_meanings_out_of_range_are_refused(field, value):
    legal = {"inputs_used": 0b01_0100, "active_high": 0, "starting_speed": 1}
    with pytest.raises(ValueError, match=f"{field} {value} is out of range"):
        Configuration(**legal | {field: value})
