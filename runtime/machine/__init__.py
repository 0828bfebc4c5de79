"""The machine that a module is bolted to: what it is made of, and what it does.

`spec` is data: switches, encoder, timeline, stations, slips and jams, each checked when it is made. `Machine`
is what they do in time: the module tells which motor steps it makes, the machine how far the shaft has
followed and what the inputs are then. It is asked ahead, so that nothing loops over steps or ticks.

It knows events of the loop and the names of a 3601's inputs, and no module.
"""

from __future__ import annotations

from .machine import Machine
from .spec import EncoderSpec, Jam, MachineSpec, Slip, Station, Switch, TimelineEntry, press

__all__ = [
    "EncoderSpec",
    "Jam",
    "Machine",
    "MachineSpec",
    "Slip",
    "Station",
    "Switch",
    "TimelineEntry",
    "press",
]
