"""Find Home where the axis does a part of the search itself, as a controller behind an adapter does.

What it leaves to the command layer is in `homing`; which of these an axis calls for, in its capabilities.
"""

from __future__ import annotations

from dataclasses import replace

from .capabilities import AxisHoming, Inability
from .homing import HOME, Homing, Phase
from .latches import HOME_INVALID, INPUT_ERROR, POSITION_INVALID
from .operation import CW_LIMIT
from .order import Order

NO_HOME = HOME_INVALID | INPUT_ERROR | POSITION_INVALID
HOME_BEFORE_PROXIMITY = Inability(
    "home before proximity",
    NO_HOME,
    "the home switch was met before the home proximity, and has stopped the axis without a ramp",
)
"""What a 3601 would pass over [chapter 4, Find Home]."""

STOPPED_ELSEWHERE = Inability(
    "stopped elsewhere", NO_HOME, "the axis has stopped in a search for home, and not at the home switch"
)


class HomingByAxis(Homing):
    """A search by an axis that finds the home switch itself: it stops on leaving the switch.

    What is left to the command layer: a switch that is on at the start is left at
    starting speed first, and an end limit turns the search round after its dwell.
    """

    def _begin_seek(self, now_ns: int) -> None:
        self.phase = Phase.SEEK
        self.layer.axis.home(now_ns, self.direction, self.profile)

    def _back(self, now_ns: int) -> None:
        self.phase = Phase.BACK
        if self.reversed:
            self.layer.axis.home(now_ns, -self.direction, self.profile)
        else:
            self._signal_was_on = self._signal
            slow = replace(self.profile, speed_sps=self.profile.start_sps)
            self.layer.axis.run(now_ns, -self.direction, slow)

    def _creep(self, now_ns: int) -> None:
        self._begin_seek(now_ns)

    def _seek(self, now_ns: int) -> None:
        self.found = not self.layer.axis.moving

    def _look_behind(self, now_ns: int) -> None:
        if self.reversed:
            self.found = not self.layer.axis.moving
        else:
            super()._look_behind(now_ns)


class HomingOntoSwitch(Homing):
    """A search by an axis that leaves and finds the home switch itself, without a dwell.

    The home switch is the end limit of that side, too, and no limit meanwhile.
    """

    def start(self, now_ns: int) -> None:
        """Let the axis search."""
        self.layer.axis.home(now_ns, self.direction, self.profile)

    def on_tick(self, now_ns: int, order: Order) -> None:
        """Look at the opposite limit, and whether the switch has been met when the axis stands still."""
        layer = self.layer
        if layer.risen & CW_LIMIT:
            layer.abort_homing(now_ns, "HOM-05")
        elif not layer.axis.moving:
            self.found = bool(layer.active & HOME)
            if not self.found:
                layer.abort_homing(now_ns, "HOM-05")


class HomingSlowedByProximity(Homing):
    """A search by an axis that stops at the home switch itself, at full speed unless it was slowed down.

    The proximity slows it down. A switch that is met before has stopped it too hard for a home.
    """

    def _begin_seek(self, now_ns: int) -> None:
        self.phase = Phase.SEEK
        self.layer.axis.home(now_ns, self.direction, self.profile)

    def _creep(self, now_ns: int) -> None:
        self.phase = Phase.CREEP
        slow = replace(self.profile, speed_sps=self.profile.start_sps)
        self.layer.axis.home(now_ns, self.direction, slow)

    def _seek(self, now_ns: int) -> None:
        if self.layer.axis.moving:
            super()._seek(now_ns)
        else:
            self._give_up(now_ns, HOME_BEFORE_PROXIMITY if self._at_switch else STOPPED_ELSEWHERE)

    def _is_home(self, home_risen: bool) -> bool:
        return False  # the axis tells by standing still

    def _approach(self, now_ns: int, home_risen: bool) -> None:
        self._seek(now_ns)

    def _take_home(self, now_ns: int, home_risen: bool) -> None:
        if self.layer.axis.moving:
            return
        self.found = self._at_switch
        if not self.found:
            self._give_up(now_ns, STOPPED_ELSEWHERE)

    @property
    def _at_switch(self) -> bool:
        return bool(self.layer.active & HOME)

    def _give_up(self, now_ns: int, reason: Inability) -> None:
        self.layer.refuse(now_ns, reason)
        self.layer.finish(now_ns, 0, "found no home")


HOMINGS: dict[AxisHoming, type[Homing]] = {
    AxisHoming.NONE: Homing,
    AxisHoming.LEAVES_SWITCH: HomingByAxis,
    AxisHoming.MEETS_SWITCH: HomingOntoSwitch,
    AxisHoming.MEETS_SWITCH_SLOWLY: HomingSlowedByProximity,
}
"""The search for home, by what the axis itself does of it."""
