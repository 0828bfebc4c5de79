"""The models of the family: a row for each, with its words, bits, ranges and functions.

Models differ only in their rows. Sources of the rows: SMD and EDS for the SMD models; the manuals of the
SD17060E2 (p. 42, 59, 83) and of its EtherCAT version; for ANG1 and ANF2, the registers that the EPICS drivers
use, since only the title pages of their manuals are available.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import field, replace
from enum import Enum, IntFlag

from ..amci3601.bits import InputBit
from ..dataclass import dataclass
from ..module_words import BitPlace, Modes, ModuleWords, Quantity
from ..number_formats import NumberFormat
from .bits import CommandBit, Modifier, StatusBit

WORDS = 10
"""Words of an axis in each direction [SMD p. 59]."""


class Layout(Enum):
    """Layouts of the words of configuration mode."""

    SMD = "two words of bits, starting speed, steps, 0, counts, idle current, current, 0"
    ANF2 = "two words of bits, starting speed, homing time-out, zeros"


@dataclass(frozen=True, slots=True)
class DriveLimits:
    """Ranges of parameters."""

    speed: int = 2_999_999  # steps/s, from the starting speed [SD p. 55; EDS]
    starting_speed: int = 1_999_999  # steps/s, from 1 [EDS; reading R-07]
    rate: int = 5_000  # steps/ms/s, from 1 [EDS; SD p. 55]
    jerk: int = 5_000  # from 0 [SMD p. 46]
    current: tuple[int, int] = (10, 34)  # lowest and highest, 0.1 A [EDS]
    current_step: int = 1  # 0.1 A
    steps_per_turn: tuple[int, int] = (200, 32_767)  # lowest and highest [EDS]
    counts_per_turn: int = 4_096  # x4 counts, from 0 [EDS; reading R-27]
    idle_percent: int = 100  # from 0 [EDS]
    homing_timeout_s: int = 300  # ANF2 only

    def takes_current(self, current: int) -> bool:
        """Return whether a motor current is legal, 0.1 A."""
        lowest, highest = self.current
        return lowest <= current <= highest and current % self.current_step == 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Model:
    """A model of the family.

    Attributes:
        name: its name in rack files and commands.
        title: the vendor's name.
        layout: the layout of the configuration words.
        axes: maximum axes in a stack.
        limits: ranges of its parameters.
        terminals: the inputs with fixed functions, in order; () if the configuration selects the functions
            of two inputs.
        moved_commands: bits of command word 0 that are in a different place than in the SMD family; 0 for a
            bit that it lacks, so that it refuses the command.
        modifiers: bits of command word 1 that it has; it refuses a command with any other bit.
        moved_status: status bits that are in a different place than in the SMD family; 0 for a bit that it
            lacks.
        number_format: the fixed format of its numbers; None if the configuration selects it.
        current_keys: bits of command word 1 that must be on, and bits that must be off, for word 8 to be the
            motor current.
        enable_bit: whether the driver needs its enable bit in every command.
        jerk: whether word 9 is the jerk of a move.
        flash: whether it keeps its configuration through a power loss.
        leaves_configuration: whether it returns to command mode by itself after a valid configuration.
        identity: vendor, device type, product code and revision of its EtherNet/IP identity, if known.
    """

    name: str
    title: str
    layout: Layout = Layout.SMD
    axes: int = 1
    limits: DriveLimits = field(default_factory=DriveLimits)
    terminals: tuple[InputBit, ...] = ()
    moved_commands: Mapping[CommandBit, int] = field(default_factory=dict)
    modifiers: Modifier = (
        Modifier.MOTOR_CURRENT
        | Modifier.ENCODER_MOVE
        | Modifier.REVERSE_BLEND
        | Modifier.SAVE_TO_FLASH
        | Modifier.REGISTRATION_MOVE
        | Modifier.INDEXED_COMMAND
        | Modifier.DWELL_MOVE
        | Modifier.BACKPLANE_PROXIMITY
        | Modifier.ENCODER_TO_POSITION
        | Modifier.ENABLE_DRIVER
    )
    moved_status: Mapping[StatusBit, int] = field(default_factory=dict)
    number_format: NumberFormat | None = None
    current_keys: tuple[int, int] = (Modifier.MOTOR_CURRENT.value, 0)
    enable_bit: bool = True
    jerk: bool = True
    flash: bool = True
    leaves_configuration: bool = False
    identity: tuple[int, int, int, int, int] | None = None
    words: ModuleWords = field(init=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "words", _words_of(self))

    @property
    def input_names(self) -> tuple[str, ...]:
        """Names of its inputs, in the order of `terminals`."""
        if self.layout is Layout.SMD:
            return ("in1", "in2")
        return tuple(str(bit.name).lower() for bit in self.terminals)

    @property
    def runs_blends(self) -> bool:
        """Whether the model has blend move commands."""
        return self.moved_commands.get(CommandBit.RUN_ASSEMBLED_MOVE) != 0

    def command_bits(self, word_0: int) -> CommandBit:
        """Return the commands of command word 0, at the places of the SMD family."""
        if not self.moved_commands:
            return CommandBit(word_0 & 0xFFFF)
        commands = CommandBit(0)
        for bit in CommandBit:
            if word_0 & self.moved_commands.get(bit, bit.value):
                commands |= bit
        return commands

    def unknown_commands(self, word_0: int) -> int:
        """Return the bits of command word 0 that do not belong to any command."""
        known_bits = sum(self.moved_commands.get(bit, bit.value) for bit in CommandBit)
        return word_0 & 0xFFFF & ~known_bits

    def status_words(self, status: int) -> tuple[int, int]:
        """Return the two status words for status bits that are at the places of the SMD family."""
        moved = 0
        for bit, mask in self.moved_status.items():
            if status & bit:
                status &= ~bit.value
                moved |= mask
        status |= moved
        return status & 0xFFFF, status >> 16


_OUTPUTS = (
    "command_0",
    "command_1",
    "target_upper",
    "target_lower",
    "speed_upper",
    "speed_lower",
    "acceleration",
    "deceleration",
    "motor_current",
    "jerk",
)
_INPUTS = (
    "status_0",
    "status_1",
    "position_upper",
    "position_lower",
    "encoder_upper",
    "encoder_lower",
    "captured_upper",
    "captured_lower",
    "motor_current",
    "jerk",
)
_QUANTITIES = (
    Quantity("position", "I", 2, unit="steps", counts=True),
    Quantity("encoder", "I", 4, unit="counts", counts=True),
    Quantity("captured", "I", 6, unit="steps"),
    Quantity("target", "O", 2, unit="steps"),
    Quantity("programmed_speed", "O", 4, unit="steps/s"),
    Quantity("acceleration", "O", 6, 1, "steps/ms/s"),
    Quantity("deceleration", "O", 7, 1, "steps/ms/s"),
    Quantity("motor_current", "O", 8, 1, "0.1 A"),
    Quantity("jerk", "O", 9, 1, "%/s"),
)
"""The numbers in words 2 to 9 in command mode [EDS; SMD p. 59]."""

_ERRORS = (
    "INPUT_ERROR",
    "COMMAND_ERROR",
    "CONFIG_ERROR",
    "DRIVER_FAULT",
    "CONNECTION_LOST",
    "STALL_DETECTED",
)


def _places(image: str, masks: Iterable[tuple[IntFlag, int]]) -> dict[str, BitPlace]:
    """Return the places of bits by name, from masks of two words; the second word begins at bit 16."""
    return {str(bit.name): BitPlace(image, *divmod(mask.bit_length() - 1, 16)) for bit, mask in masks if mask}


def _words_of(model: Model) -> ModuleWords:
    """Return the words of a model, with each of its bits at the model's place."""
    groups = {
        "status": _places("I", ((bit, model.moved_status.get(bit, bit.value)) for bit in StatusBit)),
        "command": _places("O", ((bit, model.moved_commands.get(bit, bit.value)) for bit in CommandBit)),
        "modifier": _places("O", ((bit, bit.value << 16) for bit in Modifier if bit in model.modifiers)),
    }
    errors = tuple(name for name in _ERRORS if name in groups["status"])
    quantities = tuple(replace(quantity, format=model.number_format) for quantity in _QUANTITIES)
    return ModuleWords(
        model.name.capitalize(),
        _OUTPUTS,
        _INPUTS,
        groups,
        errors=errors,
        quantities=quantities if model.jerk else quantities[:-2],  # motor current and jerk are last
        modes=Modes(StatusBit.MODE_CONFIG.value),
    )


SMD23E2 = Model(name="smd23e2", title="SMD23E2", identity=(10, 12, 29, 1, 6))
SMD24E2 = Model(name="smd24e2", title="SMD24E2")
SD17060E2 = Model(
    name="sd17060e2",
    title="SD17060E2",
    limits=DriveLimits(current=(10, 60), current_step=2),  # even values [SD p. 55]
    modifiers=SMD23E2.modifiers | Modifier(0b1),  # bit 0 is a key
    current_keys=(0b100001, 0b10),  # 5 = 1, 1 = 0, 0 = 1 [SD p. 58]
)
ANG1 = Model(name="ang1", title="ANG1", axes=6, limits=DriveLimits(current=(10, 40)))
ANF2 = Model(
    name="anf2",
    title="ANF2",
    layout=Layout.ANF2,
    axes=12,
    limits=DriveLimits(speed=1_000_000, starting_speed=1_000_000, rate=2_000),
    terminals=(InputBit.CAPTURE, InputBit.EXTERNAL, InputBit.HOME, InputBit.CW_LIMIT, InputBit.CCW_LIMIT),
    moved_commands={
        CommandBit.PRESET_ENCODER: 1 << 10,
        CommandBit.RESET_ERRORS: 1 << 11,
        CommandBit.PROGRAM_ASSEMBLED: 0,
        CommandBit.READ_ASSEMBLED_DATA: 0,
        CommandBit.RUN_ASSEMBLED_MOVE: 0,
    },
    modifiers=Modifier(0),
    moved_status={
        StatusBit.INPUT_1: 1 << 19,  # CW limit
        StatusBit.INPUT_2: 1 << 20,  # CCW limit
        StatusBit.ASSEMBLED_MODE: 0,
        StatusBit.WAITING_FOR_SEGMENT: 0,
        StatusBit.TEMPERATURE_90C: 0,
        StatusBit.PLC_IN_PROGRAM_MODE: 0,
        StatusBit.CONNECTION_LOST: 0,
        StatusBit.DRIVER_FAULT: 0,
        StatusBit.INVALID_JOG_CHANGE: 0,
        StatusBit.LIMIT_CONDITION: 0,
        StatusBit.HEARTBEAT: 0,
        StatusBit.ENCODER_ERROR: 0,
        StatusBit.ACKNOWLEDGE: 0,
        StatusBit.STALL_DETECTED: 0,
        StatusBit.DRIVE_ENABLED: 0,
    },
    number_format=NumberFormat.BINARY,
    enable_bit=False,
    jerk=False,
    flash=False,
    leaves_configuration=True,
)

MODELS: Mapping[str, Model] = {model.name: model for model in (SMD23E2, SMD24E2, SD17060E2, ANG1, ANF2)}
"""The models by name."""
