"""What a motion does when something comes in between: the base of all operations.

An operation is one motion from its acceptance to its end. Each kind answers
the same few questions in its own file, which together are the manual's tables
of what Hold, the external input and the end limits do to which move.
"""

from __future__ import annotations

from enum import Enum
from typing import TYPE_CHECKING, ClassVar

from ....io_images.amci3601 import InputBit
from .command_words import CommandWords

if TYPE_CHECKING:
    from .command_layer import CommandLayer

CW_LIMIT = InputBit.CW_LIMIT.value
CCW_LIMIT = InputBit.CCW_LIMIT.value
EITHER_LIMIT = CW_LIMIT | CCW_LIMIT


class Limits(Enum):
    """Which end limits stop a motion at once [chapter 4, note 4; chapter 6, Position Invalid 4]."""

    EITHER = "either"
    SAME_DIRECTION = "same direction"
    OWN = "the operation deals with them itself"


def limit_of(direction: int) -> int:
    """Return the input bit of the end limit that lies in `direction` (+1 CW, -1 CCW)."""
    return CW_LIMIT if direction > 0 else CCW_LIMIT


def limit_in(layer: CommandLayer, direction: int) -> bool:
    """Whether the end limit in a direction is active, as far as that is known."""
    if layer.axis.capabilities.shared_limit and layer.active & EITHER_LIMIT == EITHER_LIMIT:
        return False
    return bool(layer.active & limit_of(direction))


class Operation:
    """One motion, from acceptance to end.

    Attributes:
        name: what people call it.
        limits: which end limits stop it.
        busy: whether a new move has to wait for it.
        shown_direction: direction of the motion bits while the axis runs no motion of its own.
        shown_ramp: the same for the ramp bits.
    """

    name: ClassVar[str] = ""
    limits: ClassVar[Limits] = Limits.EITHER

    def __init__(self, layer: CommandLayer, now_ns: int) -> None:
        self.layer = layer
        self.started_ns = now_ns
        self.started_at = layer.axis.position
        self.shown_direction = 0
        self.shown_ramp = 0

    @property
    def busy(self) -> bool:
        """Whether a new move has to wait for this one [chapter 6, Command Error 3]."""
        return True

    @property
    def over(self) -> bool:
        """Whether the motion has come to its end."""
        return not self.layer.axis.moving

    def on_hold(self, now_ns: int) -> None:
        """Hold was commanded; refused unless the operation can be held [chapter 6, Command Error 7]."""
        self.layer.fire(now_ns, "CMD-07")

    def on_forfeit(self) -> None:
        """A command or an error has come: what is being held can't be resumed any more."""

    def on_many_bits(self, now_ns: int) -> None:
        """More than one command bit is set; a running move goes on (reading A-33)."""

    def on_external(self, now_ns: int) -> None:
        """The external input is active; ignored unless the operation obeys it."""

    def on_order(self, now_ns: int, order: CommandWords) -> None:
        """The output image has changed while this operation runs."""

    def on_tick(self, now_ns: int, order: CommandWords) -> None:
        """A tick: look at what is checked by level while this operation runs."""

    def on_counts(self, now_ns: int, order: CommandWords) -> None:
        """A scan ends: act on what the encoder has counted in it, under the words of that scan."""

    def on_release(self, now_ns: int) -> None:
        """All command bits count as 0, since configuration mode is requested (reading A-10)."""

    def next_wake_ns(self, now_ns: int) -> int | None:
        """Return when this operation wants a tick though nothing else happens; None = it does not."""
        return None

    def wants_counts(self, *, turning: bool) -> bool:
        """Return whether `on_counts` is wanted at the end of the scan that begins now.

        Args:
            turning: somebody turns the encoder by hand in it.
        """
        return False

    def on_end(self, now_ns: int) -> None:
        """The motion has come to its end by itself."""
        raise NotImplementedError
