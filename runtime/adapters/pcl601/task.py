"""One motion of the controller, from the command layer's wish to its end."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from ....io_images.pcl601 import Code
from ...kinematics import Motion
from .units import Drive


class Kind(Enum):
    """What a motion is to the controller: the command code that starts it."""

    INDEX = Code.GO
    SLEW = Code.GO_SLEW
    HOME = Code.HOME_TYPE_1


@dataclass(slots=True)
class Task:
    """One motion.

    Attributes:
        kind: how it is started.
        direction: +1 CW, -1 CCW.
        drive: speeds and acceleration.
        steps: of an index; of a slew the steps after its mark, 0 where there is no mark.
        shown: whether the command layer counts it as a motion.
        stopping: a soft stop is wanted, or under way.
        marked: the mark of a slew is to be set.
        following: the motion that takes over when this one has stopped.
        model: what the controller is thought to be doing; None before its start.
    """

    kind: Kind
    direction: int
    drive: Drive
    steps: int = 0
    shown: bool = True
    stopping: bool = False
    marked: bool = False
    following: Task | None = None
    model: Motion | None = None

    @property
    def ramps_up(self) -> bool:
        """Whether it begins with a ramp that lasts."""
        return self.drive.speed_sps - self.drive.base_sps > 1

    @property
    def registers(self) -> bool:
        """Whether it is a slew that ends so many steps after its mark."""
        return self.kind is Kind.SLEW and self.steps > 0
