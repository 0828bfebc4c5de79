"""Find Home on an axis that carries out part of the search itself, such as an adapter's controller.

The base class in `homing` does the rest of the search. The capabilities of the axis select the class.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from typing_extensions import override

from ....kinematics import Profile
from ..amci3601_capabilities import AxisHoming, Refusal
from ..command_words import CommandWords
from ..latches import HOME_INVALID, INPUT_ERROR, POSITION_INVALID
from ..operation import CW_LIMIT, Host, limit_of
from .homing import HOME, Homing, HomingPhase

NO_HOME = HOME_INVALID | INPUT_ERROR | POSITION_INVALID
HOME_BEFORE_PROXIMITY = Refusal(
    "home before proximity",
    NO_HOME,
    "the home switch was reached before the home proximity, and has stopped the axis without a ramp",
)
"""The home switch came before the proximity, where a 3601 ignores it [chapter 4, Find Home]."""

STOPPED_ELSEWHERE = Refusal(
    "stopped elsewhere", NO_HOME, "the axis has stopped in a search for home, but not at the home switch"
)


def give_up(host: Host, now_ns: int, reason: Refusal) -> None:
    """End a search that has not found home, with the axis at rest."""
    host.refuse(now_ns, reason)
    host.finish(now_ns, 0, "found no home")


class HomingByAxis(Homing):
    """A search by an axis that finds the home switch itself, and stops on leaving it.

    If the switch is on at the start, the command layer leaves it at starting speed. It reverses the
    search after the dwell on an end limit. If the limit is on the switch, or if the ramp-down reaches the
    limit, it leaves the switch and returns at starting speed.
    """

    _search_start = 0
    """Position at the start of the axis's search, steps."""

    @override
    def _begin_seek(self, now_ns: int) -> None:
        self.phase = HomingPhase.SEEK
        self._search(now_ns, self.direction, self.profile)

    def _search(self, now_ns: int, direction: int, profile: Profile) -> None:
        self._search_start = self.axis.position
        self.axis.home(now_ns, direction, profile)

    @override
    def _begin_back(self, now_ns: int) -> None:
        """Turn back: search for the switch if it is still ahead, otherwise leave it at starting speed."""
        self.phase = HomingPhase.BACK
        self._signal_was_on = self._signal
        if self._searches_on_way_back:
            self._search(now_ns, -self.direction, self.profile)
        else:
            self.axis.run(now_ns, -self.direction, self._slow_profile)

    @property
    def _searches_on_way_back(self) -> bool:
        """Whether the axis searches for the switch on the way back because it has not reached it yet."""
        return self.reversed and not self._signal_was_on

    @override
    def _begin_creep(self, now_ns: int) -> None:
        """Search in the commanded direction, at starting speed if an end limit has reversed the search."""
        if self.reversed:
            self.phase = HomingPhase.CREEP
            self._search(now_ns, self.direction, self._slow_profile)
        else:
            self._begin_seek(now_ns)

    @override
    def _continue_seek(self, now_ns: int) -> None:
        """Wait for the end of the search. If the axis has not made a step, it has not found the switch."""
        if self.axis.moving:
            return
        self.found = self.axis.position != self._search_start
        if not self.found:
            give_up(self.host, now_ns, STOPPED_ELSEWHERE)

    @override
    def _continue_back(self, now_ns: int) -> None:
        if self._searches_on_way_back:
            self._continue_seek(now_ns)
        else:
            super()._continue_back(now_ns)

    @override
    def _continue_creep(self, now_ns: int, home_risen: bool) -> None:
        self._continue_seek(now_ns)

    @override
    def _obey_limits(self, now_ns: int) -> bool:
        """Obey the end limits; if a limit stops the axis on the edge of the switch, the axis is at home."""
        is_at_switch = self.phase is HomingPhase.CREEP and self._signal
        if is_at_switch and self.state.active & limit_of(self.direction):
            return False
        return super()._obey_limits(now_ns)


class HomingOntoSwitch(Homing):
    """A search by an axis that leaves and finds the home switch itself, without a dwell.

    The home switch is also the end limit of that side; the search ignores it as a limit.
    """

    @override
    def start(self, now_ns: int) -> None:
        self.axis.home(now_ns, self.direction, self.profile)

    @override
    def on_tick(self, now_ns: int, command: CommandWords) -> None:
        """Check the opposite limit; when the axis is at rest, check the switch."""
        host = self.host
        if host.state.risen & CW_LIMIT:
            host.abort_homing(now_ns, "HOM-05")
        elif not host.axis.moving:
            self.found = bool(host.state.active & HOME)
            if not self.found:
                host.abort_homing(now_ns, "HOM-05")


class HomingSlowedByProximity(Homing):
    """A search by an axis that stops at the home switch itself, after the proximity has slowed it down.

    If the switch comes before the proximity, it stops the axis at full speed without a ramp, and the axis is
    not at home.
    """

    @override
    def _begin_seek(self, now_ns: int) -> None:
        self.phase = HomingPhase.SEEK
        self.axis.home(now_ns, self.direction, self.profile)

    @override
    def _begin_creep(self, now_ns: int) -> None:
        self.phase = HomingPhase.CREEP
        self.axis.home(now_ns, self.direction, self._slow_profile)

    @override
    def _continue_seek(self, now_ns: int) -> None:
        if self.axis.moving:
            super()._continue_seek(now_ns)
        else:
            give_up(self.host, now_ns, HOME_BEFORE_PROXIMITY if self._at_switch else STOPPED_ELSEWHERE)

    @override
    def _is_home(self, home_risen: bool) -> bool:
        return False  # `_continue_final` decides, when the axis is at rest

    @override
    def _continue_creep(self, now_ns: int, home_risen: bool) -> None:
        self._continue_seek(now_ns)

    @override
    def _continue_final(self, now_ns: int, home_risen: bool) -> None:
        """Wait until the axis is at rest; give up if it has not stopped on the home switch."""
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
    """An axis that carries out the whole search itself."""

    @property
    def found_home(self) -> bool:
        """Whether the last search ended at home."""


class HomingByDrive(Homing):
    """A search by an axis that carries out the whole search and reports whether it has found home."""

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
"""Class of the search, by the part that the axis carries out itself."""
