"""A panel of a timing chart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from ..format.layout import SlotInfo
from .lanes import Band, Lane
from .marks import Mark

C = TypeVar("C")


@dataclass(frozen=True, slots=True)
class Panel(Generic[C]):
    """The part of a chart for one module, or for the tags of the program."""

    slot: SlotInfo | None  # the module; None for the program
    curves: Sequence[tuple[str, C]]  # names and curves from top to bottom
    ramp: Lane | None  # the ramp state of a 3601; None for a card
    lanes: Sequence[Lane]  # the bits that change, from top to bottom
    steady: Sequence[Lane]  # the bits that do not change
    marks: Sequence[Mark]  # events of the slot; the first panel also has events of the rack
    about: str = ""  # text after the name in its heading
    bands: Sequence[Band] = ()  # steps and texts of the program that change
    unchanged: Sequence[tuple[str, str]] = ()  # tags that do not change, and their values
    fractional: Sequence[str] = ()  # names of the curves whose values have fractions

    @property
    def name(self) -> str:
        """The panel's name in its heading."""
        return "program" if self.slot is None else f"slot {self.slot.number}"
