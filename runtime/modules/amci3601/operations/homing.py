"""Find Home: one sequence for all four kinds [chapter 3, item 10; chapter 4, Find Home].

The text of the manual lacks its diagrams, so the sequence below is an interpretation (A-72 to A-77).
"dir" is the commanded direction, Vs the programmed speed, Vo the starting speed. "signal" is the
home switch, or command LSW bit 12 with backplane proximity.

    phase     motion      until
    SEEK      dir, Vs     signal on -> with only a home switch: ramp down, BACK
                                       otherwise: FINAL
    FINAL     dir, to Vo  home switch rises, or the marker comes: done
    BACK      -dir, Vs    signal on and then off -> ramp down, CREEP
    CREEP     dir, Vo     only a home switch: it rises, done; otherwise signal on -> FINAL
    DWELL     none        two seconds after an end limit -> BACK

The search begins with DWELL if the end limit of dir is active, or with BACK if the signal is on.
End limits, with "becomes" for a change and "is" for a level:

    heading              limit of dir                   opposite limit
    dir                  is active: DWELL, then BACK    becomes active: HOM-05
    -dir                 (the axis leaves it)           becomes active: HOM-05
    dir, reversed        is active: HOM-04              is active: HOM-04
    -dir, reversed       (the axis leaves it)           is active: HOM-04

A search is "reversed" after an end limit has reversed it. Before that, the opposite limit acts only when it
changes, so a limit that is active at the start has no effect [note 2]. There is one exception: a search that
would begin with BACK toward an active limit does not start (HOM-05, reading A-106). Home has precedence over
a limit in the same tick, so a limit can also be the home switch.
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


class HomingPhase(Enum):
    """A phase of a search; see the table at the beginning of this file."""

    SEEK = "seek"
    FINAL = "final"
    BACK = "back"
    CREEP = "creep"
    DWELL = "dwell"
    STOP_BEFORE_BACK = "stop before back"
    STOP_BEFORE_CREEP = "stop before creep"


SEARCHING = frozenset({HomingPhase.SEEK, HomingPhase.FINAL, HomingPhase.CREEP, HomingPhase.STOP_BEFORE_BACK})
"""Phases whose motion is in the commanded direction."""

TURNING = frozenset({HomingPhase.STOP_BEFORE_BACK, HomingPhase.STOP_BEFORE_CREEP})
"""Phases that end as soon as the axis is at rest."""


class Homing(Operation):
    """A search for home; it ends with AT_HOME, and with position, encoder and captured value at 0."""

    name: ClassVar[str] = "home"
    limits: ClassVar[Limits] = Limits.OWN

    def __init__(self, host: Host, now_ns: int, direction: int, profile: Profile) -> None:
        super().__init__(host, now_ns)
        assert host.state.configuration is not None
        self.kind = host.state.configuration.homing
        self.direction = direction
        self.profile = profile
        self.phase = HomingPhase.SEEK
        self.reversed = False  # an end limit has reversed the search
        self.found = False
        self._dwell_until_ns = 0
        self._after_dwell: Callable[[int], None] = self._begin_back
        self._signal_was_on = False  # whether phase BACK has seen the signal
        self._home_before = bool(host.state.active & HOME)  # the home switch at the last tick

    # -- signals ------------------------------------------------------------------------------

    @property
    @override
    def over(self) -> bool:
        """Whether home has been found and the axis is at rest; stops and waits are part of the search."""
        return self.found and not self.axis.moving

    @property
    def _has_switch_only(self) -> bool:
        return self.kind is HomingKind.HOME_SWITCH

    @property
    def _has_marker(self) -> bool:
        return self.kind in (HomingKind.MARKER_HOME_SWITCH, HomingKind.MARKER_PROXIMITY)

    @property
    def _signal(self) -> bool:
        """Whether the home switch is on, or with backplane proximity, whether its bit is on."""
        if self.kind in (HomingKind.HOME_SWITCH, HomingKind.MARKER_HOME_SWITCH):
            return bool(self.state.active & HOME)
        return self.state.proximity

    @property
    def _on_at_start(self) -> bool:
        """Whether the signal or the home switch is on [chapter 4, Find Home note 2]."""
        return self._signal or bool(self.state.active & HOME)

    @property
    def _slow_profile(self) -> Profile:
        """The profile at the starting speed, to stop exactly on an edge."""
        return replace(self.profile, speed_sps=self.profile.start_sps)

    # -- phases -------------------------------------------------------------------------------

    def start(self, now_ns: int) -> None:
        """Begin with the phase that the inputs require."""
        if limit_in(self.host, self.direction):
            self._begin_dwell(now_ns)
        elif self._on_at_start and limit_in(self.host, -self.direction):
            self.host.abort_homing(now_ns, "HOM-05")
        elif self._on_at_start:
            self._begin_back(now_ns)
        else:
            self._begin_seek(now_ns)

    def _begin_seek(self, now_ns: int) -> None:
        self.phase = HomingPhase.SEEK
        self.axis.run(now_ns, self.direction, self.profile)

    def _begin_dwell(self, now_ns: int) -> None:
        """Stop at an end limit and wait for two seconds; then reverse."""
        self.axis.cut(now_ns)
        self.reversed = True
        self._wait(now_ns, DWELL_NS, self._begin_back)

    def _wait(self, now_ns: int, duration_ns: int, begin_next: Callable[[int], None]) -> None:
        """Wait, regardless of words and inputs; then begin the next phase."""
        self.phase = HomingPhase.DWELL
        self.shown_direction = 0
        self._dwell_until_ns = now_ns + duration_ns
        self._after_dwell = begin_next

    def _begin_back(self, now_ns: int) -> None:
        self.phase = HomingPhase.BACK
        self._signal_was_on = self._signal
        self.axis.run(now_ns, -self.direction, self.profile)

    def _begin_creep(self, now_ns: int) -> None:
        self.phase = HomingPhase.CREEP
        self.axis.run(now_ns, self.direction, self._slow_profile)
        if self._signal:  # the ramp down of BACK has reached it again
            self._begin_final(now_ns)

    def _begin_final(self, now_ns: int) -> None:
        """Slow down after the proximity, and stop at the next home edge or marker."""
        self.axis.change_speed(now_ns, self._slow_profile)
        self.phase = HomingPhase.FINAL
        if self._has_marker:
            self.axis.watch_marker()

    def _stop(self, now_ns: int, phase: HomingPhase) -> None:
        """Ramp down in `phase`; the axis reverses at the next tick. The motion bits show the ramp."""
        self.phase = phase
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
        return self._dwell_until_ns if self.phase is HomingPhase.DWELL else None

    # -- ticks --------------------------------------------------------------------------------

    @override
    def on_tick(self, now_ns: int, command: CommandWords) -> None:
        """Check limits and signals; begin the next phase when the present phase is complete."""
        home_risen = bool(self.state.active & HOME) and not self._home_before
        self._home_before = bool(self.state.active & HOME)
        if now_ns == self.started_ns or self.found:
            return  # at the start, only levels count
        if not self._is_home(home_risen) and self._obey_limits(now_ns):
            return
        if self.phase is HomingPhase.SEEK:
            self._continue_seek(now_ns)
        elif self.phase is HomingPhase.FINAL:
            self._continue_final(now_ns, home_risen)
        elif self.phase is HomingPhase.BACK:
            self._continue_back(now_ns)
        elif self.phase is HomingPhase.CREEP:
            self._continue_creep(now_ns, home_risen)
        elif self.phase is HomingPhase.DWELL and now_ns >= self._dwell_until_ns and not self.axis.moving:
            self._begin_reversed(now_ns, self._after_dwell)
        elif self.phase in TURNING and not self.axis.moving:
            self._after_ramp(now_ns)

    def _continue_seek(self, now_ns: int) -> None:
        """When the signal is on, ramp down before BACK; with more than a home switch, begin FINAL."""
        if not self._signal:
            return
        if self._has_switch_only:
            self._stop(now_ns, HomingPhase.STOP_BEFORE_BACK)
        else:
            self._begin_final(now_ns)

    def _continue_back(self, now_ns: int) -> None:
        """Stop after the signal was on and then off; the ramp-down may have passed a narrow switch."""
        if self._signal:
            self._signal_was_on = True
        elif self._signal_was_on:
            self._stop(now_ns, HomingPhase.STOP_BEFORE_CREEP)

    def _is_home(self, home_risen: bool) -> bool:
        """Return whether this tick finds home; an end limit in the same tick counts as home.

        "It is possible to home the 3601 module off of an end limit switch" [chapter 4, general note 5].
        """
        if self.phase is HomingPhase.FINAL:
            return self.axis.marker_seen if self._has_marker else home_risen
        return self.phase is HomingPhase.CREEP and self._has_switch_only and home_risen

    def _continue_creep(self, now_ns: int, home_risen: bool) -> None:
        """With only a home switch, end at its edge; otherwise, begin FINAL when the signal is on."""
        if self._has_switch_only:
            self._continue_final(now_ns, home_risen)
        elif self._signal:
            self._begin_final(now_ns)

    def _continue_final(self, now_ns: int, home_risen: bool) -> None:
        if self._is_home(home_risen):
            self.axis.cut(now_ns)
            self.found = True

    def _after_ramp(self, now_ns: int) -> None:
        """Reverse at once, or after the configured pause (reading A-72b)."""
        begin_next = self._begin_back if self.phase is HomingPhase.STOP_BEFORE_BACK else self._begin_creep
        pause_ns = self.host.options.home_reversal_dwell_ms * 1_000_000
        if pause_ns and self._has_switch_only:
            self._wait(now_ns, pause_ns, begin_next)
        else:
            self._begin_reversed(now_ns, begin_next)

    def _begin_reversed(self, now_ns: int, begin_next: Callable[[int], None]) -> None:
        """Begin the next phase; end it at once if it moves toward an active limit."""
        begin_next(now_ns)
        self._obey_limits(now_ns)

    # -- limits -------------------------------------------------------------------------------

    def _obey_limits(self, now_ns: int) -> bool:
        """Obey the end limits (see the table of this module); return whether a limit took effect."""
        host = self.host
        if self.phase is HomingPhase.DWELL and self.reversed:
            return False  # the limits are checked after the dwell
        if self.phase in SEARCHING and not self.reversed and host.state.active & limit_of(self.direction):
            self._begin_dwell(now_ns)
            return True
        limits_ahead = host.state.active & limit_of(self.direction) if self.phase in SEARCHING else 0
        opposite = (host.state.active if self.reversed else host.state.risen) & limit_of(-self.direction)
        is_aborted = bool(limits_ahead or opposite)
        if is_aborted:
            host.abort_homing(now_ns, "HOM-04" if self.reversed else "HOM-05")
        return is_aborted

    # -- the end -----------------------------------------------------------------------------

    @override
    def on_end(self, now_ns: int) -> None:
        """Show AT_HOME in one update, with position, encoder and captured value at 0 and valid."""
        host = self.host
        host.axis.preset_position(0)
        host.axis.preset_encoder(0)
        host.state.captured = 0
        host.state.latches.clear(POSITION_INVALID)
        host.finish(now_ns, AT_HOME, "home")
