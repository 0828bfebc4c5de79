"""The 3601's configuration: the eight output words in configuration mode and their rules.

    word  meaning                        legal values
    0     configuration bits MSW         `ConfigMsw`; bits 7, 11, 13, 14 are 0
    1     active level of inputs 0 to 5  1 active high (normally open); bits 6 to 15 are 0
    2, 3  starting speed in thousands    1 to 1,000,000 steps/s, LSW 0 to 999
    4..7  unused                         0

Four combinations of home switch, backplane proximity and marker can home the axis [chapter 3, item 10]:

    home switch  backplane proximity  marker  kind
    1            0                    0       HOME_SWITCH
    1            1                    0       HOME_SWITCH_PROXIMITY
    1            0                    1       MARKER_HOME_SWITCH
    0            1                    1       MARKER_PROXIMITY
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import field
from enum import Enum

from ..dataclass import dataclass
from ..image import Image
from ..thousands import join_thousands, split_thousands
from .bits import ALL_INPUTS, ConfigMsw, InputBit
from .firmware import FW_4_1, Firmware
from .parameters import LIMITS_3601, Limits, require
from .rules import RULES

_CAPTURE = ConfigMsw.USE_CAPTURE.value
_HOME = ConfigMsw.USE_HOME.value
_LIMITS = (ConfigMsw.USE_CW_LIMIT | ConfigMsw.USE_CCW_LIMIT).value
_PROXIMITY = ConfigMsw.BACKPLANE_PROXIMITY.value
_ENCODER = ConfigMsw.QUADRATURE_ENCODER.value
_FEEDBACK = ConfigMsw.DIAGNOSTIC_FEEDBACK.value
_STEP_AND_DIRECTION = ConfigMsw.STEP_AND_DIRECTION.value
_MARKER = ConfigMsw.MARKER_HOME.value
_MODE = ConfigMsw.MODE_CONFIG.value
_UNUSED_MSW = 1 << 7 | 1 << 11 | 1 << 13 | 1 << 14
_UNUSED_LSW = 0xFFC0


class HomingKind(Enum):
    """Homing signals: (home switch, backplane proximity, marker) [chapter 3, item 10]."""

    HOME_SWITCH = (True, False, False)
    HOME_SWITCH_PROXIMITY = (True, True, False)
    MARKER_HOME_SWITCH = (True, False, True)
    MARKER_PROXIMITY = (False, True, True)


@dataclass(frozen=True, slots=True, kw_only=True)
class Configuration:
    """A legal configuration of the 3601.

    >>> configuration = Configuration(inputs_used=0x3E, step_and_direction=True, starting_speed=1000)
    >>> [f"{word & 0xFFFF:04X}h" for word in configuration.to_image()][:4]
    ['843Eh', '003Fh', '0001h', '0000h']
    >>> Configuration.from_image(configuration.to_image()) == configuration
    True

    Attributes:
        inputs_used: mask of `InputBit`, the evaluated inputs.
        active_high: mask of `InputBit`, the inputs that are active when energized. Bits of
            unused inputs are legal, but have no effect (reading A-14).
        backplane_proximity: command LSW bit 12 acts as home proximity.
        quadrature_encoder: a quadrature encoder is used; required for marker homing.
        diagnostic_feedback: the module counts its own pulses; not allowed together with the encoder.
        step_and_direction: pulse and direction outputs instead of CW and CCW pulses.
        marker_home: the encoder's marker pulse is home.
        starting_speed: 1 to 1,000,000 steps/s; every move begins and ends at this speed.
        limits: limits of the module.

    Raises:
        ValueError: a mask is out of range, or the configuration breaks a chapter 3 rule for the newest
            firmware.
    """

    inputs_used: int
    active_high: int = ALL_INPUTS
    backplane_proximity: bool = False
    quadrature_encoder: bool = False
    diagnostic_feedback: bool = False
    step_and_direction: bool = False
    marker_home: bool = False
    starting_speed: int
    limits: Limits = field(default=LIMITS_3601, compare=False, repr=False)

    def __post_init__(self) -> None:
        for name, mask in (("inputs_used", self.inputs_used), ("active_high", self.active_high)):
            require(name, mask, 0, ALL_INPUTS)
        require("starting_speed", self.starting_speed, 1, self.limits.speed)
        _refuse(check(self._words(), FW_4_1, self.limits), "configuration")

    def _words(self) -> tuple[int, ...]:
        """Return the eight output words; word 0 is unsigned, with the mode flag in bit 15."""
        msw = (
            _MODE
            | self.inputs_used
            | self.backplane_proximity * _PROXIMITY
            | self.quadrature_encoder * _ENCODER
            | self.diagnostic_feedback * _FEEDBACK
            | self.step_and_direction * _STEP_AND_DIRECTION
            | self.marker_home * _MARKER
        )
        return (msw, self.active_high, *split_thousands(self.starting_speed), 0, 0, 0, 0)

    def to_image(self) -> Image:
        """Return the output image that sends this configuration; bit 15 of word 0 is set."""
        return Image(self._words())

    @classmethod
    def from_image(
        cls, image: Image, firmware: Firmware = FW_4_1, limits: Limits = LIMITS_3601
    ) -> Configuration:
        """Read an output image in configuration mode; raise a ValueError if it breaks any rule."""
        words = image.words.tolist()
        if not words[0] & _MODE:
            raise ValueError(f"word 0 is {words[0] & 0xFFFF:04X}h: a configuration has bit 15 set")
        subject = f"configuration {words[0] & 0xFFFF:04X}h/{words[1] & 0xFFFF:04X}h"
        _refuse(check(words, firmware, limits), subject)
        return cls(
            inputs_used=words[0] & ALL_INPUTS,
            active_high=words[1],
            backplane_proximity=bool(words[0] & _PROXIMITY),
            quadrature_encoder=bool(words[0] & _ENCODER),
            diagnostic_feedback=bool(words[0] & _FEEDBACK),
            step_and_direction=bool(words[0] & _STEP_AND_DIRECTION),
            marker_home=bool(words[0] & _MARKER),
            starting_speed=join_thousands(words[2], words[3]),
            limits=limits,
        )

    @property
    def homing(self) -> HomingKind:
        """The homing signals of this configuration."""
        home_switch = bool(self.inputs_used & InputBit.HOME.value)
        return HomingKind((home_switch, self.backplane_proximity, self.marker_home))

    @property
    def encoder_counted(self) -> bool:
        """Whether words 4 and 5 have a count of the encoder or the module's own pulses (reading A-89)."""
        return self.quadrature_encoder or self.diagnostic_feedback

    def active_inputs(self, energized: int) -> int:
        """Return the mask of used inputs that are active, given the mask of energized inputs."""
        return ~(energized ^ self.active_high) & self.inputs_used


def check(words: Sequence[int], firmware: Firmware, limits: Limits = LIMITS_3601) -> tuple[str, ...]:
    """Return the ids of the rules that a configuration breaks; () if it is valid.

    Bit 15 of word 0, the mode flag, is ignored. Words can be signed or unsigned.

    >>> check((0x843E, 0x003F, 1, 0, 0, 0, 0, 0), Firmware(4, 1))
    ()
    >>> check((0x8020, 0x0000, 0, 1000, 0, 0, 0, 0), Firmware(4, 1))
    ('CFG-01', 'CFG-07')
    """
    return tuple(rule for rule, is_broken in INVALID_CONFIGURATIONS if is_broken(words, firmware, limits))


INVALID_CONFIGURATIONS: tuple[tuple[str, Callable[[Sequence[int], Firmware, Limits], bool]], ...] = (
    # Backplane proximity needs a home switch or marker (reading A-12).
    ("CFG-01", lambda w, *_: not w[0] & (_HOME | _MARKER)),
    ("CFG-02", lambda w, *_: not w[0] & _LIMITS),
    ("CFG-03", lambda w, *_: _all(w[0], _ENCODER | _FEEDBACK)),
    ("CFG-04", lambda w, *_: _all(w[0], _MARKER) and not w[0] & _ENCODER),
    ("CFG-05", lambda w, *_: _all(w[0], _FEEDBACK) and not w[0] & _STEP_AND_DIRECTION),
    ("CFG-06", lambda w, _, limits: not limits.takes_speed(1000 * w[2] + w[3])),
    ("CFG-07", lambda w, *_: not 0 <= w[3] <= 999),
    ("CFG-08", lambda w, *_: bool(w[0] & _UNUSED_MSW or w[1] & _UNUSED_LSW)),
    ("CFG-09", lambda w, *_: _all(w[0], _MARKER) and not w[0] & (_HOME | _PROXIMITY)),
    ("CFG-10", lambda w, *_: _all(w[0], _MARKER | _HOME | _PROXIMITY)),
    ("CFG-11", lambda w, *_: any(w[4:8])),
    ("CFG-29", lambda w, fw, _: _capture_alone(w[0]) and not fw.capture_without_encoder),
)
"""Rule ids with functions that return whether words break the rule [chapter 3, Invalid Configurations]."""


def _all(word: int, mask: int) -> bool:
    """Return whether all bits of a mask are set."""
    return word & mask == mask


def _capture_alone(word: int) -> bool:
    """Return whether the capture input is used without an encoder."""
    return _all(word, _CAPTURE) and not word & _ENCODER


def _refuse(broken_rules: tuple[str, ...], subject: str) -> None:
    """Raise a ValueError with the clauses of the broken rules, if there are any."""
    if broken_rules:
        raise ValueError(f"{subject} is invalid: {'; '.join(RULES[rule].clause for rule in broken_rules)}")
