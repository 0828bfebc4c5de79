"""Wiring of the inputs: contacts that the motor's position operates, and a voltage on input 1."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

from ....io_images.pcl601.terminals import GENERAL_INPUTS, INPUTS

FAR = 1 << 62
"""Beyond any motor's travel, steps."""

FULL_SCALE_VOLTS = 5
HIGH_VOLTS = 2
"""Voltage from which input 1 counts as high (not stated); without a pull-up an open input is at 0 V."""


@dataclass(frozen=True, slots=True)
class Contact:
    """A contact to ground, closed while the physical position lies in a range.

    >>> limit = Contact(9000)  # from 9000 on
    >>> limit.closed(8999), limit.closed(9000), limit.edge_after(0, +1), limit.edge_after(9500, -1)
    (False, True, 9000, 8999)
    """

    low: int = -FAR  # first position at which it is closed, steps
    high: int = FAR

    def closed(self, position: int) -> bool:
        """Whether the input is grounded."""
        return self.low <= position <= self.high

    def edge_after(self, position: int, direction: int) -> int | None:
        """Return the next position, in a direction, at which it changes, or None."""
        if direction > 0:
            edges = [edge for edge in (self.low, self.high + 1) if position < edge < FAR]
            return min(edges, default=None)
        edges = [edge - 1 for edge in (self.low, self.high + 1) if -FAR < edge <= position]
        return max(edges, default=None)


GROUND = Contact()
OPEN = Contact(low=FAR)
"""Open or at a high voltage: all inputs but input 1 have pull-ups."""


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
        edges = (contact.edge_after(position, direction) for contact in self._contacts.values())
        return min(
            (edge for edge in edges if edge is not None),
            key=lambda edge: abs(edge - position),
            default=None,
        )
