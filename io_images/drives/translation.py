"""Translates a 3601's words, which axes and motion blocks write, to a drive's words, and back.

An axis uses the commands and status bits of a 3601. A table has a row for each bit with the same meaning on a
drive; the methods translate everything else.

    to the drive     commands, blend handshake, format of numbers, S-curve as a jerk, enable bit
    from the drive   status bits, number format, configuration mode, blend handshake

The blocks of `USE axis3601` translate in rungs, see `ladder/files/drive_blocks.py`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeVar

from ..amci3601.bits import CommandLsw, CommandMsw, StatusLsw, StatusMsw
from ..amci3601.blend import PROGRAM_AND_TRANSMIT
from ..amci3601.parameters import Limits
from ..image import signed_word
from ..module_words import ModuleWords
from ..number_formats import NumberFormat
from ..thousands import split_reported
from .bits import CommandBit, InputFunction, Modifier, StatusBit
from .configuration import USUAL, configuration_of
from .models import MODELS, Layout, Model

Bit = TypeVar("Bit", CommandBit, StatusBit)

HEADER = -1
"""Word 7 of a blend profile's first block; word 7 of a segment's block is the deceleration."""

COMMANDS: Mapping[int, CommandBit] = {
    CommandMsw.ABSOLUTE_MOVE: CommandBit.ABSOLUTE_MOVE,
    CommandMsw.RELATIVE_MOVE: CommandBit.RELATIVE_MOVE,
    CommandMsw.HOLD_MOVE: CommandBit.HOLD_MOVE,
    CommandMsw.IMMEDIATE_STOP: CommandBit.IMMEDIATE_STOP,
    CommandMsw.FIND_HOME_CW: CommandBit.FIND_HOME_CW,
    CommandMsw.FIND_HOME_CCW: CommandBit.FIND_HOME_CCW,
    CommandMsw.MANUAL_CW: CommandBit.JOG_CW,
    CommandMsw.MANUAL_CCW: CommandBit.JOG_CCW,
    CommandMsw.PRESET_POSITION: CommandBit.PRESET_POSITION,
    CommandMsw.RESET_ERRORS: CommandBit.RESET_ERRORS,
    CommandMsw.RUN_BLEND_CW: CommandBit.RUN_ASSEMBLED_MOVE,
    CommandMsw.RUN_BLEND_CCW: CommandBit.RUN_ASSEMBLED_MOVE,
}
"""Command bits of the drive, by bit of a 3601's command word 0."""

STATUS: Mapping[int, StatusBit] = {
    StatusMsw.MOVING_CW: StatusBit.MOVING_CW,
    StatusMsw.MOVING_CCW: StatusBit.MOVING_CCW,
    StatusMsw.HOLD_STATE: StatusBit.HOLD_STATE,
    StatusMsw.STOPPED: StatusBit.STOPPED,
    StatusMsw.AT_HOME: StatusBit.AT_HOME,
    StatusMsw.ACCELERATING: StatusBit.ACCELERATING,
    StatusMsw.DECELERATING: StatusBit.DECELERATING,
    StatusMsw.MOVE_COMPLETE: StatusBit.MOVE_COMPLETE,
    StatusMsw.INVALID_PROFILE: StatusBit.INVALID_JOG_CHANGE,
    StatusMsw.POSITION_INVALID: StatusBit.POSITION_INVALID,
    StatusMsw.INPUT_ERROR: StatusBit.INPUT_ERROR,
    StatusMsw.COMMAND_ERROR: StatusBit.COMMAND_ERROR,
    StatusMsw.CONFIG_ERROR: StatusBit.CONFIG_ERROR,
    StatusMsw.MODULE_OK: StatusBit.MODULE_OK,
}
"""Status bits of the drive, by bit of a 3601's status word 0."""

UNFIT = StatusBit.DRIVER_FAULT | StatusBit.STALL_DETECTED
"""Status bits that end a command but do not exist on a 3601."""

PARTS = {CommandLsw.S_CURVE.value: 1, (CommandLsw.S_CURVE | CommandLsw.TRAPEZOIDAL).value: 3}
"""For each shape: the duration of a speed change at peak rate, divided by the rise time of the rate."""

JERK_SCALE = 100_000
"""A jerk of 1 % per second reaches the peak rate in 100 s; a rate of 1 step/ms/s is 1,000 steps/s/s."""

_SHAPE = (CommandLsw.S_CURVE | CommandLsw.TRAPEZOIDAL).value
_JOGS = (CommandMsw.MANUAL_CW | CommandMsw.MANUAL_CCW).value
_CONFIGURING = signed_word((StatusMsw.MODE_CONFIG | StatusMsw.MODULE_OK).value)


def model_of(words: ModuleWords) -> Model | None:
    """Return the drive model whose words a slot has; None for any other module.

    >>> from .models import ANF2
    >>> model_of(ANF2.words).title
    'ANF2'
    """
    return next((model for model in MODELS.values() if model.words == words), None)


class DriveTranslation:
    """The translation for one axis.

    Attributes:
        configuration: the ten words that `configure` sends, unsigned.
        unfit: whether the last status had a stall or a driver fault.
        enabled: whether the driver was enabled in the last status.

    Args:
        model: model of the drive.
        configuration: ten words that are valid for the model.
    """

    def __init__(self, model: Model, configuration: Sequence[int]) -> None:
        self.model = model
        self.limits = Limits(model.limits.speed, model.limits.rate)
        self.configuration = tuple(word & 0xFFFF for word in configuration)
        self._configuration = configuration_of(self.configuration, model)
        self._commands = _places(COMMANDS, model.moved_commands)
        self._statuses = _places(STATUS, model.moved_status)
        functions = USUAL.functions(self.configuration) if model.layout is Layout.SMD else ()
        # the inputs that capture, as a mask of status word 1
        self._capture = sum(
            1 << index for index, use in enumerate(functions) if use is InputFunction.CAPTURE_ENCODER
        )
        self.reset()

    def reset(self) -> None:
        """Forget the last words and the stored minimum distance."""
        self._minimum_distance = 0  # of registration moves, steps
        self._words: Sequence[int] = (0,) * 8  # the last output words, of a 3601
        self.unfit, self.enabled = False, True

    # -- from the drive

    @property
    def starting_speed(self) -> int:
        """Starting speed of the configuration, steps/s."""
        return self._configuration.starting_speed

    def number(self, inputs: Sequence[int], first: int) -> int:
        """Return the number in input words `first` and `first + 1`."""
        return self._configuration.input_format.join(inputs[first], inputs[first + 1]) or 0

    def status(self, inputs: Sequence[int]) -> list[int]:
        """Translate the drive's ten input words to a 3601's eight, signed; set `unfit` and `enabled`."""
        word0, word1 = inputs[0] & 0xFFFF, inputs[1] & 0xFFFF
        sends_configuration = self._words[0] < 0
        if word0 & StatusBit.MODE_CONFIG or (self.model.leaves_configuration and sends_configuration):
            return [_CONFIGURING, *(0,) * 7]
        bits = word0 | word1 << 16
        self.unfit = bool(bits & UNFIT) and self.model.layout is Layout.SMD
        self.enabled = not self.model.enable_bit or bool(bits & StatusBit.DRIVE_ENABLED)
        msw = sum(bit for bit, drive_bit in self._statuses if bits & drive_bit)
        lsw = StatusLsw.IN_CAPTURE.value if word1 & self._capture else 0
        if self._acknowledges(bits):
            lsw |= StatusLsw.BLEND_ACK.value
        if self._configuration.input_format is NumberFormat.THOUSANDS:
            return [msw, lsw, *inputs[2:8]]
        position, encoder, captured = (self.number(inputs, first) for first in (2, 4, 6))
        return [msw, lsw, *split_reported(position), *split_reported(encoder), *split_reported(captured)]

    def status_names(self, inputs: Sequence[int]) -> list[str]:
        """Return the names of the status bits that are on."""
        names = self.model.words.groups["status"]
        return [name for name, place in names.items() if inputs[place.word] >> place.bit & 1]

    def _acknowledges(self, bits: int) -> bool:
        """Return the BLEND_ACK bit: whether the drive has accepted the current block of a blend profile."""
        if not bits & StatusBit.ASSEMBLED_MODE or self.model.layout is not Layout.SMD:
            return False
        waits = bool(bits & StatusBit.WAITING_FOR_SEGMENT)
        if self._words[7] == HEADER:
            return waits and self._words[1] == PROGRAM_AND_TRANSMIT
        return not waits

    # -- to the drive

    def command(self, words: Sequence[int]) -> list[int]:
        """Translate a 3601's eight output words to the drive's ten, signed.

        The words and a stored minimum distance are remembered for later translations.
        """
        self._words = words
        if words[0] < 0:
            return [signed_word(word) for word in self.configuration]
        target = 1000 * words[2] + words[3]
        if words[1] & CommandLsw.STORE_MIN_REG:
            self._minimum_distance = target
        is_registration = bool(words[0] & _JOGS and target)
        split_number = self._configuration.output_format.split
        outputs = [
            signed_word(sum({drive_bit for bit, drive_bit in self._commands if words[0] & bit})),
            0,
            *split_number(target),
            *split_number(1000 * words[4] + words[5]),
            *words[6:8],
            *(split_number(self._minimum_distance) if is_registration else (0, self._jerk(words))),
        ]
        if self.model.layout is Layout.SMD:
            outputs[0] |= self._programming(words)
            outputs[1] = signed_word(self._modifiers(words, is_registration))
        return outputs

    @staticmethod
    def _programming(words: Sequence[int]) -> int:
        """Return the bits of word 0 for a block of a blend profile."""
        if not words[1] & CommandLsw.BLEND_PROGRAM:
            return 0
        sends = words[1] & CommandLsw.BLEND_TRANSMIT and words[7] != HEADER
        return (CommandBit.PROGRAM_ASSEMBLED | CommandBit.READ_ASSEMBLED_DATA * bool(sends)).value

    @staticmethod
    def _modifiers(words: Sequence[int], is_registration: bool) -> int:
        """Return the bits of command word 1, which change how the drive runs the command in word 0."""
        modifiers = Modifier.ENABLE_DRIVER
        if is_registration:
            modifiers |= Modifier.REGISTRATION_MOVE
        if words[0] & CommandMsw.RUN_BLEND_CCW:
            modifiers |= Modifier.REVERSE_BLEND
        if words[1] & CommandLsw.HOME_PROXIMITY:
            modifiers |= Modifier.BACKPLANE_PROXIMITY
        return modifiers.value

    def _jerk(self, words: Sequence[int]) -> int:
        """Return the jerk of an S-curve, rounded down but at least 1; 0 without an S-curve."""
        shape_parts = PARTS.get(words[1] & _SHAPE, 0)
        change = 1000 * words[4] + words[5] - self._configuration.starting_speed
        if not shape_parts or change <= 0:
            return 0
        jerk = JERK_SCALE * shape_parts * min(words[6], words[7]) // change
        return max(1, min(self.model.limits.jerk, jerk))


def _places(rows: Mapping[int, Bit], moved: Mapping[Bit, int]) -> tuple[tuple[int, int], ...]:
    """Return each bit of a 3601 with the model's bit; a bit that the model lacks is 0."""
    return tuple((int(bit), int(moved.get(drive_bit, drive_bit))) for bit, drive_bit in rows.items())
