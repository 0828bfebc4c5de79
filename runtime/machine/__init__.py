"""The machine that a module drives: its parts and their behavior.

`spec` is data: switches, encoder, timeline, stations, slips, jams and movements of a master encoder, each
checked when it is created. `Machine` implements their behavior over time: the module reports its motor steps,
and the machine decides how far the shaft follows and which inputs are energized. A module queries the next
event, so no code loops over steps or ticks.
"""

from __future__ import annotations

from .machine import Machine
from .spec import EncoderSpec, Jam, MachineSpec, MasterTurn, Slip, Station, Switch, TimelineEntry, press

__all__ = [
    "EncoderSpec",
    "Jam",
    "Machine",
    "MachineSpec",
    "MasterTurn",
    "Slip",
    "Station",
    "Switch",
    "TimelineEntry",
    "press",
]
