"""Options of the PCL601 adapter."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import dataclass, fields

from ...events import JsonValue

CHOICES: dict[str, tuple[str | bool, ...]] = {
    "strict": (False, True),
    "capture": ("polled", "reject"),
    "diagnostic": ("reject", "mirror"),
    "registration": ("default", "jumper"),
    "respeed": ("refuse", "restart"),
}


@dataclass(frozen=True, slots=True)
class Options:
    """What is substituted and how the controller is wired.

    Attributes:
        strict: refuse what is done with a slower ramp than programmed.
        capture: "polled", within a poll period of the edge, or "reject".
        diagnostic: "mirror" copies the position to the diagnostic words, "reject" refuses them.
        registration: "jumper": input 2 is wired to output 7 alone; else to the external input, too.
        respeed: "restart" changes the speed of a manual move by stopping in between; else refused.

    Raises:
        ValueError: a value that is not allowed.
    """

    strict: bool = False
    capture: str = "polled"
    diagnostic: str = "reject"
    registration: str = "default"
    respeed: str = "refuse"

    def __post_init__(self) -> None:
        for name, allowed in CHOICES.items():
            value = getattr(self, name)
            if not any(value is each or (value == each and type(value) is type(each)) for each in allowed):
                words = ", ".join(str(each).lower() for each in allowed)
                raise ValueError(f"option {name}: {value!r} is not allowed: {words}")

    @classmethod
    def of(cls, given: Mapping[str, JsonValue] | None) -> Options:
        """Make options from names and values.

        Raises:
            ValueError: an unknown name, or a value that is not allowed.
        """
        names = [field.name for field in fields(cls)]
        for name in given or {}:
            if name not in names:
                near = difflib.get_close_matches(name, names, n=1)
                hint = f"; did you mean {near[0]}?" if near else f"; allowed are {', '.join(names)}"
                raise ValueError(f"option {name}: the PCL601 adapter has no such option{hint}")
        return cls(**(given or {}))  # type: ignore[arg-type]  # checked in __post_init__
