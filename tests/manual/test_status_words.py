"""Chapter 6: the status bits, and chapter 3: the words of configuration mode."""

import pytest
from scanrack.io_images.amci3601 import (
    Configuration,
    ConfigurationStatus,
    Firmware,
    Status,
    StatusLsw,
    StatusMsw,
    StatusView,
    status_names,
)
from scanrack.io_images.image import Image

MSW = [
    "MOVING_CW",
    "MOVING_CCW",
    "HOLD_STATE",
    "STOPPED",
    "AT_HOME",
    "ACCELERATING",
    "DECELERATING",
    "MOVE_COMPLETE",
    "HOME_INVALID",
    "INVALID_PROFILE",
    "POSITION_INVALID",
    "INPUT_ERROR",
    "COMMAND_ERROR",
    "CONFIG_ERROR",
    "MODULE_OK",
    "MODE_CONFIG",
]
LSW = {
    0: "IN_CAPTURE",
    1: "IN_EXTERNAL",
    2: "IN_HOME",
    3: "IN_ESTOP",
    4: "IN_CW_LIMIT",
    5: "IN_CCW_LIMIT",
    7: "ENC_FOLLOWER",
    8: "BLEND_RUNNING",
    9: "BLEND_ACK",
    10: "MIN_REG_NONZERO",
    12: "HOME_PROX_ECHO",
}
ALL_NAMES = MSW + list(LSW.values())


def lit(view):
    return [name for name in ALL_NAMES if getattr(view, name)]


@pytest.mark.parametrize(
    ("number", "name"),
    [pytest.param(*row, id=f"chapter 6 Status Word MSW bit {row[0]}") for row in enumerate(MSW)],
)
def test_status_msw(number, name):
    word = 1 << number
    assert StatusMsw[name].value == word
    assert lit(StatusView(Image([word]))) == [name]
    if name != "MODE_CONFIG":
        assert Status.from_image(Image([word])) == Status(**{name.lower(): True})
        assert status_names(word, 0) == [name]


@pytest.mark.parametrize(
    ("number", "name"),
    [pytest.param(*row, id=f"chapter 6 Status Word LSW bit {row[0]}") for row in LSW.items()],
)
def test_status_lsw(number, name):
    word = 1 << number
    assert StatusLsw[name].value == word
    assert lit(StatusView(Image([0, word]))) == [name]
    assert Status.from_image(Image([0, word])) == Status(**{name.lower(): True})
    assert status_names(0, word) == [name]


@pytest.mark.parametrize("number", sorted(set(range(16)) - set(LSW)))
def test_reserved_status_bits(number):
    with pytest.raises(ValueError, match="reserved"):
        Status.from_image(Image([0, 1 << number]))
    assert lit(StatusView(Image([0, 1 << number]))) == []


def test_values_in_their_words():
    """Chapter 6, Generic Input Data: position in 2 and 3, encoder in 4 and 5, captured in 6 and 7."""
    image = Image([0x4000, 0, -12, -345, 12, 0, 0, 345])
    status = Status.from_image(image)
    assert (status.position, status.encoder, status.captured) == (-12_345, 12_000, 345)
    view = StatusView(image)
    assert (view.position, view.encoder, view.captured) == (-12_345, 12_000, 345)


def test_configuration_mode_mirrors():
    """Chapter 3, Configuration Mode Input Data: mirror, 4 and 5 zero, then the firmware revision."""
    sent = Configuration(inputs_used=0x3E, step_and_direction=True, starting_speed=12_345).to_image()
    mirror = (sent[0] & 0x1FFF, sent[1], sent[2], sent[3])
    status = ConfigurationStatus(mirror, config_error=False, module_ok=True, firmware=Firmware(3, 1))
    image = status.to_image()
    assert image[0] & 0x1FFF == sent[0] & 0x1FFF
    assert list(image)[1:4] == list(sent)[1:4]
    assert list(image)[4:] == [0, 0, 3, 1]


def test_bits_13_to_15_are_never_mirrored():
    """Chapter 3, note: they are configuration error, module OK and mode in either mode."""
    for error, ok in ((False, True), (True, True), (True, False), (False, False)):
        image = ConfigurationStatus((0x1FFF, 0, 0, 0), error, ok, Firmware(2, 0)).to_image()
        assert (image.bit(0, 13), image.bit(0, 14), image.bit(0, 15)) == (error, ok, True)
        names = ["CONFIG_ERROR"] * error + ["MODULE_OK"] * ok + ["MODE_CONFIG"]
        assert lit(StatusView(image)) == names
        assert status_names(image[0], image[1]) == names
    with pytest.raises(ValueError, match="bits 13 to 15"):
        ConfigurationStatus((0x2000, 0, 0, 0), False, True, Firmware(2, 0))


def test_mirror_is_not_taken_for_status():
    """Every mirrored bit set: not one of them is a status bit."""
    image = Image([0x9FFF - 0x10000, -1, 0, 0, 0, 0, 4, 1])
    assert lit(StatusView(image)) == ["MODE_CONFIG"]


def test_either_mode_refuses_the_other():
    with pytest.raises(ValueError, match="configuration mode"):
        Status.from_image(Image([0xC000]))
    with pytest.raises(ValueError, match="command mode"):
        ConfigurationStatus.from_image(Image([0x4000]))
    with pytest.raises(ValueError, match="words 4 and 5"):
        ConfigurationStatus.from_image(Image([0xC000, 0, 0, 0, 1]))


def test_view_is_live():
    image = Image()
    view = StatusView(image)
    assert not view.MOVE_COMPLETE
    image.set_bit(0, 7, True)
    assert view.MOVE_COMPLETE is True
    image.load(Image([0, 4, 0, 345]))
    assert (view.MOVE_COMPLETE, view.IN_HOME, view.position) == (False, True, 345)
