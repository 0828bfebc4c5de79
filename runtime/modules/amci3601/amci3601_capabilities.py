"""The 3601's functions, and the functions that an axis lacks.

The command layer checks the manual's rules first, then the axis. It refuses a function that the axis lacks
with the 3601's error bits, and an event states the reason.
"""

from __future__ import annotations

from enum import Enum

from scanrack.io_images.amci3601 import Configuration, HomingKind
from scanrack.io_images.dataclass import dataclass

from .command_words import CommandWords


class Feature(Enum):
    """Functions of an axis."""

    MOVE = "absolute and relative moves, resume"
    HOLD = "hold"
    MANUAL = "manual move"
    SPEED_CHANGE = "speed change in a manual move"
    REGISTRATION = "registration move"
    HOME = "find home"
    ENCODER_MOVE = "encoder move"
    FOLLOWER = "encoder follower"
    BLEND = "blend move"
    BLEND_SEGMENT = "segment of a blend move"
    PRESET_ENCODER = "preset encoder"


@dataclass(frozen=True, slots=True)
class AxisRequest:
    """A request to an axis that the 3601's rules allow."""

    feature: Feature
    command: CommandWords  # the output words
    configuration: Configuration
    distance: int = 0  # distance of a move, signed steps
    minimum_registration: int = 0  # the stored minimum registration distance, steps


@dataclass(frozen=True, slots=True)
class Refusal:
    """The reason why an axis does not carry out a request."""

    name: str  # short name of the missing function, for events
    bits: int  # error bits of input word 0 that are set
    reason: str  # a sentence for the user


class AxisHoming(Enum):
    """The part of homing that an axis carries out itself."""

    NONE = "nothing"
    LEAVES_SWITCH = "it stops when it leaves the home switch"
    MEETS_SWITCH = "it leaves an active home switch, then stops when it meets the switch"
    WHOLE = "the whole search, including limits and reversals"
    MEETS_SWITCH_SLOWLY = "it slows down at the proximity, and stops when it meets the home switch"


class Capabilities:
    """The functions of an axis, by default all. A limited axis overrides the methods.

    Attributes:
        homing: the part of homing that `Axis.home` carries out, for every kind of homing.
        shared_limit: the end limits share one input; both bits show an active limit on an unknown side.
        home_is_ccw_limit: the home switch is also the CCW limit; an active switch blocks CCW motion only.
    """

    homing = AxisHoming.NONE
    shared_limit = False
    home_is_ccw_limit = False

    def homing_for(self, kind: HomingKind) -> AxisHoming:
        """Return the part of a kind of homing that `Axis.home` carries out."""
        return self.homing

    def lacking_for_configuration(self, configuration: Configuration) -> Refusal | None:
        """Return why the axis can't use a configuration that the 3601 accepts, or None."""
        return None

    def lacking_for(self, request: AxisRequest) -> Refusal | None:
        """Return why the axis can't carry out a command that the 3601 accepts, or None."""
        return None
