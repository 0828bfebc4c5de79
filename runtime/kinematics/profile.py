"""The profile of a move: the parameters of the command words, in the module's units."""

from __future__ import annotations

from scanrack.io_images.dataclass import dataclass

from .shape import AnyShape, Rate, Shape


@dataclass(frozen=True, slots=True)
class Profile:
    """Speeds, rates and shape of a move [chapter 2].

    If the programmed speed does not exceed the starting speed, the whole move runs at the programmed speed,
    and the rates are ignored [chapter 4, Manual Move].

    Raises:
        ValueError: a value is too low. The module checks the upper limits.
    """

    start_sps: int  # starting speed in steps/s, from 1
    speed_sps: int  # programmed speed in steps/s, from 1
    acceleration_spmss: Rate  # in steps/ms/s, above 0 if the speed exceeds the starting speed
    deceleration_spmss: Rate  # in steps/ms/s, above 0 if the speed exceeds the starting speed
    shape: AnyShape = Shape.CONSTANT

    def __post_init__(self) -> None:
        if self.start_sps < 1 or self.speed_sps < 1:
            raise ValueError(f"speeds {self.start_sps} and {self.speed_sps} steps/s: must be 1 or more")
        rates = self.acceleration_spmss, self.deceleration_spmss
        if self.has_ramps and min(rates) <= 0:
            raise ValueError(f"rates {rates[0]} and {rates[1]} steps/ms/s: must be more than 0")

    @property
    def has_ramps(self) -> bool:
        """Whether the programmed speed exceeds the starting speed."""
        return self.speed_sps > self.start_sps

    @property
    def base_sps(self) -> int:
        """Speed in steps/s at which a move begins and ends."""
        return min(self.start_sps, self.speed_sps)
