"""Wiring of the inputs: contacts that the motor operates by its position, and a voltage on input 1."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction

from scanrack.io_images.pcl601.terminals import GENERAL_INPUTS, INPUTS

from ...machine.contacts import GROUND, OPEN, Contact, nearest_edge

FULL_SCALE_VOLTS = 5
HIGH_VOLTS = 2
"""Lowest voltage at which input 1 is high; the manual does not state it."""


class Pcl601Pins:
    """The fourteen inputs, initially unwired: input 1 is high, all others are open."""

    def __init__(self) -> None:
        self._contacts = dict.fromkeys(INPUTS, OPEN)
        self._volts: Fraction | None = None

    def connect(self, name: str, contact: Contact) -> None:
        """Wire a contact to an input; on input 1, a closed contact applies 0 V and an open contact 5 V."""
        self._contacts[name] = contact
        if name == "in1":
            self._volts = None

    def apply_volts(self, volts: Fraction) -> None:
        """Apply a voltage, 0 to 5 V, to input 1."""
        self._contacts["in1"] = GROUND if volts < HIGH_VOLTS else OPEN
        self._volts = volts

    def grounded(self, name: str, position: int) -> bool:
        """Return whether an input is grounded when the motor is at a position."""
        return self._contacts[name].closed(position)

    def volts(self, position: int) -> Fraction:
        """Return the voltage on input 1 when the motor is at a position."""
        if self._volts is not None:
            return self._volts
        return Fraction(0 if self.grounded("in1", position) else FULL_SCALE_VOLTS)

    def general(self, position: int) -> Iterable[bool]:
        """Return whether each of inputs 1 to 6 is grounded."""
        return (self.grounded(name, position) for name in GENERAL_INPUTS)

    def next_edge(self, position: int, direction: int) -> int | None:
        """Return the next position in a direction at which any input changes, or None."""
        return nearest_edge(self._contacts.values(), position, direction)
