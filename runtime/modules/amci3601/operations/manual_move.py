"""Manual moves; they run as long as the bit is set [chapter 4, Manual Move]."""

from __future__ import annotations

from typing import ClassVar

from scanrack.io_images.amci3601 import CommandMsw
from typing_extensions import override

from ....kinematics import Profile
from ..amci3601_capabilities import Feature
from ..command_words import CommandWords
from ..latches import STOPPED
from ..operation import Host, Limits, Operation
from ..refusals import speed_or_rates_out_of_range

MANUAL_BIT = {1: CommandMsw.MANUAL_CW.value, -1: CommandMsw.MANUAL_CCW.value}


class ManualMove(Operation):
    """A motion in one direction until the bit is released or another event stops it.

    At a speed up to the starting speed, the motion has no ramps, and its speed can't be changed
    ("constant speed mode").
    """

    name: ClassVar[str] = "manual"
    limits: ClassVar[Limits] = Limits.SAME_DIRECTION

    def __init__(self, host: Host, now_ns: int, direction: int, command: CommandWords) -> None:
        super().__init__(host, now_ns)
        self.direction = direction
        self.profile: Profile = command.profile(host.state.start_sps)
        self.is_constant_speed = self.profile.speed_sps <= self.profile.start_sps
        self.target_words = command.target_words
        self.speed_words = command.speed_words
        self.stopping = False

    def start(self, now_ns: int) -> None:
        """Start the axis; if the external input is active, make a single step [chapter 6]."""
        if self.state.external_active:
            self.stopping = True
            speed = min(self.profile.speed_sps, self.profile.start_sps)
            self.axis.step_slowly(now_ns, self.direction, speed)
        else:
            self.axis.run(now_ns, self.direction, self.profile)

    @override
    def on_words(self, now_ns: int, command: CommandWords) -> None:
        """Stop if the bit has been released; otherwise check target and speed."""
        if self.stopping:
            return
        if not command.msw & MANUAL_BIT[self.direction]:
            if self.host.firmware.registration is False and not any(command.words):
                self.host.fire(now_ns, "CMD-14")
            self._stop(now_ns)
        elif not self.state.locked:
            self._check_changes(now_ns, command)

    def _check_changes(self, now_ns: int, command: CommandWords) -> None:
        """Refuse a changed target; obey a changed speed."""
        if command.target_words != self.target_words and self.host.firmware.registration:
            self.target_words = command.target_words
            self._fault(now_ns, "CMD-25")
        elif command.speed_words != self.speed_words:
            self.speed_words = command.speed_words
            self._change_speed(now_ns, command)

    def _change_speed(self, now_ns: int, command: CommandWords) -> None:
        """Obey the speed and rates in the words; if the motion can't change to them, report it and stop."""
        if self.is_constant_speed:
            self.host.fire(now_ns, "CMD-13")
            self.stopping = True
            self.axis.cut(now_ns)  # no ramp up to the starting speed (reading A-42)
        elif speed_or_rates_out_of_range(self.host, command):
            self.host.fire(now_ns, "CMD-15")
            self._stop(now_ns)
        elif self.host.refuse_if_unable(now_ns, Feature.SPEED_CHANGE, command):
            self._stop(now_ns)
        else:
            self.profile = command.profile(self.state.start_sps)
            self.axis.change_speed(now_ns, self.profile)

    def _fault(self, now_ns: int, rule_id: str) -> None:
        """Show a fault in the words of a registration move, and stop (reading A-56)."""
        self.host.fire(now_ns, rule_id)
        if self.host.options.registration_fault_cuts:
            self.stopping = True
            self.axis.cut(now_ns)
        else:
            self._stop(now_ns)

    def _stop(self, now_ns: int) -> None:
        if not self.stopping:
            self.stopping = True
            self.axis.stop(now_ns, max(1, self.profile.deceleration_spmss), self.profile.shape)

    @override
    def on_hold(self, now_ns: int) -> None:
        """Show an error, and stop [chapter 4, Hold Move; reading A-26]."""
        super().on_hold(now_ns)
        self._stop(now_ns)

    @override
    def on_many_bits(self, now_ns: int) -> None:
        """Make a controlled stop (reading A-33)."""
        self._stop(now_ns)

    @override
    def on_external(self, now_ns: int) -> None:
        """Make a controlled stop [chapter 6, External Input]."""
        self._stop(now_ns)

    @override
    def on_release(self, now_ns: int) -> None:
        """Make a controlled stop, because the bit counts as reset (reading A-10)."""
        self._stop(now_ns)

    @override
    def on_end(self, now_ns: int) -> None:
        """Show STOPPED [chapter 6, The Stopped Bit 1]."""
        self.host.finish(now_ns, STOPPED, "stopped")


class OneShot(Operation):
    """A manual move at speed 0, which outputs one pulse. The direction is shown until the bit is released."""

    name: ClassVar[str] = "one-shot manual"
    limits: ClassVar[Limits] = Limits.OWN

    def __init__(self, host: Host, now_ns: int, direction: int) -> None:
        super().__init__(host, now_ns)
        self.direction = direction
        self.shown_direction = direction
        self.released = False

    def start(self, now_ns: int) -> None:
        """Output the pulse."""
        self.axis.pulse(now_ns, self.direction)

    @property
    @override
    def busy(self) -> bool:
        """Always False, because the pulse ends at once and never prevents a move."""
        return False

    @property
    @override
    def over(self) -> bool:
        """Whether the bit has been released."""
        return self.released

    @override
    def next_wake_ns(self, now_ns: int) -> int | None:
        """Return one instant after the pulse, because its step may have operated a switch; then None."""
        return now_ns + 1 if now_ns == self.started_ns else None

    @override
    def on_words(self, now_ns: int, command: CommandWords) -> None:
        self.released = not command.msw & MANUAL_BIT[self.direction]

    @override
    def on_release(self, now_ns: int) -> None:
        self.released = True

    @override
    def on_end(self, now_ns: int) -> None:
        """End a one-shot without setting STOPPED [chapter 4, Manual Move]."""
        self.host.finish(now_ns, 0, "made its pulse")
