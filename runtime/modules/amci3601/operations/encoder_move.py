"""Encoder moves: run until the encoder reaches the target count, then ramp down [chapter 4, Encoder Move].

The axis overshoots by design: the deceleration begins at the target, where other moves end.
Only the count, an input or Immediate Stop ends the motion. Without a working encoder it never ends.
"""

from __future__ import annotations

from typing import ClassVar

from typing_extensions import override

from ....kinematics import Profile
from ..command_words import CommandWords
from ..latches import STOPPED
from ..operation import Host, Operation
from ..refusals import ENCODER_MOVE


class EncoderMove(Operation):
    """A motion that lasts until the encoder reaches `target`, and ends with MOVE_COMPLETE."""

    name: ClassVar[str] = "encoder"

    def __init__(self, host: Host, now_ns: int, target: int, direction: int, profile: Profile) -> None:
        super().__init__(host, now_ns)
        self.target = target
        self.direction = direction
        self.profile = profile
        self.stopping = False
        self.stopped_by_input = False

    def start(self, now_ns: int) -> None:
        """Start the axis; if the external input is active, make a single step."""
        axis = self.axis
        if axis.encoder == self.target:
            return
        if self.state.external_active:
            self.stopping = self.stopped_by_input = True
            axis.step_slowly(now_ns, self.direction, self.profile.start_sps)
        else:
            axis.run(now_ns, self.direction, self.profile)
            axis.watch_counts(self.target, self.direction)

    @override
    def on_tick(self, now_ns: int, command: CommandWords) -> None:
        """Compare the count with the target while the encoder bit is set (reading A-52).

        During a request for configuration mode, the bit has another meaning, and the count is still compared.
        """
        self.on_counts(now_ns, command)

    @override
    def counts_from_ns(self, now_ns: int, turns_ns: int | None) -> int | None:
        """Request the counts of every scan while the encoder is turned by hand."""
        return None if turns_ns is None or self.stopping else now_ns

    @override
    def on_counts(self, now_ns: int, command: CommandWords) -> None:
        reached = (self.axis.encoder - self.target) * self.direction >= 0
        if reached and (command.configures or command.lsw & ENCODER_MOVE):
            self._stop(now_ns)

    def _stop(self, now_ns: int) -> None:
        if not self.stopping:
            self.stopping = True
            self.axis.stop(now_ns, self.profile.deceleration_spmss, self.profile.shape)

    @override
    def on_hold(self, now_ns: int) -> None:
        """Ignore Hold, or report an error if the option says so [chapter 4; reading A-23]."""
        if self.host.options.hold_error_in_encoder_move:
            super().on_hold(now_ns)

    @override
    def on_external(self, now_ns: int) -> None:
        """Make a controlled stop, which can't be resumed (reading A-49)."""
        if not self.stopping:
            self.stopped_by_input = True
        self._stop(now_ns)

    @override
    def on_end(self, now_ns: int) -> None:
        """Show MOVE_COMPLETE, or STOPPED if the external input ended the move."""
        if self.stopped_by_input:
            self.host.finish(now_ns, STOPPED, "stopped by the external input")
        else:
            self.host.complete(now_ns)
