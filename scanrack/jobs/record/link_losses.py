"""Finds losses of the link to a module, during which its Module light is off [chapter 1, Front Panel]."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from scanrack.io_images.dataclass import dataclass
from scanrack.runtime.modules.amci3601.indicators import Light

if TYPE_CHECKING:  # a run does not read recordings
    from scanrack.traces.read.reader import TraceEvent

INDICATORS = "/indicators"
"""The topic of the module lights."""


@dataclass(frozen=True, slots=True)
class LinkChange:
    """The state of the link when the lights change: lost or good."""

    scan: int  # the first scan in this state
    now_ns: int
    good: bool  # whether the PLC reaches the module from this scan


def link_changes(events: Iterable[TraceEvent], slot: int) -> list[LinkChange]:
    """Return the state of the link to a module each time the module's lights change, in order."""
    return [
        LinkChange(event.scan, event.now_ns, event.fields.get("module") != Light.OFF.value)
        for event in events
        if event.topic == INDICATORS and event.fields.get("slot") == slot
    ]
