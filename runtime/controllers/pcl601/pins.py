"""Wiring of the inputs: contacts that the motor's position operates, and a voltage on input 1."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction

from scanrack.io_images.pcl601.terminals import GENERAL_INPUTS, INPUTS

from ...machine.contacts import GROUND, OPEN, Contact, nearest_edge

FULL_SCALE_VOLTS = 5
HIGH_VOLTS = 2
"""Voltage from which input 1 counts as high (not stated); without a pull-up an open input is at 0 V."""


class Pcl601Pins:
    """The fourteen inputs: at the start input 1 is high, all others are open."""

    def __init__(self) -> None:
        self._contacts = dict.fromkeys(INPUTS, OPEN)
        self._volts: Fraction | None = None

    def connect(self, name: str, contact: Contact) -> None:
        """Wire a contact to an input; on input 1 it means 0 V closed, 5 V open."""
        self._contacts[name] = contact
        if name == "in1":
            self._volts = None

    def apply_volts(self, volts: Fraction) -> None:
        """Put a voltage on input 1, 0 to 5."""
        self._contacts["in1"] = GROUND if volts < HIGH_VOLTS else OPEN
        self._volts = volts

    def grounded(self, name: str, position: int) -> bool:
        """Whether an input is grounded with the motor at a position."""
        return self._contacts[name].closed(position)

    def volts(self, position: int) -> Fraction:
        """Return the voltage on input 1."""
        if self._volts is not None:
            return self._volts
        return Fraction(0 if self.grounded("in1", position) else FULL_SCALE_VOLTS)

    def general(self, position: int) -> Iterable[bool]:
        """Return whether inputs 1 to 6 are grounded."""
        return (self.grounded(name, position) for name in GENERAL_INPUTS)

    def next_edge(self, position: int, direction: int) -> int | None:
        """Return the next position, in a direction, at which any input changes, or None."""
        return nearest_edge(self._contacts.values(), position, direction)
