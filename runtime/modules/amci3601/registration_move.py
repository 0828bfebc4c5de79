"""Registration moves: a manual move that ends an exact number of steps after its input [chapter 4].

steps made   0 ...... minimum distance ...................... end
input        ignored                  | its level counts
motion       up to speed, constant    | constant    | down
|<- target words ---->|
^ bit released, or external input active
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, ClassVar

from .capabilities import Feature
from .command_words import CommandWords
from .manual_move import MANUAL_BIT, ManualMove
from .refusals import speed_or_rates_out_of_range

if TYPE_CHECKING:
    from .command_layer import CommandLayer


class RegistrationMove(ManualMove):
    """A manual move with a positive target; the registration input ends it."""

    name: ClassVar[str] = "registration"

    def __init__(self, layer: CommandLayer, now_ns: int, direction: int, order: CommandWords) -> None:
        super().__init__(layer, now_ns, direction, order)
        distance = order.parameters.target
        assert distance is not None
        self.distance = distance
        self.rates = order.words[6:8]
        self.registered = False

    def start(self, now_ns: int) -> None:
        """Set the axis going, and have it looked at when the minimum distance is exceeded."""
        self.layer.axis.run(now_ns, self.direction, self.profile, self.distance)
        self.layer.axis.watch_steps(self.layer.minimum_registration + 1)

    def on_order(self, now_ns: int, order: CommandWords) -> None:
        """Compare the words; a changed target counts even in the image that releases the bit.

        Below the minimum distance the released bit is ignored, so that changes of speed go on to count.
        """
        if self.stopping or self.layer.locked:
            return
        if order.target_words != self.target_words:
            self._fault(now_ns, "CMD-26")
        elif order.speed_words != self.speed_words and not self.registered:
            self.speed_words = order.speed_words
            if order.msw & MANUAL_BIT[self.direction] or self._below_minimum:
                self._change_speed(now_ns, order)

    def _change_speed(self, now_ns: int, order: CommandWords) -> None:
        """Only a lower speed at unchanged rates is allowed [chapter 6, Command Errors 27 and 28]."""
        speed = order.parameters.speed
        if speed is not None and speed > self.profile.speed_sps:
            self._fault(now_ns, "CMD-27")
        elif order.words[6:8] != self.rates:
            self._fault(now_ns, "CMD-28")
        elif self.constant or speed_or_rates_out_of_range(self.layer, order):
            super()._change_speed(now_ns, order)
        elif self.layer.unable(now_ns, Feature.SPEED_CHANGE, order):
            self._stop(now_ns)
        else:
            assert speed is not None
            self.profile = replace(self.profile, speed_sps=speed)  # shape and rates stay
            self.layer.axis.change_speed(now_ns, self.profile)

    def on_tick(self, now_ns: int, order: CommandWords) -> None:
        """Look at the level of the registration input, once the minimum distance is exceeded."""
        released = order.configures or not order.msw & MANUAL_BIT[self.direction]
        if released or self.layer.external_active:
            self._register(now_ns)

    def _register(self, now_ns: int) -> None:
        if self.stopping or self.registered or self._below_minimum:
            return
        self.registered = True
        profile = self.profile
        self.layer.axis.register(now_ns, self.distance, max(1, profile.deceleration_spmss), profile.shape)

    @property
    def _below_minimum(self) -> bool:
        """Whether the registration input is still ignored."""
        made, least = abs(self.layer.axis.position - self.started_at), self.layer.minimum_registration
        return least > 0 and made <= least

    def on_hold(self, now_ns: int) -> None:
        """An error; before the registration input it also stops the motion (reading A-54)."""
        if self.registered:
            self.layer.fire(now_ns, "CMD-07")
        else:
            self.layer.fire(now_ns, "CMD-21")
            self._stop(now_ns)

    def on_external(self, now_ns: int) -> None:
        """The external input is the registration input; `on_tick` looks at it."""

    def on_release(self, now_ns: int) -> None:
        """The bit counts as reset; `on_tick` looks at it."""
