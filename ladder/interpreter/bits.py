"""Bit instructions: contacts, coils, one-shots."""

from __future__ import annotations

from ..operands import Place
from .values import Values


class BitInstructions(Values):
    """Contacts, coils and one-shots."""

    def _one_shot(self, power: bool, storage: Place) -> bool:
        passes = power and not self.get(storage)
        self.put(storage, power)
        return passes

    def _xic(self, bit: Place) -> bool:
        return bool(self.get(bit))

    def _xio(self, bit: Place) -> bool:
        return not self.get(bit)

    def _ote(self, power: bool, bit: Place) -> None:
        self.put(bit, power)

    def _otl(self, bit: Place) -> None:
        self.put(bit, True)

    def _otu(self, bit: Place) -> None:
        self.put(bit, False)

    def _osr(self, power: bool, storage: Place, output: Place) -> None:
        before = self.get(storage)
        self.put(storage, power)
        self.put(output, power and not before)

    def _osf(self, power: bool, storage: Place, output: Place) -> None:
        before = self.get(storage)
        self.put(storage, power)
        self.put(output, bool(before) and not power)
