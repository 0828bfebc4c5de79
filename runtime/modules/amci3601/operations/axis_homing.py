"""Find Home on an axis that does a part of the search itself, such as the controller of an adapter.

`homing` has the rest of the search; an axis selects one of these by its capabilities.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from typing_extensions import override

from ....kinematics import Profile
from ..amci3601_capabilities import AxisHoming, Refusal
from ..command_words import CommandWords
from ..latches import HOME_INVALID, INPUT_ERROR, POSITION_INVALID
from ..operation import CW_LIMIT, Host, limit_of
from .homing import HOME, Homing, Phase

NO_HOME = HOME_INVALID | INPUT_ERROR | POSITION_INVALID
HOME_BEFORE_PROXIMITY = Refusal(
    "home before proximity",
    NO_HOME,
    "the home switch was met before the home proximity, and has stopped the axis without a ramp",
)
"""A 3601 ignores the home switch there [chapter 4, Find Home]."""

STOPPED_ELSEWHERE = Refusal(
    "stopped elsewhere", NO_HOME, "the axis has stopped in a search for home, and not at the home switch"
)


def give_up(host: Host, now_ns: int, reason: Refusal) -> None:
    """End a search at rest without home."""
    host.refuse(now_ns, reason)
    host.finish(now_ns, 0, "found no home")


class HomingByAxis(Homing):
    """A search by an axis that finds the home switch itself: it stops on leaving the switch.

    The command layer leaves a switch that is on at the start, at starting speed, and
    reverses the search after the dwell on an end limit. With a limit on the
    switch, or so near that the ramp down meets it, it leaves the switch and meets it
    again at starting speed.
    """

    _search_start = 0
    """Position at the start of the axis's own search."""

    @override
    def _begin_seek(self, now_ns: int) -> None:
        self.phase = Phase.SEEK
        self._search(now_ns, self.direction, self.profile)

    def _search(self, now_ns: int, direction: int, profile: Profile) -> None:
        self._search_start = self.axis.position
        self.axis.home(now_ns, direction, profile)

    @override
    def _back(self, now_ns: int) -> None:
        self.phase = Phase.BACK
        self._signal_was_on = self._signal
        if self._searches_behind:
            self._search(now_ns, -self.direction, self.profile)
        else:
            self.axis.run(now_ns, -self.direction, self._slow_profile)

    @property
    def _searches_behind(self) -> bool:
        """Whether the way back is a search, because the switch has not been met."""
        return self.reversed and not self._signal_was_on

    @override
    def _creep(self, now_ns: int) -> None:
        if self.reversed:
            self.phase = Phase.CREEP
            self._search(now_ns, self.direction, self._slow_profile)
        else:
            self._begin_seek(now_ns)

    @override
    def _seek(self, now_ns: int) -> None:
        """Wait for the end of the search; one that has made no step has not found the switch."""
        if self.axis.moving:
            return
        self.found = self.axis.position != self._search_start
        if not self.found:
            give_up(self.host, now_ns, STOPPED_ELSEWHERE)

    @override
    def _look_behind(self, now_ns: int) -> None:
        if self._searches_behind:
            self._seek(now_ns)
        else:
            super()._look_behind(now_ns)

    @override
    def _approach(self, now_ns: int, home_risen: bool) -> None:
        self._seek(now_ns)

    @override
    def _met_a_limit(self, now_ns: int) -> bool:
        """Handle a limit; if it stops the axis exactly on the edge of the switch, the axis is at home."""
        on_the_edge = self.phase is Phase.CREEP and self._signal
        if on_the_edge and self.state.active & limit_of(self.direction):
            return False
        return super()._met_a_limit(now_ns)


class HomingOntoSwitch(Homing):
    """A search by an axis that leaves and finds the home switch itself, without a dwell.

    The home switch is also the end limit of that side; the search ignores it as a limit.
    """

    @override
    def start(self, now_ns: int) -> None:
        self.axis.home(now_ns, self.direction, self.profile)

    @override
    def on_tick(self, now_ns: int, command: CommandWords) -> None:
        """Check the opposite limit, and at rest whether the switch has been met."""
        host = self.host
        if host.state.risen & CW_LIMIT:
            host.abort_homing(now_ns, "HOM-05")
        elif not host.axis.moving:
            self.found = bool(host.state.active & HOME)
            if not self.found:
                host.abort_homing(now_ns, "HOM-05")


class HomingSlowedByProximity(Homing):
    """A search by an axis that stops at the home switch itself, at full speed unless slowed down.

    The proximity slows it down. A switch that comes before the proximity stops it too hard for a home.
    """

    @override
    def _begin_seek(self, now_ns: int) -> None:
        self.phase = Phase.SEEK
        self.axis.home(now_ns, self.direction, self.profile)

    @override
    def _creep(self, now_ns: int) -> None:
        self.phase = Phase.CREEP
        self.axis.home(now_ns, self.direction, self._slow_profile)

    @override
    def _seek(self, now_ns: int) -> None:
        if self.axis.moving:
            super()._seek(now_ns)
        else:
            give_up(self.host, now_ns, HOME_BEFORE_PROXIMITY if self._at_switch else STOPPED_ELSEWHERE)

    @override
    def _is_home(self, home_risen: bool) -> bool:
        return False  # the axis is at home

    @override
    def _approach(self, now_ns: int, home_risen: bool) -> None:
        self._seek(now_ns)

    @override
    def _take_home(self, now_ns: int, home_risen: bool) -> None:
        if self.axis.moving:
            return
        self.found = self._at_switch
        if not self.found:
            give_up(self.host, now_ns, STOPPED_ELSEWHERE)

    @property
    def _at_switch(self) -> bool:
        return bool(self.state.active & HOME)


@runtime_checkable
class SeekHome(Protocol):
    """An axis that makes a whole search itself."""

    @property
    def found_home(self) -> bool:
        """Whether the last search has ended at home."""


class HomingByDrive(Homing):
    """A search that the axis makes entirely; it reports whether it has found home."""

    @override
    def start(self, now_ns: int) -> None:
        self.axis.home(now_ns, self.direction, self.profile)

    @override
    def on_tick(self, now_ns: int, command: CommandWords) -> None:
        """Adopt the result when the axis is at rest."""
        if not self.axis.moving:
            assert isinstance(self.axis, SeekHome)
            self.found = self.axis.found_home
            if not self.found:
                give_up(self.host, now_ns, STOPPED_ELSEWHERE)


HOMINGS: dict[AxisHoming, type[Homing]] = {
    AxisHoming.NONE: Homing,
    AxisHoming.LEAVES_SWITCH: HomingByAxis,
    AxisHoming.MEETS_SWITCH: HomingOntoSwitch,
    AxisHoming.WHOLE: HomingByDrive,
    AxisHoming.MEETS_SWITCH_SLOWLY: HomingSlowedByProximity,
}
"""Homing, by the axis's own part of it."""
