"""Status bits of a PMC006x3s: two status registers, the pin levels, the GPIO word."""

from __future__ import annotations

from enum import IntFlag


class Status1(IntFlag):
    """Status register 1, instruction j [4.3.16]."""

    BUSY = 1 << 0  # the motor is moving; does not show the end of a zero-back
    EXT1 = 1 << 1  # emergency stop by EXT1, until `b` clears it
    EXT2 = 1 << 2  # emergency stop by EXT2, until `l` clears it
    AUTO_DEC = 1 << 3
    STALL = 1 << 4
    HOME = 1 << 6  # a zero-back is running
    UVL = 1 << 7  # supply below its limit


class Status2(IntFlag):
    """Status register 2, instruction O [4.3.16]."""

    FREE_RUN = 1 << 0
    EXT1_EN = 1 << 1
    COIL = 1 << 2
    SPEED_MODE = 1 << 3
    DIR = 1 << 4  # 1 is forward
    OFFLINE_AUTO = 1 << 5
    EXT2_EN = 1 << 6
    OTS = 1 << 7  # overheated


def firmware_text(value: int) -> str:
    """Return the firmware version as text and as a number, because its encoding is an interpretation.

    >>> firmware_text(0x0001_0000)
    'V0.1.0 (00010000h)'
    """
    version = value & 0xFFFF_FFFF
    return f"V{version >> 24}.{version >> 16 & 0xFF}.{version & 0xFFFF} ({version:08X}h)"


class Level(IntFlag):
    """Pin levels in the reply to instruction x; 1 is high [4.3.15]."""

    EXT2 = 1 << 0
    GPIO8 = 1 << 1
    EXT1 = 1 << 2
    FSET = 1 << 3


class Gpio(IntFlag):
    """The GPIO word of instruction y [4.3.14]; bits without a comment have no effect."""

    AN = 1 << 0
    GPIO8 = 1 << 1  # level of the 5 V output
    EXT1 = 1 << 2
    AN_EN = 1 << 3  # analog enable
    AN_PUD = 1 << 4  # input form of AN
    GPIO8_PUD = 1 << 5
    AN_DIR = 1 << 6
    GPIO8_DIR = 1 << 7
    GPIO9 = 1 << 8
    A = 1 << 9
    B = 1 << 10
    Z = 1 << 11


GPIO_EFFECTIVE = Gpio.GPIO8 | Gpio.AN_EN | Gpio.AN_PUD
"""Bits of the GPIO word that have an effect; the others are inputs or have no effect."""
