"""Contacts that a shaft operates by its position and that are wired to a device's inputs."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from typing_extensions import override

from .spec import Switch

FAR = 1 << 62
"""A position beyond any motor's travel, steps."""


@dataclass(frozen=True, slots=True)
class Contact:
    """A contact to ground that is closed within a range of physical positions.

    >>> limit = Contact(9000)  # from 9000 on
    >>> limit.closed(8999), limit.closed(9000), limit.edge_after(0, +1), limit.edge_after(9500, -1)
    (False, True, 9000, 8999)
    """

    low: int = -FAR  # first position at which it is closed, steps
    high: int = FAR

    def closed(self, position: int) -> bool:
        """Return whether the contact is closed at a position."""
        return self.low <= position <= self.high

    def edge_after(self, position: int, direction: int) -> int | None:
        """Return the next position in a direction at which the contact changes, or None."""
        edges = self.low, self.high + 1
        if direction > 0:
            return min((edge for edge in edges if position < edge < FAR), default=None)
        return max((edge - 1 for edge in edges if -FAR < edge <= position), default=None)


GROUND = Contact()
OPEN = Contact(low=FAR)


def nearest_edge(contacts: Iterable[Contact], position: int, direction: int) -> int | None:
    """Return the next position in a direction at which any contact changes, or None."""
    edges = (contact.edge_after(position, direction) for contact in contacts)
    edges_ahead = [edge for edge in edges if edge is not None]
    return min(edges_ahead, key=lambda edge: abs(edge - position), default=None)


@dataclass(frozen=True, slots=True)
class Parallel(Contact):
    """Contacts in parallel; the circuit is closed while at least one contact is closed."""

    contacts: tuple[Contact, ...] = ()

    @override
    def closed(self, position: int) -> bool:
        return any(contact.closed(position) for contact in self.contacts)

    @override
    def edge_after(self, position: int, direction: int) -> int | None:
        return nearest_edge(self.contacts, position, direction)


def contacts_of(switch: Switch) -> tuple[Contact, ...]:
    """Return the contacts that are closed at the positions where a switch energizes its input."""
    first_step = -FAR if switch.first is None else switch.first
    last_step = FAR if switch.last is None else switch.last
    if switch.normally_closed:
        return Contact(-FAR, first_step - 1), Contact(last_step + 1, FAR)
    return (Contact(first_step, last_step),)
