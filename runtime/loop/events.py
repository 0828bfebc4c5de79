"""Events from a module, the CPU or the machine, in addition to the images.

Events appear in the trace, the final summary and the log. They have no effect on the rack.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field

from scanrack.io_images.dataclass import dataclass

JsonValue = str | int | float | bool | None | list[int] | list[str] | Mapping[str, str | int | float | bool]


@dataclass(frozen=True, slots=True)
class Event:
    """One event.

    Attributes:
        kind: "rule" (a rule of the manual fired), "move" (a motion began or ended), "stimulus" (the machine's
            timeline acted), "indicator" (an LED changed), "format" (a configuration changed the format of
            numbers), "refusal" (an axis lacks a function), "substitution" (an axis achieves the same result
            by other means), "adapter" (a link or controller failed).
        name: the rule's id, the move's kind or the input's name.
        fields: additional values, by name.
    """

    at_ns: int
    kind: str
    name: str
    text: str
    fields: Mapping[str, JsonValue] = field(default_factory=dict)
