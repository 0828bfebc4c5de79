"""The base of all operations: how a motion reacts to each event; and the operations' host.

An operation is one motion from its acceptance to its end. Each kind has its own file
with the same few methods; together they are the manual's tables of the effects of Hold,
external input and end limits on each move.

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
    """Which end limits stop a motion at once [chapter 4, note 4; chapter 6, Position Invalid 4]."""

    EITHER = "either"
    SAME_DIRECTION = "same direction"
    OWN = "the operation deals with them itself"


def limit_of(direction: int) -> int:
    """Return the input bit of the end limit that lies in `direction` (+1 CW, -1 CCW)."""
    return CW_LIMIT if direction > 0 else CCW_LIMIT


def limit_in(host: Host, direction: int) -> bool:
    """Whether the end limit in a direction is known to be active."""
    if host.axis.capabilities.shared_limit and host.state.active & EITHER_LIMIT == EITHER_LIMIT:
        return False
    return bool(host.state.active & limit_of(direction))


class Host(Protocol):
    """The interface of the command layer to operations."""

    profile: Profile
    axis: Axis
    firmware: Firmware  # decides which functions exist
    options: Amci3601Options
    state: ModuleState
    operation: Operation | None

    @property
    def busy(self) -> bool:
        """Whether a move is in progress that a new move must wait for."""

    @property
    def cuttable(self) -> bool:
        """Whether a move is in progress that has not been cut yet."""

    def fire(self, now_ns: int, rule_id: str, *, alone: bool = False) -> None:
        """Set the bits of a broken rule."""

    def fire_all(self, now_ns: int, faults: Iterable[BrokenRule]) -> None:
        """Set the bits of all rules that one command breaks (reading A-110)."""

    def noticed(self, command: CommandWords, faults: list[BrokenRule]) -> list[BrokenRule]:
        """Return the faults that the module notices, including those by the profile's own rules."""

    def refuse(self, now_ns: int, refusal: Refusal) -> None:
        """Report a refusal of the axis."""

    def unable(self, now_ns: int, feature: Feature, command: CommandWords, distance: int = 0) -> bool:
        """Refuse a function that the axis lacks, and return True; call it after the manual's own rules."""

    def accept(self, operation: Operation) -> None:
        """Start `operation` as the running one."""

    def complete(self, now_ns: int) -> None:
        """End the running operation successfully, unless an error has occurred meanwhile (reading A-27)."""

    def finish(self, now_ns: int, completion: int, how: str) -> None:
        """End the running operation with a completion bit, or 0."""

    def cut(self, now_ns: int, *, stopped: bool = True) -> None:
        """End any motion without a ramp; STOPPED is set once the axis is known to be at rest."""

    def abort_homing(self, now_ns: int, rule_id: str) -> None:
        """End homing that end limits have stopped."""

    def settle(self, now_ns: int) -> None:
        """Finish an operation whose motion has ended."""


class Operation:
    """One motion, from acceptance to end."""

    name: ClassVar[str] = ""
    limits: ClassVar[Limits] = Limits.EITHER  # the end limits that stop it
    status_lsw: ClassVar[int] = 0  # bits of status word LSW while it runs
    cut_ns: int | None = None  # the instant at which it was cut, if it ends later

    def __init__(self, host: Host, now_ns: int) -> None:
        self.host = host
        self.axis = host.axis
        self.state = host.state
        self.started_ns = now_ns
        self.started_at = self.axis.position
        self.shown_direction = 0  # direction of the motion bits while the axis itself runs no motion
        self.shown_ramp = 0

    @property
    def busy(self) -> bool:
        """Whether a new move must wait for this one [chapter 6, Command Error 3]."""
        return True

    @property
    def over(self) -> bool:
        """Whether the motion has ended."""
        return not self.axis.moving

    def on_hold(self, now_ns: int) -> None:
        """Refuse Hold, unless the operation can be held [chapter 6, Command Error 7]."""
        self.host.fire(now_ns, "CMD-07")

    def on_forfeit(self) -> None:
        """React to a command or an error: a held move can no longer be resumed."""

    def on_many_bits(self, now_ns: int) -> None:
        """React to more than one command bit; a running move continues (reading A-33)."""

    def on_external(self, now_ns: int) -> None:
        """React to the active external input; ignored by default."""

    def on_words(self, now_ns: int, command: CommandWords) -> None:
        """React to a change of the output image."""

    def on_tick(self, now_ns: int, command: CommandWords) -> None:
        """Check levels at a tick."""

    def on_counts(self, now_ns: int, command: CommandWords) -> None:
        """Process the encoder counts of a scan at its end, under the words of that scan."""

    def on_release(self, now_ns: int) -> None:
        """React to a request for configuration mode: all command bits count as 0 (reading A-10)."""

    def next_wake_ns(self, now_ns: int) -> int | None:
        """Return the instant of a tick that this operation needs without other events, or None."""
        return None

    def counts_from_ns(self, now_ns: int, turns_ns: int | None) -> int | None:
        """Return the instant from which every scan ends with `on_counts`; None = never.

        Args:
            turns_ns: the instant from which something other than the motor turns the encoder, None = never.
        """
        return None

    def on_end(self, now_ns: int) -> None:
        """React to the regular end of the motion."""
        raise NotImplementedError
