"""The instructions of a PMC006x3s, one row each, as in the manual's summary table [4.2].

An out-of-range value is refused with error 6 (reading: the manual names no error). If a parameter's range
does not include 0, sending 0 reads its value [4.1.1: "some setting instructions can write 0 to read
the function"].
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any

INT32_MAX = 0x7FFFFFFF
MICROSTEPS = (0, 2, 4, 8, 16, 32, 64, 128)
"""Microstepping settings; 0 is full steps [4.3.2]."""

ENCODER_CPRS = (200, 400, 500, 600, 800, 1000, 1024, 1200, 1600)
"""Encoder counts per revolution [4.3.10, which prints 1000 twice]."""

ACCELERATIONS_PPS2 = (0, 77440, 48410, 27170, 21510, 14080, 10460, 6915, 5210)
"""Acceleration in steps/s/s by coefficient [4.3.3]; coefficient 0 means no ramp."""


SHORT_MOVE_STEPS = 256
"""A move of fewer steps has no S-curve [4.3.3]."""


class Kind(Enum):
    """Function of an instruction."""

    SET = "set"  # writes a parameter
    READ = "read"  # returns a value
    ACTION = "action"


class ParameterStorage(Enum):
    """Where a parameter is stored."""

    VOLATILE = "volatile"  # it has its default after every power-up
    SAVED = "saved by t"  # the instruction t writes it to the EEPROM; power-up restores it
    EEPROM = "EEPROM"  # it is written to the EEPROM at once


@dataclass(frozen=True, slots=True)
class InstructionRow:
    """One row of the summary table."""

    char: str  # the instruction's byte in the notation of the manual
    name: str  # scanrack's name of it, and of its parameter
    kind: Kind
    meaning: str
    low: int | None = None  # lowest value; None if the data are ignored
    high: int | None = None  # highest value
    values: tuple[int, ...] = ()  # all allowed values, if they are not a range
    unit: str = ""
    default: int = 0
    keeping: ParameterStorage = ParameterStorage.VOLATILE
    shows: str = ""  # the parameter that a read returns
    note: str = ""  # a misprint or a reading of this row

    @property
    def code(self) -> int:
        """The instruction's byte."""
        return ord(self.char)

    @property
    def asks_by_zero(self) -> bool:
        """Whether data 0 reads the parameter."""
        return self.kind is Kind.SET and not self.allows(0)

    def allows(self, value: int) -> bool:
        """Return whether a value may be sent."""
        if self.values:
            return value in self.values
        return self.low is None or self.high is None or self.low <= value <= self.high

    @property
    def allowed(self) -> str:
        """The allowed values as text; "" if the data is ignored."""
        if self.values:
            return ", ".join(str(value) for value in self.values)
        return "" if self.low is None else f"{self.low} to {self.high}"


def _set(
    char: str,
    name: str,
    meaning: str,
    low: int,
    high: int,
    keeping: ParameterStorage = ParameterStorage.VOLATILE,
    **more: Any,
) -> InstructionRow:
    return InstructionRow(char, name, Kind.SET, meaning, low, high, keeping=keeping, **more)


def _read(char: str, name: str, meaning: str, shows: str = "", note: str = "") -> InstructionRow:
    return InstructionRow(char, name, Kind.READ, meaning, shows=shows, note=note)


def _act(
    char: str,
    name: str,
    meaning: str,
    low: int | None = None,
    high: int | None = None,
    unit: str = "",
    note: str = "",
) -> InstructionRow:
    return InstructionRow(char, name, Kind.ACTION, meaning, low, high, unit=unit, note=note)


SAVED, EEPROM, VOLATILE = ParameterStorage.SAVED, ParameterStorage.EEPROM, ParameterStorage.VOLATILE

# fmt: off
INSTRUCTIONS: tuple[InstructionRow, ...] = (
    _set("4", "solenoid", "solenoid valve or brake", 0, 100, unit="%"),
    _set("7", "user_data", "user data", -(1 << 31), INT32_MAX, EEPROM, note="32 bits of any kind"),
    _act("8", "zero_back", "back to zero; the data are the maximum stroke", 1, INT32_MAX, unit="steps"),
    _set("9", "zero_back_speed", "speed back to zero", 1, 256_000, unit="steps/s", default=600,
         note="default not printed; reading 600"),
    _set("F", "offline_execution", "run the user program at power-up", 0, 1, SAVED),
    _act("I", "abort", "stop at once, without a ramp"),
    _set("J", "ext_trigger_mode", "edges that trigger EXT1 (bit 0) and EXT2 (bit 1): 0 falling, 1 rising",
         0, 3, SAVED),
    _set("L", "start_speed", "speed at which a move starts", 65, 30_000, SAVED, unit="steps/s", default=600),
    _set("M", "encoder_cpr", "encoder counts per revolution", 200, 1600, SAVED, values=ENCODER_CPRS,
         default=1000,
         note="4.3.7 calls 4Dh the attenuation instruction, a misprint; default not printed, reading 1000"),
    _set("N", "speed_mode", "1 runs until stopped, 0 slows to a stop", 0, 1),
    _set("Q", "current_attenuation", "what remains of the current at rest: 100, 50, 25, 12.5 %", 0, 3, SAVED,
         default=1),
    _set("S", "stop_speed", "speed at which a move stops", 65, 30_000, SAVED, unit="steps/s", default=600),
    _act("Z", "run_user_program", "test run of the user program", note="the table prints z (0x5a)"),
    _set("a", "auto_current_decay", "reduce the current while the motor rests", 0, 1, SAVED),
    _act("b", "clear_ext1_flag", "clear the emergency stop of EXT1"),
    _set("d", "direction", "0 backward, 1 forward", 0, 1, default=1, note="default not printed; reading 1"),
    _set("e", "peak_current", "peak phase current", 400, 3000, SAVED, unit="mA", default=1000,
         note="default not printed; reading 1000"),
    _set("f", "ext_stop_enable", "emergency stop by EXT1 (1), EXT2 (2), both (3)", 0, 3),
    _set("g", "free_run", "offline enable: 1 releases the motor", 0, 1),
    _set("i", "set_position", "current position", 0, INT32_MAX, unit="steps",
         note="negative values only with the option i_signed"),
    _act("l", "clear_ext2_flag", "clear the emergency stop of EXT2"),
    _set("m", "microstepping", "microsteps per step", 0, 128, SAVED, values=MICROSTEPS, default=16,
         note="256 is in the table only; refused without the option max_microstep"),
    _set("o", "decel_coefficient", "deceleration, by 4.3.3's table", 0, 8, SAVED, default=5),
    _act("s", "step", "run so many steps", 1, INT32_MAX, unit="steps"),
    _act("t", "save_parameters", "save the parameters into the EEPROM"),
    _set("u", "accel_coefficient", "acceleration, by 4.3.3's table", 0, 8, SAVED, default=5,
         note="the table prints 0-5, 4.3.3 has 0 to 8"),
    _set("v", "max_speed", "speed of moves", 1, 256_000, unit="steps/s", default=6000,
         note="default not printed; reading 6000"),
    _set("w", "device_address", "address; counts at once", 1, 120, SAVED, default=255,
         note="4.1.2 prints 1 to 50; 255 is the factory's and cannot be set"),
    _act("y", "write_io", "GPIO word of twelve bits", 0, 0xFFF,
         note="the table prints 0~0xff, 4.3.14 sends 0182h"),
    _set(":", "silence_coefficient", "silence coefficient, without effect here", 0, 7,
         note="'minimum 7' is a misprint for maximum"),
    _read("6", "read_user_data", "user data", "user_data"),
    _read("K", "read_ext_trigger_mode", "trigger mode of EXT1 and EXT2", "ext_trigger_mode"),
    _read("O", "read_status2", "status register 2", note="the table prints 0(0x4f)"),
    _read("P", "read_device_id", "device id"),
    _read("R", "read_firmware", "firmware version", note="coding not printed; reading 00010000h for V0.1.0"),
    _read("c", "read_position", "current position, signed"),
    _read("h", "read_decel_coefficient", "deceleration coefficient", "decel_coefficient"),
    _read("j", "read_status1", "status register 1"),
    _read("k", "read_microstepping", "microstepping", "microstepping"),
    _read(";", "read_silence_coefficient", "silence coefficient", "silence_coefficient"),
    _read("x", "read_levels", "levels of the pins"),
)
# fmt: on

BY_CODE: dict[int, InstructionRow] = {row.code: row for row in INSTRUCTIONS}
BY_NAME: dict[str, InstructionRow] = {row.name: row for row in INSTRUCTIONS}

PARAMETERS: tuple[InstructionRow, ...] = tuple(
    row for row in INSTRUCTIONS if row.kind is Kind.SET and row.name not in ("set_position", "speed_mode")
)
"""The rows with a stored value."""
