"""The base class of operations, which defines a motion's reaction to each event, and the operations' host.

An operation is one motion from its acceptance to its end. Each kind has its own file
with the same few methods; together they implement the manual's tables of how Hold, the external input and end
limits affect each move.

Operations use only the `Host` below and the state; the command layer is the host and uses
operations.
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import Enum
from typing import ClassVar, Protocol

from scanrack.io_images.amci3601 import Firmware, InputBit
from scanrack.io_images.amci3601.words import Profile

from .amci3601_capabilities import Feature, Refusal
from .amci3601_options import Amci3601Options
from .axis_protocol import Axis
from .command_words import CommandWords
from .latches import BrokenRule
from .state import ModuleState

CW_LIMIT = InputBit.CW_LIMIT.value
CCW_LIMIT = InputBit.CCW_LIMIT.value
EITHER_LIMIT = CW_LIMIT | CCW_LIMIT


class Limits(Enum):
    """The end limits that cut a motion [chapter 4, note 4; chapter 6, Position Invalid 4]."""

    EITHER = "either"
    SAME_DIRECTION = "same direction"
    OWN = "none: the operation handles limits itself"


def limit_of(direction: int) -> int:
    """Return the input bit of the end limit in a direction (+1 CW, -1 CCW)."""
    return CW_LIMIT if direction > 0 else CCW_LIMIT


def limit_in(host: Host, direction: int) -> bool:
    """Return whether the end limit in a direction is known to be active."""
    if host.axis.capabilities.shared_limit and host.state.active & EITHER_LIMIT == EITHER_LIMIT:
        return False
    return bool(host.state.active & limit_of(direction))


class Host(Protocol):
    """The command layer's interface for operations."""

    profile: Profile
    axis: Axis
    firmware: Firmware  # determines the functions of the module
    options: Amci3601Options
    state: ModuleState
    operation: Operation | None

    @property
    def busy(self) -> bool:
        """Whether a move is running that prevents a new move."""

    @property
    def cuttable(self) -> bool:
        """Whether a move is running that has not been cut yet."""

    def fire(self, now_ns: int, rule_id: str, *, alone: bool = False) -> None:
        """Set the bits of a broken rule."""

    def fire_all(self, now_ns: int, faults: Iterable[BrokenRule]) -> None:
        """Set the bits of all rules that a command breaks (reading A-110)."""

    def noticed(self, command: CommandWords, faults: list[BrokenRule]) -> list[BrokenRule]:
        """Return the faults that the module notices, and the faults from the profile's additional rules."""

    def refuse(self, now_ns: int, refusal: Refusal) -> None:
        """Report a refusal by the axis."""

    def refuse_if_unable(
        self, now_ns: int, feature: Feature, command: CommandWords, distance: int = 0
    ) -> bool:
        """Refuse a function that the axis lacks, after the manual's rules; return whether it was refused."""

    def accept(self, operation: Operation) -> None:
        """Start an operation, which becomes the running one."""

    def complete(self, now_ns: int) -> None:
        """End the running operation with MOVE_COMPLETE, unless an error prevents it (reading A-27)."""

    def finish(self, now_ns: int, completion: int, outcome: str) -> None:
        """End the running operation, and set its completion bit (0 for none)."""

    def cut(self, now_ns: int, *, stopped: bool = True) -> None:
        """End a motion without a ramp; set STOPPED when the axis is known to be at rest."""

    def abort_homing(self, now_ns: int, rule_id: str) -> None:
        """End homing that end limits have stopped."""

    def settle(self, now_ns: int) -> None:
        """Finish an operation whose motion has ended."""


class Operation:
    """One motion, from its acceptance to its end."""

    name: ClassVar[str] = ""  # name in events
    limits: ClassVar[Limits] = Limits.EITHER  # the end limits that cut it
    status_lsw: ClassVar[int] = 0  # bits of status word LSW while it runs
    cut_ns: int | None = None  # the instant of its cut, if it ends later

    def __init__(self, host: Host, now_ns: int) -> None:
        self.host = host
        self.axis = host.axis
        self.state = host.state
        self.started_ns = now_ns
        self.started_at = self.axis.position  # position at the start, steps
        # direction and ramp in the motion bits while the axis runs no motion
        self.shown_direction = 0
        self.shown_ramp = 0

    @property
    def busy(self) -> bool:
        """Whether the operation prevents a new move [chapter 6, Command Error 3]."""
        return True

    @property
    def over(self) -> bool:
        """Whether the motion has ended."""
        return not self.axis.moving

    def on_hold(self, now_ns: int) -> None:
        """Refuse Hold; an operation that can be held overrides this [chapter 6, Command Error 7]."""
        self.host.fire(now_ns, "CMD-07")

    def on_forfeit(self) -> None:
        """React to a command or an error after which Resume can no longer continue the held move."""

    def on_many_bits(self, now_ns: int) -> None:
        """React to more than one command bit; a running move continues (reading A-33)."""

    def on_external(self, now_ns: int) -> None:
        """React to the active external input; by default ignore it."""

    def on_words(self, now_ns: int, command: CommandWords) -> None:
        """React to a change of the output image."""

    def on_tick(self, now_ns: int, command: CommandWords) -> None:
        """Check levels at a tick."""

    def on_counts(self, now_ns: int, command: CommandWords) -> None:
        """Process the encoder counts of a scan at its end, with the words of the scan."""

    def on_release(self, now_ns: int) -> None:
        """React to a request for configuration mode, where all command bits count as 0 (reading A-10)."""

    def next_wake_ns(self, now_ns: int) -> int | None:
        """Return the instant at which the operation needs a tick even without an event, or None."""
        return None

    def counts_from_ns(self, now_ns: int, turns_ns: int | None) -> int | None:
        """Return the instant from which `on_counts` is required at the end of every scan, or None.

        Args:
            turns_ns: the instant at which the encoder begins to turn without the motor, or None.
        """
        return None

    def on_end(self, now_ns: int) -> None:
        """Finish an operation after its motion has ended."""
        raise NotImplementedError
