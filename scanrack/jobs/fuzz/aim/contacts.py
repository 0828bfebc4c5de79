"""Draws buttons and failing sensors. Contacts to which the program reacts are drawn more often."""

from __future__ import annotations

from collections.abc import Collection
from random import Random

from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.modules.record import Trait

from ..scenarios.kinds import Kind, buttons, card_buttons, sensors
from ..scenarios.scenario import ContactPress, Press

Contact = Press | ContactPress
"""A contact as a part of a scenario. Its time is ignored."""

BUTTON, SENSOR, REACTION = 2, 1, 6
"""Weights of a button and of each sensor level, and the extra weight of a contact with a reaction."""


class Contacts:
    """The contacts of a rack with their weights; false if empty."""

    def __init__(self, spec: RackSpec, kinds: Collection[Kind]) -> None:
        """Add the contacts of machines and cards with their weights; add none if inputs must not be drawn."""
        self._weights: dict[Contact, int] = {}
        self._chosen: list[Contact] = []
        if Kind.INPUTS not in kinds:
            return
        for slot in spec.slot:
            if slot.has(Trait.MACHINE):
                for bit in buttons(slot):  # releasing a button that is not pressed changes nothing
                    self._weights[Press(slot.number, bit, True, 0, 0)] = BUTTON
                for bit in sensors(slot):  # a sensor sticks on or off
                    for level in (True, False):
                        self._weights[Press(slot.number, bit, level, 0, 0)] = SENSOR
        for number, name in card_buttons(spec):
            self._weights[ContactPress(number, name, 0, 0)] = BUTTON

    def __bool__(self) -> bool:
        return bool(self._weights)

    @property
    def operated(self) -> list[Contact]:
        """The buttons and switches that a person operates."""
        return [contact for contact, weight in self._weights.items() if weight != SENSOR]

    def prefer(self, contact: Contact) -> None:
        """Record that the program reacts to this contact."""
        self._weights[contact] = BUTTON + REACTION

    def draw(self, random: Random) -> Contact:
        """Return a random contact from the few that `narrow` has chosen."""
        return random.choice(self._chosen) if self._chosen else self._random_contacts(random, 1)[0]

    def narrow(self, random: Random, count: int) -> None:
        """Limit later draws to `count` random contacts (0 = all contacts)."""
        self._chosen = self._random_contacts(random, count) if self else []

    def _random_contacts(self, random: Random, count: int) -> list[Contact]:
        """Return random contacts by weight."""
        return random.choices(list(self._weights), list(self._weights.values()), k=count)
