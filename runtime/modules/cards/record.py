"""The registry records of the cards, one for each kind."""

from __future__ import annotations

from functools import partial

from scanrack.io_images.cards import KINDS, CardKind
from scanrack.io_images.image import Image
from scanrack.io_images.module_words import BitPlace, ModuleWords
from scanrack.io_images.site import SettingError

from ...loop.module import Module
from ...machine import MachineSpec
from ..record import ModuleRecord, Options
from .card_options import CardOptions


class CardView:
    """A card's inputs by name.

    >>> from scanrack.io_images import Image
    >>> wired = CardOptions(inputs={"start": 0, "stop": 1})
    >>> view = CardView(Image([0b10]), wired.words(KINDS["1769-IQ16"]))
    >>> view["start"], view["stop"], str(view)
    (False, True, 'stop')

    An analog input returns its word:

    >>> view = CardView(Image([6240]), CardOptions(inputs={"level": 0}).words(KINDS["1769-IF4"]))
    >>> view["level"]
    6240
    """

    def __init__(self, inputs: Image, words: ModuleWords) -> None:
        self._inputs = inputs
        self._bits: dict[str, BitPlace] = dict(words.groups.get("input", {}))
        self._words = {name: index for index, name in enumerate(words.inputs)} if words.profile_words else {}

    def __getitem__(self, name: str) -> bool | int:
        if name in self._words:
            return self._inputs[self._words[name]]
        place = self._bits[name]
        return self._inputs.bit(place.word, place.bit)

    def __str__(self) -> str:
        return " ".join(name for name in self._bits if self[name]) or "no input"


def make(
    kind: CardKind, firmware: str, machine: MachineSpec, seed: int, options: Options, wiring: str | None
) -> Module:
    """Make a card; firmware and seed have no effect.

    Raises:
        ValueError: an invalid option, or a machine or wiring, which cards do not have.
    """
    from .module import GenericCard

    if machine != MachineSpec():
        raise SettingError("machine", f"machine: a {kind.name} has no machine; wire its inputs in options")
    if wiring is not None:
        raise SettingError("wiring", f"wiring {wiring}: a {kind.name} has no wiring option; remove it")
    return GenericCard(CardOptions.of(options), kind)


def _record(kind: CardKind) -> ModuleRecord:
    """Return the record of a kind of card; its functions read the options of a slot."""
    return ModuleRecord(
        name=kind.name,
        make=partial(make, kind),
        words=lambda options: CardOptions.of(options).words(kind),
        status=CardView,
        family=kind.name.partition("-")[0] if "-" in kind.name else "",
        follows=lambda options: CardOptions.of(options).follows,
        switches=lambda options: tuple(
            (cam.slot, cam.switch) for cam in CardOptions.of(options).cam if cam.switch is not None
        ),
        option_table=lambda: CardOptions,
        buttons=lambda options: () if kind.analog else CardOptions.of(options).buttons,
        signals=lambda options: CardOptions.of(options).signals if kind.channels_in else {},
    )


RECORDS = tuple(map(_record, KINDS.values()))
