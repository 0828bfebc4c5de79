"""Options of the PMC006 adapter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ....io_images.pmc006.instructions import INT32_MAX
from ...events import JsonValue
from ..options import check_choices, check_names

CHOICES: dict[str, tuple[str | bool, ...]] = {
    "strict": (False, True),
    "blend": ("refuse", "segmented"),
    "capture": ("reject", "fset"),
    "registration": ("refuse", "polled"),
    "accel_rounding": ("gentler", "nearest"),
    "hold": ("refuse", "immediate"),
    "diagnostic": ("reject", "mirror"),
}


@dataclass(frozen=True, slots=True)
class Options:
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
    diagnostic: str = "reject"

    def __post_init__(self) -> None:
        check_choices(self, CHOICES)
        stroke = self.home_stroke
        if stroke is not None and (type(stroke) is not int or not 1 <= stroke <= INT32_MAX):
            raise ValueError(f"option home_stroke: {stroke!r} is not allowed: 1 to {INT32_MAX} steps")

    @classmethod
    def of(cls, given: Mapping[str, JsonValue] | None) -> Options:
        """Make options from names and values.

        Raises:
            ValueError: an unknown name, or a value that is not allowed.
        """
        check_names(cls, given or {}, "PMC006 adapter")
        return cls(**(given or {}))  # type: ignore[arg-type]  # checked in __post_init__
