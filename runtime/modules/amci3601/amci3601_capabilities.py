"""The 3601's functions that an axis lacks, known before a command is sent to it.

The command layer checks the manual's own rules first, then the axis. A function that the
axis lacks is refused in the 3601's error bits; an event gives the reason.
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
    """A request to an axis that the 3601's own rules allow."""

    feature: Feature
    command: CommandWords  # the output words
    configuration: Configuration
    distance: int = 0  # distance of a move, signed steps
    minimum_registration: int = 0  # the stored distance, steps


@dataclass(frozen=True, slots=True)
class Refusal:
    """The reason why an axis does not carry out a request."""

    name: str  # short name of the missing function, for events
    bits: int  # error bits of input word 0 that are set
    reason: str  # a sentence for the user


class AxisHoming(Enum):
    """The part of homing that an axis does itself."""

    NONE = "nothing"
    LEAVES_SWITCH = "it stops on leaving the home switch"
    MEETS_SWITCH = "it stops on meeting the home switch, and leaves one that is active first"
    WHOLE = "all of it, limits and reversals included"
    MEETS_SWITCH_SLOWLY = "it stops on meeting the home switch, slowed down by the proximity before"


class Capabilities:
    """The functions of an axis, by default all. A limited axis overrides the methods.

    Attributes:
        homing: the part of `Axis.home`, for every kind of homing.
        shared_limit: the end limits share one input: both bits on means an active limit on an unknown side.
        home_is_ccw_limit: the home switch is also the CCW limit; an active switch blocks CCW motion only.
    """

    homing = AxisHoming.NONE
    shared_limit = False
    home_is_ccw_limit = False

    def homing_for(self, kind: HomingKind) -> AxisHoming:
        """Return the part of `Axis.home` in a search of that kind."""
        return self.homing

    def lacking_for_configuration(self, configuration: Configuration) -> Refusal | None:
        """Return why the axis can't use a configuration that the 3601 accepts, or None."""
        return None

    def lacking_for(self, request: AxisRequest) -> Refusal | None:
        """Return why the axis can't carry out a command that the 3601 accepts, or None."""
        return None
