"""Chapter 3: the configuration words, the four ways to home, the invalid configurations."""

import pytest
from scanrack.io_images.amci3601 import (
    ALL_INPUTS,
    ConfigMsw,
    Configuration,
    Firmware,
    HomingKind,
    InputBit,
    check,
)
from scanrack.io_images.image import Image

NEWEST = Firmware(4, 1)

# External (1), home (2), emergency stop (3), CW (4) and CCW limit (5), step and direction (10), mode (15).
VALID_MSW = 1 << 1 | 1 << 2 | 1 << 3 | 1 << 4 | 1 << 5 | 1 << 10 | 1 << 15


def words(msw=VALID_MSW, lsw=ALL_INPUTS, speed=(1, 0), rest=(0, 0, 0, 0)):
    return (msw, lsw, *speed, *rest)


@pytest.mark.parametrize(
    ("bit", "number"),
    [
        pytest.param(bit, number, id=f"chapter 3 MSW bit {number}: {bit.name}")
        for bit, number in {
            ConfigMsw.USE_CAPTURE: 0,
            ConfigMsw.USE_EXTERNAL: 1,
            ConfigMsw.USE_HOME: 2,
            ConfigMsw.USE_ESTOP: 3,
            ConfigMsw.USE_CW_LIMIT: 4,
            ConfigMsw.USE_CCW_LIMIT: 5,
            ConfigMsw.BACKPLANE_PROXIMITY: 6,
            ConfigMsw.QUADRATURE_ENCODER: 8,
            ConfigMsw.DIAGNOSTIC_FEEDBACK: 9,
            ConfigMsw.STEP_AND_DIRECTION: 10,
            ConfigMsw.MARKER_HOME: 12,
            ConfigMsw.MODE_CONFIG: 15,
        }.items()
    ],
)
def test_bit_numbers_msw(bit, number):
    assert bit.value == 1 << number


@pytest.mark.parametrize("number", range(6))
def test_bit_numbers_lsw(number):
    """Chapter 3, Configuration Bits LSW: the levels have the bit numbers of the used inputs."""
    order = ["CAPTURE", "EXTERNAL", "HOME", "ESTOP", "CW_LIMIT", "CCW_LIMIT"]
    assert InputBit[order[number]].value == 1 << number
    assert ConfigMsw["USE_" + order[number]].value == 1 << number


def test_everything_lands_in_its_word():
    """843Eh is bits 1 to 5, 10 and 15 of word 0; 003Fh makes all inputs active high."""
    configuration = Configuration(inputs_used=0b11_1110, step_and_direction=True, starting_speed=12_345)
    assert list(configuration.to_image()) == [0x843E - 0x10000, 0x003F, 12, 345, 0, 0, 0, 0]
    assert check(configuration.to_image().words.tolist(), NEWEST) == ()


@pytest.mark.parametrize(
    ("inputs", "proximity", "marker", "kind"),
    [
        pytest.param(InputBit.HOME, False, False, HomingKind.HOME_SWITCH, id="chapter 3 item 10.1"),
        pytest.param(InputBit.HOME, True, False, HomingKind.HOME_SWITCH_PROXIMITY, id="chapter 3 item 10.2"),
        pytest.param(InputBit.HOME, False, True, HomingKind.MARKER_HOME_SWITCH, id="chapter 3 item 10.3"),
        pytest.param(InputBit(0), True, True, HomingKind.MARKER_PROXIMITY, id="chapter 3 item 10.4"),
    ],
)
def test_four_ways_to_home(inputs, proximity, marker, kind):
    configuration = Configuration(
        inputs_used=(inputs | InputBit.CW_LIMIT).value,
        backplane_proximity=proximity,
        quadrature_encoder=marker,
        marker_home=marker,
        starting_speed=1,
    )
    assert configuration.homing is kind


HOME = ConfigMsw.USE_HOME
LIMIT = ConfigMsw.USE_CW_LIMIT
PROXIMITY = ConfigMsw.BACKPLANE_PROXIMITY
ENCODER = ConfigMsw.QUADRATURE_ENCODER
FEEDBACK = ConfigMsw.DIAGNOSTIC_FEEDBACK
STEP = ConfigMsw.STEP_AND_DIRECTION
MARKER = ConfigMsw.MARKER_HOME

# Each line breaks one item of the list and no other.
INVALID = [
    ("CFG-01", "1: no home switch, no marker", words(LIMIT)),
    ("CFG-01", "1: backplane proximity of nothing", words(LIMIT | PROXIMITY)),
    ("CFG-02", "2: no end limit", words(HOME)),
    ("CFG-03", "3: encoder and feedback", words(HOME | LIMIT | ENCODER | FEEDBACK | STEP)),
    ("CFG-04", "4: marker without encoder", words(HOME | LIMIT | MARKER)),
    ("CFG-04", "4: marker with feedback only", words(HOME | LIMIT | MARKER | FEEDBACK | STEP)),
    ("CFG-05", "5: feedback with CW/CCW pulses", words(HOME | LIMIT | FEEDBACK)),
    ("CFG-06", "6: starting speed 0", words(speed=(0, 0))),
    ("CFG-06", "6: starting speed 1,000,001", words(speed=(1000, 1))),
    ("CFG-06", "6: starting speed negative", words(speed=(-1, 0))),
    ("CFG-07", "7: lower word 1000", words(speed=(1, 1000))),
    ("CFG-07", "7: lower word -1", words(speed=(1, -1))),
    *(("CFG-08", f"8: MSW bit {bit}", words(VALID_MSW | 1 << bit)) for bit in (7, 11, 13, 14)),
    *(("CFG-08", f"8: LSW bit {bit}", words(lsw=1 << bit)) for bit in range(6, 16)),
    ("CFG-09", "9: marker without proximity", words(LIMIT | ENCODER | MARKER)),
    ("CFG-10", "10: marker with both", words(HOME | LIMIT | ENCODER | MARKER | PROXIMITY)),
    *(
        ("CFG-11", f"11: word {4 + index}", words(rest=tuple(-(index == at) for at in range(4))))
        for index in range(4)
    ),
]


@pytest.mark.parametrize(
    ("rule", "sent"),
    [pytest.param(rule, sent, id=f"chapter 3 Invalid Configurations {what}") for rule, what, sent in INVALID],
)
def test_invalid_configurations(rule, sent):
    assert check(tuple(map(int, sent)), NEWEST) == (rule,)
    image = Image(int(word) | (0x8000 if index == 0 else 0) for index, word in enumerate(sent))
    assert check(image.words.tolist(), NEWEST) == (rule,)
    with pytest.raises(ValueError, match=rule):
        Configuration.from_image(image)


@pytest.mark.parametrize(
    "speed",
    [
        pytest.param((0, 1), id="chapter 3 Starting Speed: least"),
        pytest.param((1000, 0), id="chapter 3 Starting Speed: greatest"),
    ],
)
def test_starting_speed_limits(speed):
    assert check(words(speed=speed), NEWEST) == ()


def test_revision_0_1_capture_without_encoder():
    """Legal since firmware 2.1, invalid before [Manual Revision History, revision 0.1]."""
    capture = words(VALID_MSW | ConfigMsw.USE_CAPTURE.value)
    with_encoder = words(VALID_MSW | ConfigMsw.USE_CAPTURE.value | ENCODER.value)
    assert check(capture, Firmware(2, 0)) == ("CFG-29",)
    assert check(capture, Firmware(2, 1)) == ()
    assert check(with_encoder, Firmware(2, 0)) == ()
    with pytest.raises(ValueError, match="CFG-29"):
        Configuration.from_image(Image(capture), Firmware(2, 0))


@pytest.mark.parametrize(
    ("level", "energized", "active"),
    [
        pytest.param(1, 1, True, id="active high, energized"),
        pytest.param(1, 0, False, id="active high, not energized"),
        pytest.param(0, 1, False, id="active low, energized"),
        pytest.param(0, 0, True, id="active low, not energized"),
    ],
)
def test_input_active_level(level, energized, active):
    """Chapter 3, Input Active Level: 1 for a normally open, 0 for a normally closed contact."""
    used = (InputBit.HOME | InputBit.CW_LIMIT).value
    home = InputBit.HOME.value
    configuration = Configuration(
        inputs_used=used, active_high=InputBit.CW_LIMIT.value | level * home, starting_speed=1
    )
    assert configuration.active_inputs(energized * home) == active * home


def test_level_counts_only_for_used_inputs():
    configuration = Configuration(inputs_used=0b01_0100, active_high=0b01_0100, starting_speed=1)
    assert configuration.active_inputs(0) == 0
    assert configuration.active_inputs(ALL_INPUTS) == 0b01_0100


def test_what_input_words_4_and_5_count():
    plain = Configuration(inputs_used=0b01_0100, starting_speed=1)
    encoder = Configuration(inputs_used=0b01_0100, quadrature_encoder=True, starting_speed=1)
    feedback = Configuration(
        inputs_used=0b01_0100, diagnostic_feedback=True, step_and_direction=True, starting_speed=1
    )
    assert [each.encoder_counted for each in (plain, encoder, feedback)] == [False, True, True]


@pytest.mark.parametrize("lsw", [0, ALL_INPUTS])
@pytest.mark.parametrize(
    ("bits", "option"),
    [
        ((6,), "backplane_proximity"),
        ((8,), "quadrature_encoder"),
        ((9,), "diagnostic_feedback"),
        ((8, 12), "marker_home"),
    ],
)
def test_each_option_is_read_from_the_msw(bits, option, lsw):
    """Marker homing asks for an encoder; the LSW has bits of its own."""
    msw = VALID_MSW | sum(1 << bit for bit in bits)
    configuration = Configuration.from_image(Image(words(msw, lsw)))
    assert getattr(configuration, option)
    assert configuration.to_image() == Image(words(msw, lsw))
    assert not getattr(Configuration.from_image(Image(words(VALID_MSW, lsw))), option)
