"""Times at which the link to a module was lost: its Module light is off [chapter 1, Front Panel]."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from scanrack.io_images.dataclass import dataclass
from scanrack.runtime.modules.amci3601.indicators import Light

if TYPE_CHECKING:  # a run reads no recording
    from scanrack.traces.read.reader import TraceEvent

INDICATORS = "/indicators"
"""The topic of the lights."""


@dataclass(frozen=True, slots=True)
class LinkChange:
    """A link that is lost or restored."""

    scan: int  # number of the first scan that sees it
    now_ns: int
    good: bool  # the PLC reaches the module from then on


def link_changes(events: Iterable[TraceEvent], slot: int) -> list[LinkChange]:
    """Return the changes of the link to a module, in order; every change of its lights repeats it."""
    return [
        LinkChange(each.scan, each.now_ns, each.fields.get("module") != Light.OFF.value)
        for each in events
        if each.topic == INDICATORS and each.fields.get("slot") == slot
    ]
