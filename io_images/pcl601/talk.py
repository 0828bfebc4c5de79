"""AA ASCII: the 41 commands, in the order of the summary [Anaheim Automation ASCII, Command Summary].

    @ address command parameters CR        address 1 or 2 digits, parameters up to 8 characters

The manual says 40; `|` was added for this product.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto

from .commands import Code
from .registers import Register

PARAMETERS_MAX = 8
"""Maximum characters of the parameters [Message Format]."""

BUFFER_MAX = 24
"""Maximum characters of a line in the receive buffer; the manual does not state it."""

VERSION_TEXT = "PCL601 1.00"
"""Reply to `$`; the manual does not state its text."""


class Action(Enum):
    """The effect of a command with parameters."""

    SET = auto()  # write a register; without parameters, execute the row's code if it has one
    DO = auto()  # execute the row's code; no parameters are allowed
    HOME = auto()
    DIRECTION = auto()
    ANALOG_POSITION = auto()
    ANALOG_SPEED = auto()
    OUTPUTS = auto()
    INPUTS = auto()
    VERIFY = auto()
    ERRORS = auto()
    VERSION = auto()
    ADDRESS = auto()
    SET_ADDRESS = auto()
    TO_MODBUS = auto()


@dataclass(frozen=True, slots=True)
class Command:
    """One row of the command summary."""

    name: str  # its one or two characters
    form: str  # its notation in the manual
    meaning: str  # the manual's name
    action: Action
    register: Register | None = None
    code: Code | None = None  # the equivalent command code
    while_running: bool = False  # whether it is accepted while a stored program runs


_ANALOG = Code.POSITION_FROM_ANALOG

COMMANDS: tuple[Command, ...] = (
    Command("A", "A[value]", "Acceleration/Deceleration", Action.SET, Register.ACCEL),
    Command("B", "B[value]", "Base speed", Action.SET, Register.BASE_SPEED),
    Command("C", "C[value]", "Steps between outputs", Action.SET, Register.STEPS_BETWEEN_OUTPUTS),
    Command("D", "D[value]", "1st output on the fly position", Action.SET, Register.FIRST_OUTPUT_POSITION),
    Command("EA", "EA[0 or 1]", "Encoder autocorrect enabled", Action.SET, Register.ENCODER_AUTOCORRECT),
    Command("ED", "ED[value]", "Encoder delay", Action.SET, Register.ENCODER_DELAY),
    Command("EM", "EM[value]", "Encoder motor ratio", Action.SET, Register.ENCODER_RATIO),
    Command("ER", "ER[value]", "Encoder retries", Action.SET, Register.ENCODER_RETRIES),
    Command("ET", "ET", "Encoder reset", Action.DO, code=Code.ENCODER_RESET),
    Command("EW", "EW[value]", "Encoder window", Action.SET, Register.ENCODER_WINDOW),
    Command("G", "G", "Go number of steps", Action.DO, code=Code.GO),
    Command("H", "H[0 or 1]", "Home", Action.HOME),
    Command("I", "IR, I[1-6]", "Read inputs", Action.INPUTS, while_running=True),
    Command("J", "J[value]", "Fast jog speed", Action.SET, Register.JOG_SPEED),
    Command("M", "M[value], M", "Max speed", Action.SET, Register.MAX_SPEED, Code.MAX_SPEED_FROM_ANALOG),
    Command("N", "N[value], N", "Number of steps", Action.SET, Register.STEPS, Code.STEPS_FROM_THUMBWHEEL),
    Command("O", "OR[value], O[1-8]=[0 or 1]", "Set outputs", Action.OUTPUTS),
    Command("P", "P[value], P", "Absolute position", Action.SET, Register.ABS_TARGET, _ANALOG),
    Command("S", "S", "Go slew", Action.DO, code=Code.GO_SLEW),
    Command("T", "T[0 or 1]", "Motor current enabled", Action.SET, Register.MOTOR_CURRENT),
    Command("V", "V[command]", "Verify", Action.VERIFY, while_running=True),
    Command("Z", "Z[value]", "Position", Action.SET, Register.POSITION),
    Command("!", "!", "Error codes register", Action.ERRORS, while_running=True),
    Command("$", "$", "Version number", Action.VERSION, while_running=True),
    Command("%", "%", "Verify axis number", Action.ADDRESS, while_running=True),
    Command("'", "'[0 or 1]", "Index on the fly enabled", Action.SET, Register.INDEX_ON_FLY),
    Command("(", "([0 or 1]", "Output on the fly enabled", Action.SET, Register.OUTPUT_ON_FLY),
    Command("+", "+", "Clockwise direction", Action.DIRECTION),
    Command(",", ",", "Stop soft", Action.DO, code=Code.STOP_SOFT),
    Command("-", "-", "Counterclockwise direction", Action.DIRECTION),
    Command(".", ".", "Stop hard", Action.DO, code=Code.STOP_MOTION, while_running=True),
    Command("/", "/[0 or 1]", "Thumbwheel enabled", Action.SET, Register.THUMBWHEEL_ENABLE),
    Command(":", ":[0 or 1]", "Analog position enabled", Action.ANALOG_POSITION),
    Command(";", ";[0 or 1]", "Analog speed enabled", Action.ANALOG_SPEED),
    Command("[", "[[value]", "Analog speed lower limit", Action.SET, Register.ANALOG_SPEED_LOWER),
    Command("]", "][value]", "Analog speed upper limit", Action.SET, Register.ANALOG_SPEED_UPPER),
    Command("^", "^[value]", "Number of outputs", Action.SET, Register.NUMBER_OF_OUTPUTS),
    Command("{", "{[value]", "Analog position lower limit", Action.SET, Register.ANALOG_POS_LOWER),
    Command("}", "}[value]", "Analog position upper limit", Action.SET, Register.ANALOG_POS_UPPER),
    Command("~", "~[value]", "Set address of PCL601", Action.SET_ADDRESS),
    Command("|", "|", "Switch to Modbus RTU", Action.TO_MODBUS),
)  # fmt: skip

BY_NAME: dict[str, Command] = {command.name: command for command in COMMANDS}

VERIFY: dict[str, Register] = {
    command.name: command.register
    for command in COMMANDS
    if command.register is not None and command.name != "P"
} | {"EP": Register.ENCODER_POSITION, "F": Register.BUSY, "+": Register.DIRECTION}
"""Registers that V reads, by command [Verify]; L, O, `:` and `;` are not registers, and V can't read P."""
