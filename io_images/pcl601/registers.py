"""The PCL601's 38 data registers, in the order of the memory map [Appendix 1].

A 32-bit value has two registers, with the low word at the lower address. The manual states the range of such
a value once, so the table has 32 rows, one per value. 4x reference n is address n - 1 in a frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum, auto

FIRMWARE = "1.00"
"""Firmware version, as in function 0x11 and Appendix 6."""


class Register(IntEnum):
    """A value of the memory map in one or two registers; the numbers are internal."""

    COMMAND = auto()
    STEPS = auto()
    ACCEL = auto()
    BASE_SPEED = auto()
    MAX_SPEED = auto()
    JOG_SPEED = auto()
    DIRECTION = auto()
    ADDRESS = auto()
    ANALOG_ENABLE = auto()
    MOTOR_CURRENT = auto()
    POSITION = auto()
    ABS_TARGET = auto()
    ANALOG_SPEED_LOWER = auto()
    ANALOG_SPEED_UPPER = auto()
    ANALOG_POS_LOWER = auto()
    ANALOG_POS_UPPER = auto()
    INDEX_ON_FLY = auto()
    THUMBWHEEL_ENABLE = auto()
    OUTPUT_ON_FLY = auto()
    FIRST_OUTPUT_POSITION = auto()
    STEPS_BETWEEN_OUTPUTS = auto()
    NUMBER_OF_OUTPUTS = auto()
    ENCODER_DELAY = auto()
    ENCODER_WINDOW = auto()
    ENCODER_RATIO = auto()
    ENCODER_AUTOCORRECT = auto()
    ENCODER_RETRIES = auto()
    ENCODER_POSITION = auto()
    ANALOG_INDEX = auto()
    BUSY = auto()
    ERROR_CODE = auto()
    FIRMWARE = auto()


@dataclass(frozen=True, slots=True)
class Row:
    """One row of the memory map."""

    register: Register
    reference: int  # 4x reference of its only or low word, from 1
    words: int  # number of registers, 1 or 2
    low: int
    high: int
    default: int  # after power-up and reset
    meaning: str  # the manual's name, with the unit
    ascii: str = ""  # the AA ASCII command that writes or reads it; "" without one
    writable: bool = True  # whether it is Read/Write in the map
    locked: bool = False  # whether it is read-only during motion
    kept: bool = False  # whether it is non-volatile

    @property
    def address(self) -> int:
        """Address of its only or low word in a frame."""
        return self.reference - 1

    def allows(self, value: int) -> bool:
        """Return whether a value is in the printed range."""
        return self.low <= value <= self.high

    @property
    def allowed(self) -> str:
        """The printed range as text."""
        return f"{self.low} to {self.high}"


POSITION_LIMIT = 8_388_607
"""Maximum steps of an index, and maximum absolute position [Functions]."""

_FAR = POSITION_LIMIT
_FIRMWARE_WORDS = int.from_bytes(FIRMWARE.encode(), "big")  # coding not stated: the bytes of function 0x11

MAP: tuple[Row, ...] = (
    Row(Register.COMMAND, 1, 1, 0, 15, 0, "Command Register"),  # printed 1 to 15; 0 does nothing
    Row(Register.STEPS, 2, 2, 0, _FAR, 0, "Number of Steps", "N"),
    Row(Register.ACCEL, 4, 2, 100, 9_999_999, 1000, "Acceleration, steps/s²", "A", locked=True),
    Row(Register.BASE_SPEED, 6, 1, 1, 5000, 500, "Base Speed, steps/s", "B", locked=True),
    Row(Register.MAX_SPEED, 7, 1, 1, 50_000, 5000, "Maximum Speed, steps/s", "M", locked=True),
    Row(Register.JOG_SPEED, 8, 1, 1, 50_000, 5000, "Jog Speed, steps/s", "J", locked=True),
    Row(Register.DIRECTION, 9, 1, 0, 1, 1, "Direction (CW = 1, CCW = 0)", "+ -", locked=True),
    Row(Register.ADDRESS, 10, 1, 1, 99, 1, "Device Address", "~ %", kept=True),  # ~ also takes 0
    Row(Register.ANALOG_ENABLE, 11, 1, 0, 1, 0, "Analog Enable", ": ;"),  # writes both, reads either
    Row(Register.MOTOR_CURRENT, 12, 1, 0, 1, 1, "Motor Current Enabled", "T"),
    Row(Register.POSITION, 13, 2, -_FAR, _FAR, 0, "Current Position", "Z", locked=True),
    Row(Register.ABS_TARGET, 15, 2, -_FAR, _FAR, 0, "Absolute position", "P"),
    Row(Register.ANALOG_SPEED_LOWER, 17, 1, 1, 50_000, 1, "Analog speed lower limit, steps/s", "["),
    Row(Register.ANALOG_SPEED_UPPER, 18, 1, 1, 50_000, 50_000, "Analog speed upper limit, steps/s", "]"),
    Row(Register.ANALOG_POS_LOWER, 19, 1, 0, 65_535, 0, "Analog position lower limit", "{"),
    Row(Register.ANALOG_POS_UPPER, 20, 1, 0, 65_535, 65_535, "Analog position upper limit", "}"),
    Row(Register.INDEX_ON_FLY, 21, 1, 0, 1, 0, "Index on the fly enable", "'"),
    Row(Register.THUMBWHEEL_ENABLE, 22, 1, 0, 1, 0, "Thumbwheel index enable", "/"),
    Row(Register.OUTPUT_ON_FLY, 23, 1, 0, 1, 0, "Output on the fly enable", "("),
    Row(Register.FIRST_OUTPUT_POSITION, 24, 1, 0, 65_535, 0, "First output on the fly position", "D"),
    Row(Register.STEPS_BETWEEN_OUTPUTS, 25, 1, 0, 65_535, 0, "Steps between outputs on the fly", "C"),
    Row(Register.NUMBER_OF_OUTPUTS, 26, 1, 0, 255, 0, "Number of outputs on the fly", "^"),
    Row(Register.ENCODER_DELAY, 27, 1, 0, 65_535, 0, "Encoder delay, ms", "ED"),
    Row(Register.ENCODER_WINDOW, 28, 1, 0, 255, 0, "Encoder window, encoder pulses", "EW"),
    Row(Register.ENCODER_RATIO, 29, 1, 1, 255, 1, "Encoder ratio, encoder pulses per step", "EM"),
    Row(Register.ENCODER_AUTOCORRECT, 30, 1, 0, 1, 0, "Encoder autocorrect enable", "EA"),
    Row(Register.ENCODER_RETRIES, 31, 1, 0, 255, 0, "Encoder retries", "ER"),
    Row(Register.ENCODER_POSITION, 32, 2, -_FAR, _FAR, 0, "Encoder position", "EP", writable=False),
    Row(Register.ANALOG_INDEX, 34, 1, 0, 65_535, 0, "Analog index", writable=False),  # 0 - 9,999,999 printed
    Row(Register.BUSY, 35, 1, 0, 1, 0, "Busy", "F", writable=False),
    Row(Register.ERROR_CODE, 36, 1, 0, 16_383, 0, "Error code register", "!", writable=False),
    Row(Register.FIRMWARE, 37, 2, 0, 0xFFFFFFFF, _FIRMWARE_WORDS, "Firmware version", "$", writable=False),
)  # fmt: skip

ROWS: dict[Register, Row] = {row.register: row for row in MAP}
"""The rows by value."""

WORDS: tuple[tuple[Row, int], ...] = tuple((row, word) for row in MAP for word in range(row.words))
"""The row at each address, with 0 for the row's only or low word, and 1 for its high word."""

WORD_COUNT = len(WORDS)
"""Registers in the map."""


def firmware_text(value: int) -> str:
    """Return the firmware version as its four characters, or as a number if they are not text.

    >>> firmware_text(0x312E3030), firmware_text(0x00000102)
    ('1.00', '00000102h')
    """
    text = value.to_bytes(4, "big").decode("ascii", "replace").rstrip("\0 ")
    return text if text.isascii() and text.isprintable() and text else f"{value:08X}h"


def word_of(value: int, word: int) -> int:
    """Return the low (0) or high (1) word of a value in two's complement.

    >>> word_of(-3000, 0), word_of(-3000, 1)
    (62536, 65535)
    """
    return value >> 16 * word & 0xFFFF


def with_word(row: Row, value: int, word: int, bits: int) -> int:
    """Return a value with its low (0) or high (1) word replaced; a two-word value is signed.

    >>> with_word(ROWS[Register.POSITION], 62536, 1, 0xFFFF)
    -3000
    """
    joined = value & 0xFFFFFFFF & ~(0xFFFF << 16 * word) | bits << 16 * word
    return joined - (1 << 32) if row.words == 2 and joined >> 31 else joined
