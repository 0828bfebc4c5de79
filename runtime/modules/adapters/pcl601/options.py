"""Options of the PCL601 adapter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ....loop.events import JsonValue
from ..options import check_choices, check_names

CHOICES: dict[str, tuple[str | bool, ...]] = {
    "strict": (False, True),
    "blend": ("refuse", "segmented"),
    "capture": ("polled", "reject"),
    "diagnostic": ("reject", "mirror"),
    "limit_sense": ("hard_limits", "inputs"),
    "proximity": ("reject", "jumper"),
    "registration": ("default", "jumper", "polled"),
    "encoder_move": ("refuse", "polled"),
    "respeed": ("refuse", "restart"),
    "takeover": (False, True),
}


@dataclass(frozen=True, slots=True)
class Pcl601Options:
    """What is substituted and how the controller is wired.

    Attributes:
        strict: refuse what is done with a slower ramp than programmed.
        blend: "segmented" runs the segments of a blend move one by one, with a stop in between; else
            refused.
        capture: "polled", within a poll period of the edge, or "reject".
        diagnostic: "mirror" copies the position to the diagnostic words, "reject" refuses them.
        limit_sense: "inputs": the end limits are wired to inputs 1 and 5, too; else to the hard limits only.
        proximity: "jumper": output 6 is wired to both soft limits, and is the backplane home proximity;
            else that is refused.
        registration: "jumper": input 2 is wired to output 7 alone; "polled": to nothing, and a registration
            move stops when its input has been read, and goes on by the steps that are left; else it is
            wired to output 7 and the external input.
        encoder_move: "polled" ends an encoder move when the count has been read; else refused.
        respeed: "restart" changes the speed of a manual move by stopping in between; else refused.
        takeover: a controller that was found running a program of its own does not start it again at
            power-up: its autorun flag, which is non-volatile, is cleared.

    Raises:
        ValueError: a value that is not allowed.
    """

    strict: bool = False
    blend: str = "refuse"
    capture: str = "polled"
    diagnostic: str = "reject"
    limit_sense: str = "hard_limits"
    proximity: str = "reject"
    registration: str = "default"
    encoder_move: str = "refuse"
    respeed: str = "refuse"
    takeover: bool = False

    def __post_init__(self) -> None:
        check_choices(self, CHOICES)

    @classmethod
    def of(cls, given: Mapping[str, JsonValue] | None) -> Pcl601Options:
        """Make options from names and values.

        Raises:
            ValueError: an unknown name, or a value that is not allowed.
        """
        check_names(cls, given or {}, "PCL601 adapter")
        return cls(**(given or {}))  # type: ignore[arg-type]  # checked in __post_init__
