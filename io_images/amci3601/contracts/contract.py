"""One contract of the 3601: a fact about its images that a proof may rely on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from .fact import Fact, Side


@dataclass(frozen=True, slots=True)
class Contract:
    """A fact about the images of a 3601.

    Contracts about two images are true as long as the PLC does not lose its connection to the module in
    between. A lost link freezes the image, and afterwards all changes appear at once.

    Attributes:
        name: a short name for reports, such as "position lost".
        says: the contract in one sentence.
        rules: ids of the rows of `RULES` from which it follows.
        fact: the fact about the images.
        adapters: whether it is also true for images of adapters.
        readings: options of the simulated 3601 that it depends on, with the values that it needs.
    """

    name: str
    says: str
    rules: tuple[str, ...]
    fact: Fact
    adapters: bool = False
    readings: Mapping[str, bool] = field(default_factory=dict)

    @property
    def needs_two_images(self) -> bool:
        """Whether the contract needs a second image: the previous input image, or the output image."""
        return self.fact.images != {Side.NOW}
