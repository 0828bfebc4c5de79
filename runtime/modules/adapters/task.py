"""One motion of a controller, from the command layer's request to its end."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Generic, TypeVar

from ...kinematics import Motion

Drive = TypeVar("Drive")


class TaskKind(Enum):
    """Kind of a motion in a controller's terms."""

    INDEX = "so many steps"
    SLEW = "until it is stopped"
    HOME = "until the home switch"


@dataclass(slots=True)
class Task(Generic[Drive]):
    """One motion.

    Attributes:
        drive: speeds and ramps in the controller's terms.
        ramps_up: whether it begins with a ramp that lasts.
        steps: of an index; of a slew the steps after its mark, 0 without a mark.
        shown: whether the command layer counts it as a motion.
        stopping: a soft stop is requested or in progress.
        marked: the mark of a slew is requested.
        following: the motion that starts when this one has stopped.
        model: the motion that the controller is assumed to make; None before its start.
    """

    kind: TaskKind
    direction: int
    drive: Drive
    ramps_up: bool
    steps: int = 0
    shown: bool = True
    stopping: bool = False
    marked: bool = False
    following: Task[Drive] | None = None
    model: Motion | None = None

    @property
    def registers(self) -> bool:
        """Whether it is a slew that ends a number of steps after its mark."""
        return self.kind is TaskKind.SLEW and self.steps > 0
