"""Determines whether the module has accepted a command, and whether the command can still end.

If a command did not arrive, the completion bits may be from the previous command. The module has accepted a
command if the axis moves, if its completion bit is off, or if the axis is at its target. A command that
neither moves nor ends for two round trips has not begun, or did not end as expected.
"""

from __future__ import annotations

from collections.abc import Sequence

from scanrack.io_images.amci3601.bits import StatusLsw, StatusMsw

from .kinds import ABSOLUTE, GEAR, HOME, PRESET, RELATIVE, RUN_BLEND, CommandKind

HOME_REST_NS = 3_000_000_000
"""Maximum time at rest while homing: two seconds on an end limit [3601 manual, chapter 4, Find Home]."""

_INVALID = StatusMsw.POSITION_INVALID.value
_STOPPED = StatusMsw.STOPPED.value
_MODULE_OK = StatusMsw.MODULE_OK.value
_COMPLETE = StatusMsw.MOVE_COMPLETE.value
_FOLLOWING = StatusLsw.ENC_FOLLOWER.value

_COMPLETION = {
    ABSOLUTE: _COMPLETE,
    RELATIVE: _COMPLETE,
    RUN_BLEND: _COMPLETE,
    HOME: StatusMsw.AT_HOME.value,
}
"""The completion bit that turns off when the module accepts a command."""


class Evidence:
    """The evidence for a command that was sent.

    Args:
        inputs: input words of the module.
        limit_ns: maximum time that an axis may rest during a command.
    """

    def __init__(self, inputs: memoryview, limit_ns: int) -> None:
        self._inputs, self._limit_ns = inputs, limit_ns
        self.accepted = False  # whether the module has accepted the command
        self.was_valid = False  # whether the position was valid when the command was sent
        self.broken = False  # whether the link was lost since then, with no motion on a good link afterwards
        self._start_position = (0, 0)  # input words 2 and 3
        self._phase = 0  # output word 1 in the previous scan
        self._rests_since_ns: int | None = None  # start of the rest in this phase

    def begin(self) -> None:
        """Store the status when a command is sent."""
        words = self._inputs
        self.accepted = self.broken = False
        self.was_valid = not words[0] & _INVALID
        if words[0] >= 0:  # not in configuration mode
            self._start_position = (words[2], words[3])

    def observe(self, kind: CommandKind, out: Sequence[int], *, moving: bool, down: bool) -> None:
        """Add the status of a scan while the module has the command's words."""
        if down:
            self.broken = True
        elif moving:
            self.broken = False
        if not self.accepted:
            self.accepted = moving or self._has_left() or self._accepted_at_rest(kind, out)

    def _has_left(self) -> bool:
        """Return whether the position has changed since the command was sent."""
        return self._inputs[0] >= 0 and (self._inputs[2], self._inputs[3]) != self._start_position

    def _accepted_at_rest(self, kind: CommandKind, out: Sequence[int]) -> bool:
        """Return whether the module accepted a command at rest: a bit turned off, or none is needed."""
        if not self._inputs[0] & _COMPLETION.get(kind, -1):
            return True
        if kind is RELATIVE:
            return out[2] == out[3] == 0
        return kind in (ABSOLUTE, HOME) and self.reached(out)

    def reached(self, out: Sequence[int]) -> bool:
        """Return whether the axis is at the position in output words 2 and 3."""
        return self._inputs[2] == out[2] and self._inputs[3] == out[3]

    def may_have_ended(self, kind: CommandKind, out: Sequence[int]) -> bool:
        """Return whether an axis at rest with this status may have ended the command."""
        invalid = self._inputs[0] & _INVALID != 0
        if kind is PRESET:
            return self.reached(out) and not invalid
        if kind.ends_at_rest:
            return self.accepted and (not invalid or not (self.was_valid or self.broken))
        return self.accepted or kind not in _COMPLETION

    def rests_too_long(self, kind: CommandKind, phase: int, now_ns: int, *, idle: bool) -> bool:
        """Measure how long the axis has rested in a `phase` (output word 1); return whether too long."""
        rests = idle and self._inputs[0] & _MODULE_OK and phase == self._phase
        self._phase = phase
        if not rests or (kind is GEAR and self._inputs[1] & _FOLLOWING):
            self._rests_since_ns = None
        elif self._rests_since_ns is None:
            self._rests_since_ns = now_ns
        searches = kind is HOME and not self._inputs[0] & _STOPPED
        limit_ns = self._limit_ns + (HOME_REST_NS if searches else 0)
        return self._rests_since_ns is not None and now_ns - self._rests_since_ns >= limit_ns
