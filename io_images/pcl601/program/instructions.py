"""The instruction set of stored programs: one row per instruction, in the order of the manual's tab sheets.

The manual shows the titles of instructions [section 3, "Add Tab Sheets"]; the short names are used in the
text format `pclt`. The manual does not list opcodes and sizes; it says only that an instruction takes 2 to 7
of the 2,046 bytes. Interpretation: an instruction has its opcode, a second byte with words such as ON and CW,
and its values. A value takes 1 byte if it is at most 255, 2 bytes if it is at most 65,535, and otherwise 4. A
loop takes all 7 bytes. A text does not fit into 7 bytes, so it takes 2 bytes plus its characters.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from .operands import Choice, Digits, Label, Number, Operand, Text

CAPACITY_BYTES = 2046
"""Program memory, bytes [section 3]."""


@dataclass(frozen=True, slots=True)
class Instruction:
    """A row of the instruction table."""

    name: str  # in the text format, in upper case
    operands: tuple[Operand, ...]  # after the name
    needs_idle: bool  # whether it ends the program with error 1024 during motion
    title: str  # the manual's name

    @property
    def size(self) -> int:
        """Bytes of program memory, not counting the characters of a text."""
        return 2 + sum(operand.width for operand in self.operands)


ON_OFF = Choice(("ON", "OFF"))
CW_CCW = Choice(("CW", "CCW"))
TARGET = Label(2)
PASSES = Number(1, 65_535, 3, "a number of passes")
STEPS_MAX = 8_388_607
BIT = Number(0, 1, 1, "a level")
INPUT = Number(1, 6, 1, "an input")


def _number(low: int, high: int, width: int, name: str) -> tuple[Number]:
    return (Number(low, high, width, name),)


def _speed(high: int = 50_000) -> tuple[Number]:
    return _number(1, high, 2, "a speed in steps/s")


def _byte(low: int, name: str) -> tuple[Number]:
    return _number(low, 255, 1, name)


_STEPS = _number(1, STEPS_MAX, 4, "a number of steps")
_POSITION = _number(-STEPS_MAX, STEPS_MAX, 4, "a position")
_UP_TO_64K = 65_535

INSTRUCTIONS: tuple[Instruction, ...] = (
    # Motion Commands
    Instruction("ACCEL", _number(100, 9_999_999, 4, "an acceleration in steps/s²"), True, "Accel/Decel"),
    Instruction("BASE", _speed(5_000), True, "Base Speed"),
    Instruction("MAX", _speed(), True, "Max Speed"),
    Instruction("JOG", _speed(), True, "Set Jog Speed"),
    Instruction("SETPOS", _POSITION, True, "Set Position"),
    Instruction("DIR", (CW_CCW,), True, "Direction CW (CCW)"),
    Instruction("CURRENT", (ON_OFF,), False, "Motor Current ON (OFF)"),
    Instruction("WAIT", _number(1, _UP_TO_64K, 2, "a time in ms"), False, "Wait ___ Milliseconds"),
    Instruction("MOVE", _STEPS, True, "Move ___ Steps"),
    Instruction("MOVETO", _POSITION, True, "Move to Position"),
    Instruction("FINISH", (), False, "Finish Move"),
    Instruction("REPEAT", (), True, "Repeat Last Move"),
    Instruction("HOME0", (), True, "Home to Soft, Home Limits"),
    Instruction("HOME1", (), True, "Home to Home Limit"),
    Instruction("SLEW", (), True, "Slew (move continuously)"),
    Instruction("STOPSOFT", (), False, "Stop Soft"),
    Instruction("STOPHARD", (), False, "Stop Hard"),
    Instruction("END", (), False, "End of Program"),
    # If/Then and Output Commands
    Instruction("IF INPUTS", (Digits(6),), False, "If inputs match below then execute the next line"),
    Instruction("IF INPUT", (INPUT, BIT), False, "If input matches, then execute the next line"),
    Instruction("OUTPUTS", (Digits(8),), False, "Set Outputs"),
    # Goto, For Loops, Encoder and Thumbwheel Commands
    Instruction("GOTO", (TARGET,), False, "Goto"),
    Instruction("LABEL", (Label(0),), False, "Label"),
    Instruction("RETURN", (), False, "Return from Subroutine"),
    Instruction("LOOP OUTER", (PASSES, TARGET), False, "Outer Loop"),
    Instruction("LOOP INNER", (PASSES, TARGET), False, "Inner Loop"),
    Instruction("THUMB", (ON_OFF,), False, "Thumbwheel Index Off (On)"),
    Instruction("MOVETHUMB", (), True, "Move Thumbwheel Index"),
    Instruction("ENC", (ON_OFF,), False, "Encoder Auto Correct Off (On)"),
    Instruction("ENCDELAY", _number(0, _UP_TO_64K, 2, "a time in ms"), False, "Delay"),
    Instruction("ENCRATIO", _byte(1, "a ratio"), False, "Motor Ratio"),
    Instruction("ENCRETRIES", _byte(0, "a number of retries"), False, "Retries"),
    Instruction("ENCWINDOW", _byte(0, "a window in counts"), False, "Window"),
    Instruction("ENCRESET", (), False, "Reset Encoder Count"),
    # Analog, Registration and Text Commands
    Instruction("ASPEED", (ON_OFF,), False, "Analog Speed On (Off)"),
    Instruction("SETASPEED", (), True, "Set Analog Speed"),
    Instruction("ASPEEDLO", _speed(), False, "Analog Speed Lower Limit"),
    Instruction("ASPEEDHI", _speed(), False, "Analog Speed Upper Limit"),
    Instruction("APOS", (ON_OFF,), False, "Analog Position On (Off)"),
    Instruction("GOTOAPOS", (), True, "Goto Analog Position"),
    Instruction("APOSLO", _number(0, _UP_TO_64K, 2, "a position"), False, "Analog Position Lower Limit"),
    Instruction("APOSHI", _number(0, _UP_TO_64K, 2, "a position"), False, "Analog Position Upper Limit"),
    Instruction("OOTF", (ON_OFF,), False, "Output on the Fly On (Off)"),
    Instruction("OOTFPOS", _number(0, _UP_TO_64K, 2, "a position"), False, "1st Output Position"),
    Instruction("OOTFSTEP", _number(0, _UP_TO_64K, 2, "a number of steps"), False, "Steps Between Outputs"),
    Instruction("OOTFCOUNT", _byte(0, "a number of outputs"), False, "# of Output Counts"),
    Instruction("IOTF", (ON_OFF,), False, "Index on the Fly On (Off)"),
    Instruction("REGINDEX", _STEPS, True, "Registration Index"),
    Instruction("TEXT", (Text(),), False, "Send Text*"),
)

BY_NAME: Mapping[str, Instruction] = {row.name: row for row in INSTRUCTIONS}
