"""Find Home where the axis does a part of the search itself, as a controller behind an adapter does.

What it leaves to the command layer is in `homing`; which of these an axis calls for, in its capabilities.
"""

from __future__ import annotations

from .capabilities import AxisHoming, Refusal
from .command_words import CommandWords
from .homing import HOME, Homing, Phase
from .latches import HOME_INVALID, INPUT_ERROR, POSITION_INVALID
from .operation import CW_LIMIT, limit_of

NO_HOME = HOME_INVALID | INPUT_ERROR | POSITION_INVALID
HOME_BEFORE_PROXIMITY = Refusal(
    "home before proximity",
    NO_HOME,
    "the home switch was met before the home proximity, and has stopped the axis without a ramp",
)
"""What a 3601 would pass over [chapter 4, Find Home]."""

STOPPED_ELSEWHERE = Refusal(
    "stopped elsewhere", NO_HOME, "the axis has stopped in a search for home, and not at the home switch"
)


class HomingByAxis(Homing):
    """A search by an axis that finds the home switch itself: it stops on leaving the switch.

    What is left to the command host: a switch that is on at the start is left at
    starting speed first, and an end limit turns the search round after its dwell.
    A limit on the switch, or so near that the ramp down has met it: the switch is
    left, and met again at starting speed.
    """

    def _begin_seek(self, now_ns: int) -> None:
        self.phase = Phase.SEEK
        self.axis.home(now_ns, self.direction, self.profile)

    def _back(self, now_ns: int) -> None:
        self.phase = Phase.BACK
        self._signal_was_on = self._signal
        if self._searches_behind:
            self.axis.home(now_ns, -self.direction, self.profile)
        else:
            self.axis.run(now_ns, -self.direction, self._slow_profile)

    @property
    def _searches_behind(self) -> bool:
        """Whether the way back is a search, because the switch has not been met."""
        return self.reversed and not self._signal_was_on

    def _creep(self, now_ns: int) -> None:
        if self.reversed:
            self.phase = Phase.CREEP
            self.axis.home(now_ns, self.direction, self._slow_profile)
        else:
            self._begin_seek(now_ns)

    def _seek(self, now_ns: int) -> None:
        self.found = not self.axis.moving

    def _look_behind(self, now_ns: int) -> None:
        if self._searches_behind:
            self.found = not self.axis.moving
        else:
            super()._look_behind(now_ns)

    def _approach(self, now_ns: int, home_risen: bool) -> None:
        self.found = not self.axis.moving

    def _met_a_limit(self, now_ns: int) -> bool:
        """A limit that has stopped the axis on the very edge of the switch does so at home."""
        on_the_edge = self.phase is Phase.CREEP and self._signal
        if on_the_edge and self.state.active & limit_of(self.direction):
            return False
        return super()._met_a_limit(now_ns)


class HomingOntoSwitch(Homing):
    """A search by an axis that leaves and finds the home switch itself, without a dwell.

    The home switch is the end limit of that side, too, and no limit meanwhile.
    """

    def start(self, now_ns: int) -> None:
        """Let the axis search."""
        self.axis.home(now_ns, self.direction, self.profile)

    def on_tick(self, now_ns: int, command: CommandWords) -> None:
        """Look at the opposite limit, and whether the switch has been met when the axis stands still."""
        host = self.host
        if host.state.risen & CW_LIMIT:
            host.abort_homing(now_ns, "HOM-05")
        elif not host.axis.moving:
            self.found = bool(host.state.active & HOME)
            if not self.found:
                host.abort_homing(now_ns, "HOM-05")


class HomingSlowedByProximity(Homing):
    """A search by an axis that stops at the home switch itself, at full speed unless it was slowed down.

    The proximity slows it down. A switch that is met before has stopped it too hard for a home.
    """

    def _begin_seek(self, now_ns: int) -> None:
        self.phase = Phase.SEEK
        self.axis.home(now_ns, self.direction, self.profile)

    def _creep(self, now_ns: int) -> None:
        self.phase = Phase.CREEP
        self.axis.home(now_ns, self.direction, self._slow_profile)

    def _seek(self, now_ns: int) -> None:
        if self.axis.moving:
            super()._seek(now_ns)
        else:
            self._give_up(now_ns, HOME_BEFORE_PROXIMITY if self._at_switch else STOPPED_ELSEWHERE)

    def _is_home(self, home_risen: bool) -> bool:
        return False  # the axis tells by standing still

    def _approach(self, now_ns: int, home_risen: bool) -> None:
        self._seek(now_ns)

    def _take_home(self, now_ns: int, home_risen: bool) -> None:
        if self.axis.moving:
            return
        self.found = self._at_switch
        if not self.found:
            self._give_up(now_ns, STOPPED_ELSEWHERE)

    @property
    def _at_switch(self) -> bool:
        return bool(self.state.active & HOME)

    def _give_up(self, now_ns: int, reason: Refusal) -> None:
        self.host.refuse(now_ns, reason)
        self.host.finish(now_ns, 0, "found no home")


HOMINGS: dict[AxisHoming, type[Homing]] = {
    AxisHoming.NONE: Homing,
    AxisHoming.LEAVES_SWITCH: HomingByAxis,
    AxisHoming.MEETS_SWITCH: HomingOntoSwitch,
    AxisHoming.MEETS_SWITCH_SLOWLY: HomingSlowedByProximity,
}
"""The search for home, by what the axis itself does of it."""
