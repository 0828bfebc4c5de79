"""What `decode` says about words that no command has."""

import pytest
from scanrack.io_images.amci3601 import LIMITS_3601, Parameters, decode, target_in_range
from scanrack.io_images.image import Image


@pytest.mark.parametrize(
    ("words", "message"),
    [
        pytest.param([0x8000], "8000h: this is a configuration", id="configuration mode"),
        pytest.param([0x0003], "0003h: exactly one command bit", id="two commands"),
        pytest.param([0x4000], "4000h: exactly one command bit", id="reserved bit"),
        pytest.param([0, 0x0300], "0300h: this is a block of a blend profile", id="blend block"),
        pytest.param([0x0180, 0x0080, 1, 1], "0180h: exactly one command bit", id="follower both ways"),
        pytest.param([0x0002, 0, 0, 1, 0, 0, 1, 1], "programmed speed 0 is out of range", id="no speed"),
        pytest.param([0x0002, 0, 1, -1, 1, 0, 1, 1], r"words \(1, -1\) are not a value", id="opposite signs"),
        pytest.param([0x0002, 2, 0, 1, 1, 0, 1, 1], "acceleration type 10b", id="no such acceleration"),
        pytest.param([0x0002, 8, 0, 1, 1, 0, 1, 1], "are not a command", id="reserved LSW bit"),
        pytest.param([0x0800, 1], "are not a command", id="Reset Errors with an LSW"),
        pytest.param([0x1000, 0, 0, 1], "are not a command", id="Run Blend with data"),
        pytest.param([0x0200, 0, 0, 1, 0, 1], "are not a command", id="preset with a speed"),
        pytest.param([0x0020, 0, 0, 1, 1, 0, 1, 1], "are not a command", id="Find Home with a target"),
    ],
)
def test_refusals_say_why(words, message):
    with pytest.raises(ValueError, match=message):
        decode(Image(words))


def test_ranges_of_single_values():
    """Chapter 5, notes 4, 6 and 8; None is a pair of words that is not a value."""
    for legal in (-8_388_608, 0, 8_388_607):
        assert target_in_range(legal)
    for legal in (1, 1_000_000):
        assert LIMITS_3601.takes_speed(legal)
    for legal in (1, 2000):
        assert LIMITS_3601.takes_rate(legal)
    assert not any(target_in_range(illegal) for illegal in (None, -8_388_609, 8_388_608))
    assert not any(LIMITS_3601.takes_speed(illegal) for illegal in (None, -1, 0, 1_000_001))
    assert not any(LIMITS_3601.takes_rate(illegal) for illegal in (-1, 0, 2001))


def test_parameters_of_an_empty_image():
    parameters = Parameters.read(list(Image()))
    assert parameters == Parameters(0, 0, 0, 0)
    assert parameters.target_in_range
    assert not LIMITS_3601.takes_speed(parameters.speed)
    assert not parameters.rates_in_range(LIMITS_3601)
