"""Registration moves: manual moves that end an exact number of steps after an input [chapter 4].

steps made   0 ...... minimum distance ...................... end
input        ignored                  | its level counts
motion       up to speed, constant    | constant    | constant, down
                                                    |<- target ---->|
                                                    ^ bit released, or external input active
"""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar

from typing_extensions import override

from ..amci3601_capabilities import Feature
from ..command_words import CommandWords
from ..operation import Host
from ..refusals import speed_or_rates_out_of_range
from .manual_move import MANUAL_BIT, ManualMove


class RegistrationMove(ManualMove):
    """A manual move with a positive target, which is the distance after the registration input."""

    name: ClassVar[str] = "registration"

    def __init__(self, host: Host, now_ns: int, direction: int, command: CommandWords) -> None:
        super().__init__(host, now_ns, direction, command)
        distance = command.parameters.target
        assert distance is not None
        self.distance = distance
        self.rates = command.words[6:8]
        self.registered = False

    @override
    def start(self, now_ns: int) -> None:
        """Start the axis, and watch for the end of the minimum distance."""
        self.axis.run(now_ns, self.direction, self.profile, self.distance)
        self.axis.watch_steps(self.state.minimum_registration + 1)

    @override
    def on_words(self, now_ns: int, command: CommandWords) -> None:
        """Compare the words; a changed target is a fault even if the same image releases the bit.

        Before the minimum distance, release of the bit is ignored, and the speed can still change.
        """
        if self.stopping or self.state.locked:
            return
        if command.target_words != self.target_words:
            self._fault(now_ns, "CMD-26")
        elif command.speed_words != self.speed_words and not self.registered:
            self.speed_words = command.speed_words
            if command.msw & MANUAL_BIT[self.direction] or self._below_minimum:
                self._change_speed(now_ns, command)

    @override
    def _change_speed(self, now_ns: int, command: CommandWords) -> None:
        """Change to a lower speed; other changes are faults [chapter 6, Command Errors 27 and 28]."""
        speed = command.parameters.speed
        if speed is not None and speed > self.profile.speed_sps:
            self._fault(now_ns, "CMD-27")
        elif command.words[6:8] != self.rates:
            self._fault(now_ns, "CMD-28")
        elif self.is_constant_speed or speed_or_rates_out_of_range(self.host, command):
            super()._change_speed(now_ns, command)
        elif self.host.refuse_if_unable(now_ns, Feature.SPEED_CHANGE, command):
            self._stop(now_ns)
        else:
            assert speed is not None
            self.profile = replace(self.profile, speed_sps=speed)  # with the same shape and rates
            self.axis.change_speed(now_ns, self.profile)

    @override
    def on_tick(self, now_ns: int, command: CommandWords) -> None:
        """Check the levels of the bit and the registration input."""
        released = command.configures or not command.msw & MANUAL_BIT[self.direction]
        if released or self.state.external_active:
            self._register(now_ns)

    def _register(self, now_ns: int) -> None:
        """Plan the exact end of the move, once and only after the minimum distance."""
        if self.stopping or self.registered or self._below_minimum:
            return
        self.registered = True
        profile = self.profile
        self.axis.register(now_ns, self.distance, max(1, profile.deceleration_spmss), profile.shape)

    @property
    def _below_minimum(self) -> bool:
        """Whether the registration input is still ignored."""
        steps_made = abs(self.axis.position - self.started_at)
        minimum_steps = self.state.minimum_registration
        return minimum_steps > 0 and steps_made <= minimum_steps

    @override
    def on_hold(self, now_ns: int) -> None:
        """Show an error; stop if the registration input has not been seen yet (reading A-54)."""
        if self.registered:
            self.host.fire(now_ns, "CMD-07")
        else:
            self.host.fire(now_ns, "CMD-21")
            self._stop(now_ns)

    @override
    def on_external(self, now_ns: int) -> None:
        """Do nothing, because `on_tick` checks the external input as the registration input."""

    @override
    def on_release(self, now_ns: int) -> None:
        """Do nothing, because `on_tick` checks the bit."""
