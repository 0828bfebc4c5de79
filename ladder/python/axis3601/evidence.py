"""Whether the module has taken a command, and whether the command can still end.

Completion bits of the command before say nothing of one that did not arrive. It has been taken if the axis
moves, if such a bit is gone, or if the axis is where the command leads. A command that neither moves nor ends
for two round trips has not begun, or has ended otherwise.
"""

from __future__ import annotations

from collections.abc import Sequence

from ....io_images.amci3601.bits import StatusLsw, StatusMsw
from .kinds import ABSOLUTE, GEAR, HOME, PRESET, RELATIVE, RUN_BLEND, CommandKind

HOME_REST_NS = 3_000_000_000
"""How long a search for home may rest: two seconds on an end limit [3601 manual, chapter 4, Find Home]."""

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
"""The completion bit that goes off when the module takes a command."""


class Evidence:
    """What speaks for a command that was sent.

    Attributes:
        taken: the module has taken the command.
        was_valid: the position was valid when the command was sent.
        broken: the link has been lost since then, and no motion was seen with a good link since.

    Args:
        inputs: input words of the module.
        limit_ns: how long an axis may rest under a command.
    """

    def __init__(self, inputs: memoryview, limit_ns: int) -> None:
        self._in, self._limit_ns = inputs, limit_ns
        self.taken = self.was_valid = self.broken = False
        self._from = (0, 0)
        self._phase = 0
        self._rests_since_ns: int | None = None

    def begin(self) -> None:
        """Take note of the status in whose scan a command is sent."""
        words = self._in
        self.taken = self.broken = False
        self.was_valid = not words[0] & _INVALID
        if words[0] >= 0:  # in configuration mode there is no position
            self._from = (words[2], words[3])

    def look(self, kind: CommandKind, out: Sequence[int], *, moving: bool, down: bool) -> None:
        """Take the status of a scan in which the words of the command are in force."""
        self.broken = self.broken or down
        if moving and not down:
            self.broken = False
        if not self.taken:
            self.taken = moving or self._has_left() or self._is_over(kind, out)

    def _has_left(self) -> bool:
        return self._in[0] >= 0 and (self._in[2], self._in[3]) != self._from

    def _is_over(self, kind: CommandKind, out: Sequence[int]) -> bool:
        if not self._in[0] & _COMPLETION.get(kind, -1):
            return True
        if kind is RELATIVE:
            return out[2] == out[3] == 0
        return kind in (ABSOLUTE, HOME) and self.reached(out)

    def reached(self, out: Sequence[int]) -> bool:
        """Return whether the position is that of output words 2 and 3."""
        return self._in[2] == out[2] and self._in[3] == out[3]

    def proves(self, kind: CommandKind, out: Sequence[int]) -> bool:
        """Return whether the status at rest can be the end of this command."""
        invalid = self._in[0] & _INVALID != 0
        if kind is PRESET:
            return self.reached(out) and not invalid
        if kind.ends_at_rest:
            return self.taken and (not invalid or not (self.was_valid or self.broken))
        return self.taken or kind not in _COMPLETION

    def rests_too_long(self, kind: CommandKind, phase: int, now_ns: int, *, idle: bool) -> bool:
        """Return whether the axis has neither moved nor gone on for too long.

        Args:
            kind: the command.
            phase: output word 1: that of a blend that is programmed.
            now_ns: virtual time.
            idle: the axis does not move, the link is good, and a command is in force.
        """
        waits = idle and self._in[0] & _MODULE_OK and phase == self._phase
        self._phase = phase
        if not waits or (kind is GEAR and self._in[1] & _FOLLOWING):
            self._rests_since_ns = None
        elif self._rests_since_ns is None:
            self._rests_since_ns = now_ns
        searches = kind is HOME and not self._in[0] & _STOPPED
        limit_ns = self._limit_ns + HOME_REST_NS * searches
        return self._rests_since_ns is not None and now_ns - self._rests_since_ns >= limit_ns
