"""User programs of a PMC006x3s: the 20 instructions and their text form [5].

    DIR  0 1        # forward
    CNTC 0          # one instruction per line: OP option data
    ROT  0 300      # line 2; lines are numbered from 0
    WAIT 1 1        # until the motor is idle
    CNT1 0
    CMP  1 3
    JNE  0 2

The text form is scanrack's own, since the vendor's tool shows a table. The manual does not explain the
options of WAIT and CMP: "refer to the tool". The interpreter's `WAIT_OPTIONS` and `CMP_OPTIONS` are therefore
readings. The manual's table (1-7 and 1-6) takes precedence over its text ("9 options").
"""

from __future__ import annotations

import difflib
from dataclasses import dataclass

from .instructions import INT32_MAX, MICROSTEPS

MAX_LINES = 100
"""Maximum instructions of a program [5]."""

EDITOR_MAX_TARGET = 50
"""Maximum jump target in the manual's table [5.1.1]."""


@dataclass(frozen=True, slots=True)
class UserOp:
    """One row of the user instruction set summary [5.1.1]."""

    name: str
    meaning: str
    options: tuple[int, int] = (0, 0)  # first and last option
    data: tuple[int, int] | None = None  # first and last value of the data; None without data
    values: tuple[int, ...] = ()  # all allowed data, if they are not a range
    usual: tuple[int, int] | None = None  # the manual's range; other allowed values get a warning

    @property
    def allowed_data(self) -> str:
        """The allowed data as text."""
        if self.values:
            return ", ".join(str(value) for value in self.values)
        return "none, or 0" if self.data is None else f"{self.data[0]} to {self.data[1]}"

    def allows(self, value: int) -> bool:
        """Return whether a value is allowed as data."""
        lowest, highest = self.data or (0, 0)
        return value in self.values if self.values else lowest <= value <= highest


_BIT = (0, 1)
_TARGET = (0, MAX_LINES - 1)
_USUAL_TARGET = (0, EDITOR_MAX_TARGET)

USER_OPS: dict[str, UserOp] = {
    op.name: op
    for op in (
        UserOp("ROT", "start a move of so many steps; does not wait for its end", data=(1, INT32_MAX)),
        UserOp("MIC", "microstepping", data=(0, 128), values=MICROSTEPS),
        UserOp("DIR", "direction: 0 reverse, 1 forward", data=_BIT),
        UserOp("EXTEN", "emergency stop: 1 EXT1, 2 EXT2, 3 both", data=(0, 3), usual=_BIT),
        UserOp("FREE", "1 releases the motor", data=_BIT),
        UserOp("CLR2", "clear the emergency stop of EXT2"),
        UserOp("CLR1", "clear the emergency stop of EXT1"),
        UserOp("VSET", "speed in steps/s; 0 is passed over", data=(0, 6000)),
        UserOp("ACC", "acceleration and deceleration coefficient", data=(0, 8), usual=(3, 6)),
        UserOp("TRIG", "trigger mode of EXT1 and EXT2, as instruction J", data=(0, 3)),
        UserOp("CNT1", "counter + 1"),
        UserOp("CNTC", "counter = 0"),
        UserOp("JMP", "go to a line", data=_TARGET, usual=_USUAL_TARGET),
        UserOp("JNE", "go to a line if the last CMP was unequal", data=_TARGET, usual=_USUAL_TARGET),
        UserOp("JEQ", "go to a line if the last CMP was equal", data=_TARGET, usual=_USUAL_TARGET),
        UserOp("WAIT", "wait until what the option stands for equals the data", (1, 7), _BIT),
        UserOp("OUT", "level of an output port; port 1 is GPIO8, the others are not there", (1, 5), _BIT),
        UserOp("CMP", "compare what the option stands for with the data", (1, 6), (0, 65_536)),
        UserOp("RESET_EN", "1: a low pulse on GPI1 stops all and goes to a line", (0, 1), _TARGET,
               usual=_USUAL_TARGET),
        UserOp("PAUSE_EN", "1: a low pulse on GPI2 pauses the program, the next one resumes it",
               (0, 1), (0, 0)),
    )
}  # fmt: skip
"""The user instructions by name, in the manual's order."""

SPELLINGS = {"CNTI": "CNT1"}
"""Other names of instructions in the manual [5.1.2.1]."""


@dataclass(frozen=True, slots=True)
class UserInstruction:
    """A line of a user program."""

    op: str  # name in `USER_OPS`
    option: int  # port or condition, 0 if it has none
    data: int  # 0 if it has none

    def __str__(self) -> str:
        """Return the line in the text form."""
        data = "" if USER_OPS[self.op].data is None else f" {self.data}"
        return f"{self.op} {self.option}{data}"


@dataclass(frozen=True, slots=True)
class UserProgram:
    """A user program with the assembler's warnings."""

    lines: tuple[UserInstruction, ...] = ()  # up to `MAX_LINES`
    warnings: tuple[str, ...] = ()  # about values beyond the manual's table


def assemble(text: str) -> UserProgram:
    """Return the program that a text contains; raise a ValueError if it is invalid.

    >>> assemble("DIR 0 1 # forward" + chr(10) + "ROT 0 287").lines[1]
    UserInstruction(op='ROT', option=0, data=287)

    Args:
        text: one instruction per line, `OP option data` separated by spaces; `#` starts a comment.
            Instructions without data may omit data and option.
    """
    lines: list[UserInstruction] = []
    warnings: list[str] = []
    for number, line in enumerate(text.splitlines(), start=1):
        words = line.partition("#")[0].split()
        if words:
            try:
                instruction = _instruction(words)
            except ValueError as error:
                raise ValueError(f"line {number}: {error}") from None
            lines.append(instruction)
            warnings += _warnings(number, instruction)
    if len(lines) > MAX_LINES:
        raise ValueError(f"{len(lines)} instructions: must be at most {MAX_LINES}")
    return UserProgram(tuple(lines), tuple(warnings))


def _instruction(words: list[str]) -> UserInstruction:
    """Return the instruction that a line's words form; raise a ValueError if there is none."""
    name = SPELLINGS.get(words[0].upper(), words[0].upper())
    op = USER_OPS.get(name)
    if op is None:
        close_names = difflib.get_close_matches(name, USER_OPS, n=1)
        hint = f"; did you mean {close_names[0]}?" if close_names else f"; choose from {', '.join(USER_OPS)}"
        raise ValueError(f"{words[0]} is not a user instruction{hint}")
    least_words = 1 if op.data is None else 3
    if not least_words <= len(words) <= 3:
        raise ValueError(f"{' '.join(words)}: {name} takes an option and data, as in {_example(op)}")
    option = _number(name, "option", words[1]) if len(words) > 1 else 0
    if not op.options[0] <= option <= op.options[1]:
        raise ValueError(f"{name} option {option}: must be {_range(op.options)}")
    data = _number(name, "data", words[2]) if len(words) == 3 else 0
    if not op.allows(data):
        raise ValueError(f"{name} data {data}: must be {op.allowed_data}")
    return UserInstruction(name, option, data)


def _example(op: UserOp) -> str:
    data = () if op.data is None else (str(op.data[1]),)
    return " ".join((op.name, str(op.options[1]), *data))


def _range(ends: tuple[int, int]) -> str:
    return str(ends[0]) if ends[0] == ends[1] else f"{ends[0]} to {ends[1]}"


def _number(name: str, field: str, word: str) -> int:
    try:
        return int(word, 0)
    except ValueError:
        raise ValueError(f"{name} {field} {word}: must be a whole number") from None


def _warnings(number: int, line: UserInstruction) -> list[str]:
    """Return a warning if data that the module accepts is outside of the manual's table."""
    usual = USER_OPS[line.op].usual
    if usual is None or usual[0] <= line.data <= usual[1]:
        return []
    return [f"line {number}: {line}: the manual's table has {usual[0]} to {usual[1]} only"]
