"""Options of the PMC006 adapter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from .....io_images.pmc006.instructions import BY_NAME, Instruction
from ....loop.events import JsonValue
from ..options import check_choices, check_names

CHOICES: dict[str, tuple[str | bool, ...]] = {
    "strict": (False, True),
    "blend": ("refuse", "segmented"),
    "capture": ("reject", "fset"),
    "registration": ("refuse", "polled"),
    "accel_rounding": ("gentler", "nearest"),
    "hold": ("refuse", "immediate"),
    "respeed": ("refuse", "restart"),
    "diagnostic": ("reject", "mirror"),
}


def check_range(name: str, value: object, row: Instruction) -> None:
    """Refuse a number that an instruction does not take; None is none.

    Raises:
        ValueError: such a value, with what is allowed.
    """
    if value is not None and (type(value) is not int or not row.allows(value)):
        raise ValueError(f"option {name}: {value!r} is not allowed: {row.allowed} {row.unit}")


@dataclass(frozen=True, slots=True)
class Pmc006Options:
    """What is substituted and how the controller is wired.

    Attributes:
        home_stroke: how far Find Home may go, steps; a configuration is refused without it.
        strict: refuse what is done with a slower ramp, or one of another shape, than programmed.
        blend: "segmented" runs the segments of a blend move one by one, with a stop in between; else
            refused.
        capture: "fset": the capture input is wired to FSET; else it is refused.
        registration: "polled" stops a registration move when its input has been read, and goes on by the
            steps that are left; else refused.
        accel_rounding: "nearest" takes the nearest rate of the table, which may be a steeper one.
        hold: "immediate" holds a move without a ramp, and allows the external input on FSET; else refused.
        respeed: "restart" changes the speed of a manual move by stopping in between; else refused.
        peak_current: phase current of the motor, mA; without it the one saved in the controller holds.
        diagnostic: "mirror" copies the position to the diagnostic words, "reject" refuses them.

    Raises:
        ValueError: a value that is not allowed.
    """

    home_stroke: int | None = None
    strict: bool = False
    blend: str = "refuse"
    capture: str = "reject"
    registration: str = "refuse"
    accel_rounding: str = "gentler"
    hold: str = "refuse"
    respeed: str = "refuse"
    peak_current: int | None = None
    diagnostic: str = "reject"

    def __post_init__(self) -> None:
        check_choices(self, CHOICES)
        check_range("home_stroke", self.home_stroke, BY_NAME["zero_back"])
        check_range("peak_current", self.peak_current, BY_NAME["peak_current"])

    @classmethod
    def of(cls, given: Mapping[str, JsonValue] | None) -> Pmc006Options:
        """Make options from names and values.

        Raises:
            ValueError: an unknown name, or a value that is not allowed.
        """
        check_names(cls, given or {}, "PMC006 adapter")
        return cls(**(given or {}))  # type: ignore[arg-type]  # checked in __post_init__
