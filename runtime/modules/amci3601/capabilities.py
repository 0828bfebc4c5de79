"""What an axis can't do of the 3601's functions, known before anything is sent to it.

The command layer checks the manual's own rules first, then the axis. What the
axis can't do is refused in the 3601's error bits; an event gives the reason.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from ....io_images.amci3601 import Configuration, HomingKind
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
class Request:
    """A request to an axis that the 3601's own rules allow.

    Attributes:
        command: the words that ask for it.
        distance: of a move, steps, signed.
        minimum_registration: the stored distance, steps.
    """

    feature: Feature
    command: CommandWords
    configuration: Configuration
    distance: int = 0
    minimum_registration: int = 0


@dataclass(frozen=True, slots=True)
class Refusal:
    """Why an axis does not carry out a request.

    Attributes:
        name: short name of what is lacking, for events.
        bits: error bits of input word 0 that are set.
        reason: a sentence for the user.
    """

    name: str
    bits: int
    reason: str


class AxisHoming(Enum):
    """The part of a search for home that an axis does itself."""

    NONE = "nothing"
    LEAVES_SWITCH = "it stops on leaving the home switch"
    MEETS_SWITCH = "it stops on meeting the home switch, and leaves one that is active first"
    MEETS_SWITCH_SLOWLY = "it stops on meeting the home switch, slowed down by the proximity before"


class Capabilities:
    """What an axis can do: everything. A limited axis overrides the methods.

    Attributes:
        homing: what `Axis.home` does, whatever the kind of homing.
        shared_limit: the end limits share one input: both active means one of them, side unknown.
        home_is_ccw_limit: the home switch is the CCW limit, too: active, it blocks CCW motion only.
    """

    homing = AxisHoming.NONE
    shared_limit = False
    home_is_ccw_limit = False

    def homing_for(self, kind: HomingKind) -> AxisHoming:
        """Return what `Axis.home` does in a search of that kind."""
        return self.homing

    def lacking_for_configuration(self, configuration: Configuration) -> Refusal | None:
        """Return why a configuration that the 3601 accepts is refused, None if it is not."""
        return None

    def lacking_for(self, request: Request) -> Refusal | None:
        """Return why a command that the 3601 accepts is refused, None if it is not."""
        return None
