"""The input pins of a PMC006x3s, each at a fixed level or wired to a switch that the motor operates."""

from __future__ import annotations

from collections.abc import Callable
from enum import IntFlag

from ...machine.contacts import Contact, nearest_edge


class Pin(IntFlag):
    """The input pins, as a mask of the pins that are high. EXT1, EXT2 and FSET have the bits of `Level`."""

    EXT2 = 1 << 0
    EXT1 = 1 << 2
    FSET = 1 << 3
    """GPI1 in user programs (interpretation)."""
    GPI2 = 1 << 4
    """Pin GPI09; GPI2 in user programs (interpretation)."""


class Pmc006Pins:
    """The pins, initially all high, since no optocoupler conducts [3.11].

    Attributes:
        levels: mask of the pins that are high, as of the last `sense`.
        on_change: called after a change, with a mask of the changed pins and a mask of the high pins.
    """

    def __init__(self) -> None:
        self._inputs: dict[Pin, bool | Contact] = dict.fromkeys(Pin, True)
        self._fixed_levels = sum(Pin)  # mask of the pins with a fixed high level
        self._switches: dict[Pin, Contact] = {}
        self.levels = sum(Pin)
        self.on_change: Callable[[int, int], None] | None = None

    def hold(self, pin: Pin, level: bool | Contact) -> None:
        """Set a pin high or low, or connect a switch, which pulls it low; `sense` reports the change."""
        self._inputs[pin] = level
        self._fixed_levels = sum(pin for pin, level in self._inputs.items() if level is True)
        self._switches = {pin: level for pin, level in self._inputs.items() if isinstance(level, Contact)}

    def sense(self, position: int) -> None:
        """Update the levels for the motor's position, and report changes."""
        levels = self._fixed_levels
        for pin, switch in self._switches.items():
            if not switch.closed(position):
                levels += pin
        changed_levels, self.levels = levels ^ self.levels, levels
        if changed_levels and self.on_change is not None:
            self.on_change(changed_levels, levels)

    def next_change(self, position: int, direction: int) -> int | None:
        """Return the next position in a direction at which a pin changes, or None."""
        return nearest_edge(self._switches.values(), position, direction)
