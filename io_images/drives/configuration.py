"""The words of configuration mode, and the rules that valid words must follow.

    word       SMD family                                ANF2
    0, 1       bits (`Settings`)                         bits of a 3601's configuration
    2, 3       starting speed, always thousands          starting speed, 32 bits
    4          motor steps per turn                      homing time-out, s
    5          0                                         0
    6          encoder counts per turn                   0
    7          idle current, %                           0
    8          motor current, 0.1 A                      0
    9          0                                         0

[EDS; SMD p. 59; word order: the client SMD_Control_Server; ANF2: the EPICS driver]
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ..amci3601.bits import InputBit
from ..amci3601.configuration import HomingKind
from ..dataclass import dataclass
from ..number_formats import NumberFormat
from .bits import InputFunction, Settings
from .models import WORDS, Layout, Model

RESERVED = 0b0001_0011_1100_0000
"""Unnamed bits of configuration word 0: 6 to 9, and 12 [EDS]."""

INDEXED = 1 << 6
"""The input that starts an indexed move, in masks of active inputs; not a bit of `InputBit`."""

ROLES: dict[InputFunction, int] = {
    InputFunction.GENERAL_PURPOSE: 0,
    InputFunction.CW_LIMIT: InputBit.CW_LIMIT.value,
    InputFunction.CCW_LIMIT: InputBit.CCW_LIMIT.value,
    InputFunction.START_INDEXED_MOVE: INDEXED,
    InputFunction.STOP_JOG: InputBit.EXTERNAL.value,
    InputFunction.CAPTURE_ENCODER: InputBit.CAPTURE.value,
    InputFunction.EMERGENCY_STOP: InputBit.ESTOP.value,
    InputFunction.HOME: InputBit.HOME.value,
}
"""The input of a 3601 with the same function, as a mask."""

ANF2_USED = (0b1, 0b10, 0b100, 0b1_1000, 0b110_0000)
"""Bits of an ANF2's configuration word 0 that use each input [EPICS driver]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Build:
    """The build of a drive: its encoder, and its interpretation of undocumented configuration bits.

    Attributes:
        encoder: whether it has an encoder.
        input_codes: the code of each `InputFunction` [reading R-01].
        low_word_first: whether Binary_Endian = 0 selects the low word first [reading R-02].
        save_bit: the bit of configuration word 1 that saves to flash [reading R-06].
        read_back_bit: the bit of configuration word 1 that requests the current configuration [reading R-06].
    """

    encoder: bool = True
    input_codes: tuple[int, ...] = (0, 1, 2, 3, 4, 5, 6, 7)
    low_word_first: bool = False
    save_bit: int = 14
    read_back_bit: int = 11

    def functions(self, words: Sequence[int]) -> tuple[InputFunction, InputFunction]:
        """Return the functions of both inputs, from configuration word 0."""
        first_code, second_code = (self.input_codes.index(words[0] >> shift & 7) for shift in (0, 3))
        return InputFunction(first_code), InputFunction(second_code)


USUAL = Build()


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveConfiguration:
    """A valid configuration.

    Attributes:
        words: the words as they were written, unsigned.
        roles: mask of the function of each input, see `ROLES`.
        active_high: whether each input is active when it is energized.
        stall_detection: whether a move stops if the motor shaft stalls.
        output_format: format of the numbers that the host writes.
        input_format: format of the numbers that the host reads.
        starting_speed: steps/s.
        counts_per_turn: x4 counts of the encoder.
        homing_timeout_s: longest home search of an ANF2, s; 0 = no limit.
        idle_percent: current at rest, % of `current`.
        current: motor current, 0.1 A.
    """

    words: tuple[int, ...]
    roles: tuple[int, ...]
    active_high: tuple[bool, ...]
    encoder_counted: bool = False
    backplane_proximity: bool = False
    stall_detection: bool = False
    output_format: NumberFormat = NumberFormat.THOUSANDS
    input_format: NumberFormat = NumberFormat.THOUSANDS
    starting_speed: int = 1
    steps_per_turn: int = 1
    homing_timeout_s: int = 0
    counts_per_turn: int = 0
    idle_percent: int = 0
    current: int = 0
    saves: bool = False

    @property
    def diagnostic_feedback(self) -> bool:
        """Whether the drive counts its own steps; always false, since no drive does this."""
        return False

    @property
    def homing(self) -> HomingKind:
        """The kind of homing of a 3601 with the same signals."""
        return HomingKind.HOME_SWITCH_PROXIMITY if self.backplane_proximity else HomingKind.HOME_SWITCH

    def active(self, levels: int) -> tuple[int, int]:
        """Return the active inputs by number, and by function (`ROLES`), as masks.

        Args:
            levels: electrical levels, bit n = input n + 1 energized.
        """
        input_numbers = functions = 0
        for index, (role, is_active_high) in enumerate(zip(self.roles, self.active_high, strict=True)):
            if bool(levels >> index & 1) == is_active_high:
                input_numbers |= 1 << index
                functions |= role
        return input_numbers, functions


@dataclass(frozen=True, slots=True)
class ConfigurationRule:
    """A row of the list of invalid configurations.

    Attributes:
        broken: returns whether unsigned words of configuration mode break the rule.
    """

    id: str
    section: str
    text: str
    broken: Callable[[Sequence[int], Model, Build], bool]
    reading: tuple[str, ...] = ()


def _repeats_function(words: Sequence[int], _model: Model, build: Build) -> bool:
    first_function, second_function = build.functions(words)
    return first_function is second_function and first_function is not InputFunction.GENERAL_PURPOSE


def _starting_speed(words: Sequence[int], model: Model) -> int | None:
    """Return the starting speed, steps/s; None if the words do not form a valid number."""
    format = NumberFormat.BINARY if model.layout is Layout.ANF2 else NumberFormat.THOUSANDS
    return format.join(words[2], words[3])


def _has_wrong_starting_speed(words: Sequence[int], model: Model, _build: Build) -> bool:
    start = _starting_speed(words, model)
    return start is None or not 1 <= start <= model.limits.starting_speed


def _stalls_without_encoder(words: Sequence[int], _model: Model, _build: Build) -> bool:
    return bool(words[0] & Settings.STALL_DETECTION) and not words[0] & Settings.USE_ENCODER


def _has_wrong_current(words: Sequence[int], model: Model, _build: Build) -> bool:
    return not model.limits.takes_current(words[8])


def _outside(value: int, limits: tuple[int, int]) -> bool:
    lowest, highest = limits
    return not lowest <= value <= highest


# One row per rule; the formatter would spread each over many lines.
# fmt: off
SMD_RULES: tuple[ConfigurationRule, ...] = (
    ConfigurationRule("CFG-01", "SD p. 55, Invalid Configurations 1; EDS",
        "A reserved bit of configuration word 0 is set.",
        lambda words, model, build: bool(words[0] & RESERVED), ("R-07",)),
    ConfigurationRule("CFG-02", "SD p. 55; EDS Param3",
        "The starting speed is outside its range, or its lower word exceeds 999.",
        _has_wrong_starting_speed, ("R-04", "R-07")),
    ConfigurationRule("CFG-03", "SD p. 55, Invalid Configurations 3", "Two inputs have one function.",
        _repeats_function, ("R-01", "R-07")),
    ConfigurationRule("CFG-04", "EDS Param4", "The motor steps per turn are outside their range.",
        lambda words, model, build: _outside(words[4], model.limits.steps_per_turn), ("R-07",)),
    ConfigurationRule("CFG-05", "SD p. 55, Invalid Configurations 5",
        "Stall detection is on without an encoder.",
        _stalls_without_encoder, ("R-07",)),
    ConfigurationRule("CFG-06", "SD p. 55", "The encoder is used on a unit without one.",
        lambda words, model, build: bool(words[0] & Settings.USE_ENCODER) and not build.encoder, ("R-07",)),
    ConfigurationRule("CFG-07", "EDS Param5", "The encoder counts per turn are outside their range.",
        lambda words, model, build: _outside(words[6], (0, model.limits.counts_per_turn)), ("R-07", "R-27")),
    ConfigurationRule("CFG-08", "EDS Param6", "The idle current is outside its range.",
        lambda words, model, build: _outside(words[7], (0, model.limits.idle_percent)), ("R-07",)),
    ConfigurationRule("CFG-09", "EDS Param7", "The motor current is outside its range.",
        _has_wrong_current, ("R-07",)),
    ConfigurationRule("CFG-10", "EDS Assem110", "Word 5 or word 9 is not 0.",
        lambda words, model, build: bool(words[5] or words[9]), ("R-05",)),
)
# fmt: on
"""Rules that a configuration of the SMD family must follow."""

ANF2_RULES: tuple[ConfigurationRule, ...] = (
    SMD_RULES[1],
    ConfigurationRule(
        "CFG-11",
        "ANF2 driver of EPICS",
        "The homing time-out exceeds 300 s.",
        lambda words, model, build: words[4] > model.limits.homing_timeout_s,
    ),
)

RULES: tuple[ConfigurationRule, ...] = (*SMD_RULES, *ANF2_RULES[1:])
"""All rows."""


def configuration_rules(model: Model) -> tuple[ConfigurationRule, ...]:
    """Return the rules for a model's configuration words."""
    return ANF2_RULES if model.layout is Layout.ANF2 else SMD_RULES


def broken_rules(words: Sequence[int], model: Model, build: Build = USUAL) -> list[ConfigurationRule]:
    """Return the rules that words of configuration mode break; a valid configuration breaks none.

    Args:
        words: ten unsigned words.
    """
    return [row for row in configuration_rules(model) if row.broken(words, model, build)]


def configuration_of(words: Sequence[int], model: Model, build: Build = USUAL) -> DriveConfiguration:
    """Return the configuration of valid words, see `broken_rules`.

    >>> from .models import SMD23E2
    >>> words = (0x8007, 0x0103, 1, 234, 2000, 0, 0, 20, 28, 0)
    >>> read = configuration_of(words, SMD23E2)
    >>> read.starting_speed, read.output_format.value, read.active(0b01)
    (1234, 'binary', (1, 4))
    """
    words = tuple(words)
    start = _starting_speed(words, model)
    assert start is not None
    if model.layout is Layout.ANF2:
        used_roles = [
            role.value if words[0] & bits else 0
            for role, bits in zip(model.terminals, ANF2_USED, strict=True)
        ]
        return DriveConfiguration(
            words=words,
            roles=tuple(used_roles),
            active_high=tuple(bool(words[1] >> index & 1) for index in range(len(used_roles))),
            encoder_counted=bool(words[0] & 0x0300),
            backplane_proximity=bool(words[0] & 0x0080),
            output_format=NumberFormat.BINARY,
            input_format=NumberFormat.BINARY,
            starting_speed=start,
            homing_timeout_s=words[4],
        )
    bits = Settings(words[0] | words[1] << 16)
    # the build decides which value of the bit means the low word first
    low_first = bool(bits & Settings.BINARY_ENDIAN) is not build.low_word_first
    binary = NumberFormat.BINARY_LOW if low_first else NumberFormat.BINARY
    return DriveConfiguration(
        words=words,
        roles=tuple(ROLES[function] for function in build.functions(words)),
        active_high=(bool(bits & Settings.INPUT_1_ACTIVE_HIGH), bool(bits & Settings.INPUT_2_ACTIVE_HIGH)),
        encoder_counted=bool(bits & Settings.USE_ENCODER),
        backplane_proximity=bool(bits & Settings.BACKPLANE_PROXIMITY),
        stall_detection=bool(bits & Settings.STALL_DETECTION),
        output_format=binary if bits & Settings.BINARY_OUTPUT_FORMAT else NumberFormat.THOUSANDS,
        input_format=binary if bits & Settings.BINARY_INPUT_FORMAT else NumberFormat.THOUSANDS,
        starting_speed=start,
        steps_per_turn=words[4],
        counts_per_turn=words[6],
        idle_percent=words[7],
        current=words[8],
        saves=bool(words[1] >> build.save_bit & 1),
    )


def stored_words(words: Sequence[int], build: Build = USUAL) -> tuple[int, ...]:
    """Return ten words as stored in flash: unsigned, without the request bits in word 1."""
    flash_words = [word & 0xFFFF for word in words[:WORDS]]
    flash_words[1] &= ~(1 << build.save_bit | 1 << build.read_back_bit)
    return tuple(flash_words)
