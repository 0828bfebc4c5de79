"""Names in a `Logic` class: addresses of its inputs and outputs, and waits of its sequences."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

from scanrack.io_images.module_words import ModuleWords
from scanrack.ladder.python.axis3601 import Axis3601
from scanrack.ladder.python.sequences import Logic, fresh, parts_of, sequences_of
from scanrack.ladder.python.sequences.signals import Signal
from scanrack.runtime.loop.scan import ScanLogic

from ...load.bare_slots import bare_slots


class Names:
    """The names of a program; empty if it is not a `Logic` class.

    Args:
        logic: the program; a new instance is attached to slots without modules.
        words: names of the words of the slots.

    Attributes:
        addresses: the addresses of inputs and outputs, by name.
        axes: the slots of axes, by name.
        sequences: the names of the sequences.
        prefix: the class's name at the start of a full name, such as `line.` in `line.cycle`.
    """

    def __init__(self, logic: ScanLogic, words: Mapping[int, ModuleWords]) -> None:
        self.addresses: dict[str, str] = {}
        self.axes: dict[str, int] = {}
        self.sequences: tuple[str, ...] = ()
        self.prefix = f"{type(logic).__name__.lower()}."
        if isinstance(logic, Logic):
            new = fresh(logic)
            new.__attach_logic__(bare_slots(words))
            parts = parts_of(new)
            self.addresses = {part.name: str(part.at) for part in parts if isinstance(part, Signal)}
            self.axes = {part.name: part.slot for part in parts if isinstance(part, Axis3601)}
            self.sequences = tuple(sequence.name for sequence in sequences_of(logic))

    def own(self, text: str) -> str:
        """Return a name without the prefix for the class itself: `cycle` for `line.cycle`."""
        return text.removeprefix(self.prefix)

    def declares(self, text: str) -> bool:
        """Return whether a text is the name of an input, an output, an axis or a sequence."""
        return self.own(text) in {**self.addresses, **self.axes, **dict.fromkeys(self.sequences)}

    def named_in(self, wait: str) -> Iterator[str]:
        """Yield each name of an input, output or axis in the condition of a wait, once."""
        signals = {**self.addresses, **self.axes}
        yield from (name for name in dict.fromkeys(re.findall(r"\w+", wait)) if name in signals)
