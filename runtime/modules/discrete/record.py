"""The discrete card as the registry knows it."""

from __future__ import annotations

from ....io_images.image import Image
from ....io_images.module_words import ModuleWords
from ...loop.module import Module
from ...machine import MachineSpec
from ..record import ModuleRecord, Options
from .options import DiscreteOptions


class CardView:
    """A card's inputs by name.

    >>> from scanrack.io_images import Image
    >>> view = CardView(Image([0b10]), DiscreteOptions(inputs={"start": 0, "stop": 1}).words)
    >>> view["start"], view["stop"], str(view)
    (False, True, 'stop')
    """

    def __init__(self, inputs: Image, words: ModuleWords) -> None:
        self._inputs = inputs
        self._bits = dict(words.bits("I", 0))

    def __getitem__(self, name: str) -> bool:
        return self._inputs.bit(0, self._bits[name])

    def __str__(self) -> str:
        return " ".join(name for name in self._bits if self[name]) or "no input"


def make(firmware: str, machine: MachineSpec, seed: int, options: Options, wiring: str | None) -> Module:
    """Make a card; it has neither machine nor wiring nor firmware, and nothing is left to chance.

    Raises:
        ValueError: an option, or a machine or wiring.
    """
    from .module import DiscreteCard

    if machine != MachineSpec():
        raise ValueError("machine: a discrete card is bolted to none; its inputs are wired in its options")
    if wiring is not None:
        raise ValueError(f"wiring {wiring}: a discrete card has none; leave it out")
    return DiscreteCard(DiscreteOptions.of(options))


RECORD = ModuleRecord(
    name="discrete16",
    make=make,
    words=lambda options: DiscreteOptions.of(options).words,
    has_firmware=False,
    status=CardView,
)
