"""Absolute and relative moves: they cover a fixed distance and allow Hold and Resume [chapter 4]."""

from __future__ import annotations

from typing_extensions import override

from ....kinematics import Profile
from ..amci3601_capabilities import Feature
from ..latches import HOLD_STATE
from ..operation import Host, Operation
from ..state import HeldMove


class ProfileMove(Operation):
    """A move to `target` with a profile; it ends with MOVE_COMPLETE, or with HOLD_STATE if held."""

    def __init__(self, host: Host, now_ns: int, name: str, target: int, profile: Profile) -> None:
        super().__init__(host, now_ns)
        self.name = name  # type: ignore[misc]  # two commands share the class
        self.target = target
        self.profile = profile
        self.holding = False  # whether the move ends in the hold state
        self.by_external = False  # whether the external input holds it, instead of the command
        self.single_step = False
        self.resumable = True

    def start(self, now_ns: int) -> None:
        """Start the axis; if the external input is active, make a single step [chapter 4]."""
        distance = self.target - self.axis.position
        if distance == 0:
            return
        if self.state.external_active:
            self.holding = self.by_external = self.single_step = True
            self.axis.step_slowly(now_ns, 1 if distance > 0 else -1, self.profile.start_sps)
        else:
            self.axis.move(now_ns, distance, self.profile)

    @override
    def on_hold(self, now_ns: int) -> None:
        """Ramp down into the hold state, unless the axis is already stopping."""
        if not self.host.refuse_if_unable(now_ns, Feature.HOLD, self.state.command):
            self._hold(now_ns)

    @override
    def on_forfeit(self) -> None:
        """Prevent Resume, because a command arrived after Hold while the axis was still ramping down."""
        self.resumable = False

    @override
    def on_external(self, now_ns: int) -> None:
        """Hold the move like the Hold command [chapter 6, External Input]."""
        if self._hold(now_ns):
            self.by_external = True

    def _hold(self, now_ns: int) -> bool:
        """Ramp down into the hold state; return False if the axis is already stopping."""
        axis, profile = self.axis, self.profile
        if self.holding or axis.ramp < 0:
            return False
        steps_left = abs(self.target - axis.position)
        if axis.steps_to_stop(now_ns, profile.deceleration_spmss, profile.shape) >= steps_left:
            return False  # the ramp ends at the target, so the move completes
        self.holding = self.resumable = True
        axis.stop(now_ns, profile.deceleration_spmss, profile.shape)
        return True

    @override
    def on_end(self, now_ns: int) -> None:
        """Show MOVE_COMPLETE, or show HOLD_STATE and keep the target for Resume."""
        if self.holding and (self.single_step or self.axis.position != self.target):
            self.host.finish(now_ns, HOLD_STATE, "held")
            held_move = HeldMove(self.target, self.name) if self.resumable else None
            self.state.hold(held_move, by_external=self.by_external)
        else:
            self.host.complete(now_ns)
