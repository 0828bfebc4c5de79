"""Find Home: four kinds, one course [chapter 3, item 10; chapter 4, Find Home].

The manual's diagrams are missing from its text; the course below is the
reading used (A-72 to A-77). "dir" is the commanded direction, Vs the
programmed speed, Vo the starting speed, "signal" the home switch, or with
backplane proximity command LSW bit 12.

    phase     motion      until
    SEEK      dir, Vs     signal on -> with a home switch alone: ramp down, BACK
                                       else: FINAL
    FINAL     dir, to Vo  home switch rises, or the marker comes: done
    BACK      -dir, Vs    signal on and then off -> ramp down, CREEP
    CREEP     dir, Vo     home switch alone: it rises, done; else signal on, then as FINAL
    DWELL     none        two seconds after an end limit -> BACK

A signal that is on at the start begins with BACK, the end limit of that
direction with DWELL. Limits, "becomes" for a change and "is" for a level:

    heading              limit of dir                   opposite limit
    dir                  is active: DWELL, then BACK    becomes active: HOM-05
    -dir                 (the axis leaves it)           becomes active: HOM-05
    dir, reversed        is active: HOM-04              is active: HOM-04
    -dir, reversed       (the axis leaves it)           is active: HOM-04

"Reversed" means by an end limit. Before that the opposite limit counts by its
change, since one that is active at the start has no effect [note 2]. Only
an axis that would begin with BACK into that limit does not start: HOM-05
(reading A-106). Home has precedence over a limit of the same tick, so a limit can also be the home switch.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from enum import Enum
from typing import ClassVar

from scanrack.io_images.amci3601 import HomingKind, InputBit
from typing_extensions import override

from ....kinematics import Profile
from ..command_words import CommandWords
from ..latches import AT_HOME, POSITION_INVALID
from ..operation import Host, Limits, Operation, limit_in, limit_of

HOME = InputBit.HOME.value
DWELL_NS = 2_000_000_000
"""Wait after an end limit [chapter 4, Find Home]."""


class Phase(Enum):
    """Phase of a search."""

    SEEK = "seek"
    FINAL = "final"
    BACK = "back"
    CREEP = "creep"
    DWELL = "dwell"
    STOP_BEFORE_BACK = "stop before back"
    STOP_BEFORE_CREEP = "stop before creep"


SEARCHING = frozenset({Phase.SEEK, Phase.FINAL, Phase.CREEP, Phase.STOP_BEFORE_BACK})
"""Phases whose motion is in the commanded direction."""

TURNING = frozenset({Phase.STOP_BEFORE_BACK, Phase.STOP_BEFORE_CREEP})
"""Phases that end when the axis is at rest."""


class Homing(Operation):
    """A search for the home signal; ends in AT_HOME with everything zeroed."""

    name: ClassVar[str] = "home"
    limits: ClassVar[Limits] = Limits.OWN

    def __init__(self, host: Host, now_ns: int, direction: int, profile: Profile) -> None:
        super().__init__(host, now_ns)
        assert host.state.configuration is not None
        self.kind = host.state.configuration.homing
        self.direction = direction
        self.profile = profile
        self.phase = Phase.SEEK
        self.reversed = False  # an end limit has reversed the search
        self.found = False
        self._dwell_until_ns = 0
        self._after_dwell: Callable[[int], None] = self._back
        self._signal_was_on = False
        self._home_before = bool(host.state.active & HOME)

    # -- signals ------------------------------------------------------------------------------

    @property
    @override
    def over(self) -> bool:
        """Whether home is found and the axis is at rest; stops and waits are part of the search."""
        return self.found and not self.axis.moving

    @property
    def _alone(self) -> bool:
        return self.kind is HomingKind.HOME_SWITCH

    @property
    def _with_marker(self) -> bool:
        return self.kind in (HomingKind.MARKER_HOME_SWITCH, HomingKind.MARKER_PROXIMITY)

    @property
    def _signal(self) -> bool:
        """The home switch, or the backplane bit if that is the proximity."""
        if self.kind in (HomingKind.HOME_SWITCH, HomingKind.MARKER_HOME_SWITCH):
            return bool(self.state.active & HOME)
        return self.state.proximity

    @property
    def _on_at_start(self) -> bool:
        """The signal; with backplane proximity also the home switch [chapter 4, Find Home note 2]."""
        return self._signal or bool(self.state.active & HOME)

    @property
    def _slow_profile(self) -> Profile:
        """The programmed rates at the starting speed, for edges that must be met exactly."""
        return replace(self.profile, speed_sps=self.profile.start_sps)

    # -- phases -------------------------------------------------------------------------------

    def start(self, now_ns: int) -> None:
        """Begin with the phase that the inputs require."""
        if limit_in(self.host, self.direction):
            self._dwell(now_ns)
        elif self._on_at_start and limit_in(self.host, -self.direction):
            self.host.abort_homing(now_ns, "HOM-05")
        elif self._on_at_start:
            self._back(now_ns)
        else:
            self._begin_seek(now_ns)

    def _begin_seek(self, now_ns: int) -> None:
        self.phase = Phase.SEEK
        self.axis.run(now_ns, self.direction, self.profile)

    def _dwell(self, now_ns: int) -> None:
        """Stand still for two seconds after an end limit, then reverse."""
        self.axis.cut(now_ns)
        self.reversed = True
        self._wait(now_ns, DWELL_NS, self._back)

    def _wait(self, now_ns: int, duration_ns: int, then: Callable[[int], None]) -> None:
        """Stand still for a time, regardless of words and inputs."""
        self.phase = Phase.DWELL
        self.shown_direction = 0
        self._dwell_until_ns = now_ns + duration_ns
        self._after_dwell = then

    def _back(self, now_ns: int) -> None:
        self.phase = Phase.BACK
        self._signal_was_on = self._signal
        self.axis.run(now_ns, -self.direction, self.profile)

    def _creep(self, now_ns: int) -> None:
        self.phase = Phase.CREEP
        self.axis.run(now_ns, self.direction, self._slow_profile)
        if self._signal:  # the previous stop reached it again
            self._final(now_ns)

    def _final(self, now_ns: int) -> None:
        """Slow down after the proximity, and stop at the next home edge or marker."""
        self.axis.change_speed(now_ns, self._slow_profile)
        self.phase = Phase.FINAL
        if self._with_marker:
            self.axis.watch_marker()

    def _stop(self, now_ns: int, then: Phase) -> None:
        """Ramp down; the tick after the ramp reverses, and shows the phase until then."""
        self.phase = then
        self.shown_direction = self.axis.direction
        self.shown_ramp = -1 if self.profile.has_ramps else 0
        self.axis.stop(now_ns, self.profile.deceleration_spmss, self.profile.shape)

    @override
    def next_wake_ns(self, now_ns: int) -> int | None:
        """Return the end of a dwell, or the tick after a ramp of zero duration."""
        if self.axis.moving:
            return None
        if self.phase in TURNING:
            return now_ns + 1
        return self._dwell_until_ns if self.phase is Phase.DWELL else None

    # -- ticks --------------------------------------------------------------------------------

    @override
    def on_tick(self, now_ns: int, command: CommandWords) -> None:
        """Check limits and signals, and start the next phase where due."""
        home_risen = bool(self.state.active & HOME) and not self._home_before
        self._home_before = bool(self.state.active & HOME)
        if now_ns == self.started_ns or self.found:
            return  # a change before the start counts as present at the start
        if not self._is_home(home_risen) and self._met_a_limit(now_ns):
            return
        if self.phase is Phase.SEEK:
            self._seek(now_ns)
        elif self.phase is Phase.FINAL:
            self._take_home(now_ns, home_risen)
        elif self.phase is Phase.BACK:
            self._look_behind(now_ns)
        elif self.phase is Phase.CREEP:
            self._approach(now_ns, home_risen)
        elif self.phase is Phase.DWELL and now_ns >= self._dwell_until_ns and not self.axis.moving:
            self._turn_round(now_ns, self._after_dwell)
        elif self.phase in TURNING and not self.axis.moving:
            self._after_ramp(now_ns)

    def _seek(self, now_ns: int) -> None:
        if not self._signal:
            return
        if self._alone:
            self._stop(now_ns, Phase.STOP_BEFORE_BACK)
        else:
            self._final(now_ns)

    def _look_behind(self, now_ns: int) -> None:
        """Wait on the way back for the signal to be on, then off: a narrow switch may have been passed."""
        if self._signal:
            self._signal_was_on = True
        elif self._signal_was_on:
            self._stop(now_ns, Phase.STOP_BEFORE_CREEP)

    def _is_home(self, home_risen: bool) -> bool:
        """Return whether this tick finds home; an end limit of the same tick counts as home.

        "It is possible to home the 3601 module off of an end limit switch" [chapter 4, general note 5].
        """
        if self.phase is Phase.FINAL:
            return self.axis.marker_seen if self._with_marker else home_risen
        return self.phase is Phase.CREEP and self._alone and home_risen

    def _approach(self, now_ns: int, home_risen: bool) -> None:
        if self._alone:
            self._take_home(now_ns, home_risen)
        elif self._signal:
            self._final(now_ns)

    def _take_home(self, now_ns: int, home_risen: bool) -> None:
        if self._is_home(home_risen):
            self.axis.cut(now_ns)
            self.found = True

    def _after_ramp(self, now_ns: int) -> None:
        """Reverse, at once unless a pause is configured (reading A-72b)."""
        next_phase = self._back if self.phase is Phase.STOP_BEFORE_BACK else self._creep
        pause_ns = self.host.options.home_reversal_dwell_ms * 1_000_000
        if pause_ns and self._alone:
            self._wait(now_ns, pause_ns, next_phase)
        else:
            self._turn_round(now_ns, next_phase)

    def _turn_round(self, now_ns: int, turn: Callable[[int], None]) -> None:
        """Start the next phase, unless it heads for an active limit."""
        turn(now_ns)
        self._met_a_limit(now_ns)

    # -- limits -------------------------------------------------------------------------------

    def _met_a_limit(self, now_ns: int) -> bool:
        """Obey the end limits by the table above; return whether one was met."""
        host = self.host
        if self.phase is Phase.DWELL and self.reversed:
            return False  # limits that are active then are checked at the reversal
        if self.phase in SEARCHING and not self.reversed and host.state.active & limit_of(self.direction):
            self._dwell(now_ns)
            return True
        met_limit = host.state.active & limit_of(self.direction) if self.phase in SEARCHING else 0
        opposite = (host.state.active if self.reversed else host.state.risen) & limit_of(-self.direction)
        if met_limit or opposite:
            host.abort_homing(now_ns, "HOM-04" if self.reversed else "HOM-05")
        return bool(met_limit or opposite)

    # -- the end -----------------------------------------------------------------------------

    @override
    def on_end(self, now_ns: int) -> None:
        """Show home: position, encoder and captured value are zero and valid, all in one update."""
        host = self.host
        host.axis.preset_position(0)
        host.axis.preset_encoder(0)
        host.state.captured = 0
        host.state.latches.clear(POSITION_INVALID)
        host.finish(now_ns, AT_HOME, "home")
