"""The machine that a module is bolted to: what it is made of, and what it does."""

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
