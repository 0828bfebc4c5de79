"""Options of a simulated drive: interpretations that a real unit may contradict, and its hardware."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field, field_validator
from scanrack.io_images.amci3601 import InputBit
from scanrack.io_images.drives.configuration import USUAL, Build, broken_rules
from scanrack.io_images.drives.models import WORDS, Layout, Model
from typing_extensions import override

from ...loop.module_options import Options

_InputName = Literal["capture", "external", "home", "estop", "cw_limit", "ccw_limit"]
_Bit = Annotated[int, Field(ge=0, le=15)]


class DriveOptions(Options):
    """Options of all models, by the names used in rack files and by `scanrack drive`.

    Attributes:
        encoder_fitted: the unit has an encoder.
        hold_at_rest_refused: Hold without a motion is a command error; otherwise it has no effect (R-15).
        jog_stops_on_bad_values: invalid new values end a jog (R-16).
        timeout_stops: a time-out of the controlling connection cuts the motion (R-22).
        error_locks_stop: Immediate Stop is refused while COMMAND_ERROR is set (R-24).
        input_scan_us: sampling period of the inputs, µs, 50 to 250,000 (R-41).
    """

    owner: ClassVar[str] = "simulated drive"
    home_reversal_dwell_ms: ClassVar[int] = 0
    """Pause at each reversal of a home search; a drive has none, like a 3601 (R-19)."""

    encoder_fitted: bool = True
    hold_at_rest_refused: bool = True
    jog_stops_on_bad_values: bool = False
    timeout_stops: bool = True
    error_locks_stop: bool = False
    input_scan_us: Annotated[int, Field(ge=50, le=250_000)] = 250

    @property
    def build(self) -> Build:
        """The unit's interpretation of its configuration words."""
        return Build(encoder=self.encoder_fitted)

    @property
    def beat_ms(self) -> int:
        """Time between changes of the heartbeat, ms."""
        return 500

    @property
    def stall_angle(self) -> int:
        """Lag of the shaft, in degrees, at which a stall is detected."""
        return 45

    def terminals(self, model: Model) -> tuple[InputBit, ...]:
        """Return the machine's inputs that are wired to the drive's inputs, in order."""
        return model.terminals

    def stored_in(self, model: Model) -> tuple[int, ...] | None:
        """Return the configuration in the flash at power-up, or None.

        Raises:
            ValueError: the configuration is invalid.
        """
        return None


class SmdOptions(DriveOptions):
    """Options of the SMD family.

    Attributes:
        in1: the machine's input that is wired to input 1; the drive's configuration selects its function.
        in2: the machine's input that is wired to input 2.
        stored: ten configuration words in the flash at power-up; empty for an empty flash.
        input_codes: codes 0 to 7 of the input functions general purpose, CW limit, CCW limit, start indexed
            move, stop jog, capture encoder, emergency stop, home (R-01).
        low_word_first: with Binary_Endian = 0, the low word comes first (R-02).
        save_bit: bit of configuration word 1 that saves to flash (R-06).
        read_back_bit: bit of configuration word 1 that requests read-back (R-06).
        heartbeat_ms: time between changes of the heartbeat, 1 or more (R-11).
        stall_degrees: lag of the shaft, in degrees, at which a stall is detected, 1 to 360 (R-42).
    """

    in1: _InputName = "home"
    in2: _InputName = "cw_limit"
    stored: Annotated[tuple[int, ...], Field(strict=False)] = ()
    input_codes: Annotated[tuple[int, ...], Field(strict=False)] = USUAL.input_codes
    low_word_first: bool = USUAL.low_word_first
    save_bit: _Bit = USUAL.save_bit
    read_back_bit: _Bit = USUAL.read_back_bit
    heartbeat_ms: Annotated[int, Field(ge=1)] = 500
    stall_degrees: Annotated[int, Field(ge=1, le=360)] = 45

    @field_validator("input_codes")
    @classmethod
    def _are_a_permutation(cls, codes: tuple[int, ...]) -> tuple[int, ...]:
        if sorted(codes) != list(range(8)):
            raise ValueError(f"{list(codes)} is not allowed: must contain 0 to 7, each once")
        return codes

    @field_validator("stored")
    @classmethod
    def _are_words(cls, words: tuple[int, ...]) -> tuple[int, ...]:
        if words and (len(words) != WORDS or not all(0 <= word <= 0xFFFF for word in words)):
            raise ValueError(f"{list(words)} is not allowed: must be empty or {WORDS} words of 0 to 65535")
        return words

    @property
    @override
    def build(self) -> Build:
        return Build(
            encoder=self.encoder_fitted,
            input_codes=self.input_codes,
            low_word_first=self.low_word_first,
            save_bit=self.save_bit,
            read_back_bit=self.read_back_bit,
        )

    @property
    @override
    def beat_ms(self) -> int:
        return self.heartbeat_ms

    @property
    @override
    def stall_angle(self) -> int:
        return self.stall_degrees

    @override
    def terminals(self, model: Model) -> tuple[InputBit, ...]:
        return InputBit[self.in1.upper()], InputBit[self.in2.upper()]

    @override
    def stored_in(self, model: Model) -> tuple[int, ...] | None:
        rules = broken_rules(self.stored, model, self.build) if self.stored else []
        if rules:
            raise ValueError(f"option stored: {rules[0].text} [{rules[0].id}, {rules[0].section}]")
        return self.stored or None


def options_of(model: Model) -> type[DriveOptions]:
    """Return the option class of a model."""
    return DriveOptions if model.layout is Layout.ANF2 else SmdOptions
