"""Firmware versions and serial numbers: chapters 1 and 4, Manual Revision History."""

import pytest
from scanrack.io_images.amci3601 import KNOWN, Firmware

GATES = ("capture_without_encoder", "micrologix", "registration", "follower")


@pytest.mark.parametrize(
    ("version", "has"),
    [
        pytest.param("2.0", 0, id="before revision 0.1"),
        pytest.param("2.1", 1, id="revision 0.1: capture without encoder"),
        pytest.param("2.2", 2, id="chapter 1 MicroLogix 1500: 2.2 or higher"),
        pytest.param("3.1", 3, id="chapter 4 Registration Move: 3.1 and higher"),
        pytest.param("4.1", 4, id="chapter 4 Encoder Follower: 4.1 and higher"),
    ],
)
def test_what_a_version_can_do(version, has):
    firmware = Firmware.parse(version)
    assert [getattr(firmware, gate) for gate in GATES] == [index < has for index in range(4)]


@pytest.mark.parametrize(
    ("serial", "version"),
    [
        pytest.param(78_768, "2.0", id="chapter 1 MicroLogix 1500: less than 78769"),
        pytest.param(78_769, "2.2", id="chapter 1 MicroLogix 1500: 78769 or greater"),
        pytest.param(96_316, "2.2", id="chapter 4 Registration Move: less than 96317"),
        pytest.param(96_317, "3.1", id="chapter 4 Registration Move: starting with 96317"),
        pytest.param(4_060_161, "3.1", id="chapter 4 Encoder Follower: less than 04060162"),
        pytest.param("04060162", "4.1", id="chapter 4 Encoder Follower: starting with 04060162"),
        pytest.param("96317", "3.1", id="compared as a number, though 9 sorts after 0"),
    ],
)
def test_serial_numbers(serial, version):
    assert str(Firmware.of_serial(serial)) == version


def test_order():
    assert list(KNOWN) == sorted(KNOWN)
    assert [str(each) for each in KNOWN] == ["2.0", "2.1", "2.2", "3.1", "4.1"]
    assert Firmware(2, 10) > Firmware(2, 2)


@pytest.mark.parametrize("text", ["", "3", "3.0", "4.1.0", "newest", "4,1"])
def test_unknown_versions_are_refused(text):
    with pytest.raises(ValueError, match=r"choose from 2\.0, 2\.1, 2\.2, 3\.1, 4\.1"):
        Firmware.parse(text)


@pytest.mark.parametrize("serial", [0, -1, "", "A96317", "9.6", "²"])
def test_bad_serial_numbers_are_refused(serial):
    with pytest.raises(ValueError, match="positive decimal number"):
        Firmware.of_serial(serial)


@pytest.mark.parametrize(
    ("text", "version"),
    [
        ("serial 96316", "2.2"),
        ("serial 96317", "3.1"),
        ("Serial 04060161", "3.1"),
        ("serial 04060162", "4.1"),
    ],
)
def test_a_serial_number_stands_for_its_version(text, version):
    assert Firmware.parse(text) == Firmware.parse(version)
