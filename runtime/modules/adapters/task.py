"""One motion of a device, from the command layer's request to its end."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Generic, Protocol, TypeVar

from ...kinematics import Motion


class DriveSettings(Protocol):
    """Speeds and ramps of a motion in a device's terms."""

    @property
    def max_sps(self) -> int:
        """Speed between the ramps, steps/s."""


Drive = TypeVar("Drive", bound=DriveSettings)


class TaskKind(Enum):
    """Kind of a motion in a device's terms."""

    INDEX = "a number of steps"
    SLEW = "until a stop"
    HOME = "until the home switch"


@dataclass(slots=True)
class Task(Generic[Drive]):
    """One motion."""

    kind: TaskKind
    direction: int  # +1 CW, -1 CCW
    drive: Drive  # speeds and ramps in the device's terms
    ramps_up: bool  # whether it begins with a ramp
    steps: int = 0  # steps of an index, or of a slew after its mark; 0 for a slew without a mark
    shown: bool = True  # whether the image shows it as a motion; a single pulse is not shown
    stopping: bool = False  # a soft stop is requested or in progress
    marked: bool = False  # the mark of a slew is requested
    following: Task[Drive] | None = None  # the motion that starts when this one has stopped
    model: Motion | None = None  # the planned motion of the device; None before its start

    @property
    def registers(self) -> bool:
        """Whether the task is a registration move: a slew that ends a number of steps after its mark."""
        return self.kind is TaskKind.SLEW and self.steps > 0
