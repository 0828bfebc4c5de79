"""A step generator with rates and speeds that are off by a factor."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from typing_extensions import override

from ...kinematics import AnyShape, Profile, Rate
from .step_generator import StepGenerator

_AS_PROGRAMMED = Fraction(1)


@dataclass(frozen=True, slots=True)
class AxisScales:
    """Factors, above 0, that are applied to the programmed speeds and rates of command words.

    They do not apply to the starting speed or to blend profiles.
    """

    acceleration: Fraction = _AS_PROGRAMMED
    deceleration: Fraction = _AS_PROGRAMMED
    speed: Fraction = _AS_PROGRAMMED

    def sps(self, speed_sps: int) -> int:
        """Return the axis's speed for a programmed speed, 1 step/s or more."""
        return max(1, round(speed_sps * self.speed))

    def profile(self, programmed: Profile) -> Profile:
        """Return the axis's profile for a programmed profile."""
        return replace(
            programmed,
            speed_sps=self.sps(programmed.speed_sps),
            acceleration_spmss=programmed.acceleration_spmss * self.acceleration,
            deceleration_spmss=programmed.deceleration_spmss * self.deceleration,
        )


class ScaledGenerator(StepGenerator):
    """A step generator with factors; see `StepGenerator` for the other arguments."""

    def __init__(self, scales: AxisScales, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._scales = scales

    @override
    def move(self, now_ns: int, distance: int, profile: Profile) -> None:
        super().move(now_ns, distance, self._scales.profile(profile))

    @override
    def run(self, now_ns: int, direction: int, profile: Profile, registration: int | None = None) -> None:
        super().run(now_ns, direction, self._scales.profile(profile), registration)

    @override
    def change_speed(self, now_ns: int, profile: Profile) -> None:
        super().change_speed(now_ns, self._scales.profile(profile))

    @override
    def register(self, now_ns: int, steps: int, deceleration_spmss: Rate, shape: AnyShape) -> None:
        super().register(now_ns, steps, deceleration_spmss * self._scales.deceleration, shape)

    @override
    def stop(self, now_ns: int, deceleration_spmss: Rate, shape: AnyShape) -> None:
        super().stop(now_ns, deceleration_spmss * self._scales.deceleration, shape)

    @override
    def steps_to_stop(self, now_ns: int, deceleration_spmss: Rate, shape: AnyShape) -> int:
        return super().steps_to_stop(now_ns, deceleration_spmss * self._scales.deceleration, shape)
