"""Forces, which hold words and bits at a value regardless of the module or the logic.

An input force acts between the input latch and the logic, an output force
between the logic and the output latch. Both stay in effect until they are removed. An output force changes
the outputs that are sent and recorded. The logic always sees its own outputs, forced or not, so a removed
force leaves no trace.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from scanrack.io_images.addresses import Address, parse_address
from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.image import UNSIGNED_MAX, WORD_MIN

from .rack import Rack

WORD_MASK = 0xFFFF


@dataclass(slots=True)
class _MaskedWord:
    """A word of an image with forced bits."""

    words: memoryview
    index: int
    keep: int = WORD_MASK  # mask of the bits that are not forced
    forced: int = 0  # values of the forced bits
    logic_value: int | None = None  # of an output word: the logic's value, while the word has the forced one


class Forces:
    """A rack's forces. Changes take effect with the next scan.

    Args:
        on_change: called after every change; the scan loop then calls `commit`.
    """

    def __init__(self, rack: Rack, on_change: Callable[[], None] = lambda: None) -> None:
        self._rack = rack
        self._on_change = on_change
        self._words = {number: slot.words for number, slot in rack.slots.items()}
        self._values: dict[Address, int] = {}
        self._dirty = False
        self._inputs: tuple[_MaskedWord, ...] = ()
        self._outputs: tuple[_MaskedWord, ...] = ()

    @property
    def active(self) -> Mapping[str, int]:
        """The forces by address, latest last. If two forces share a bit, the later one takes precedence."""
        return {str(address): value for address, value in self._values.items()}

    def set(self, address: str, value: int) -> None:
        """Hold a word or bit at a value, from the next scan on.

        Args:
            address: see `io_images.addresses`.
            value: 0 or 1 for a bit, -32,768 to 65,535 for a word.

        Raises:
            ValueError: the address does not exist, or the value does not fit the address.
        """
        target = parse_address(address, self._words)
        check_value(address, target, value)
        self._values.pop(target, None)
        self._values[target] = int(value)
        self._changed()

    def remove(self, address: str) -> None:
        """Release a word or bit from the next scan on.

        Raises:
            ValueError: the address does not exist, or is not forced.
        """
        target = parse_address(address, self._words)
        if target not in self._values:
            raise ValueError(f"{address!r} is not forced; current forces: {', '.join(self.active) or 'none'}")
        del self._values[target]
        self._changed()

    def clear(self) -> None:
        """Release all words and bits from the next scan on."""
        self._values.clear()
        self._changed()

    def commit(self) -> bool:
        """Apply all changes; return whether there were any."""
        if not self._dirty:
            return False
        self._dirty = False
        self.restore_outputs()
        self._inputs = self._masks("I")
        self._outputs = self._masks("O")
        return True

    @property
    def on_inputs(self) -> bool:
        """Whether an input force is in effect."""
        return bool(self._inputs)

    @property
    def on_outputs(self) -> bool:
        """Whether an output force is in effect."""
        return bool(self._outputs)

    def apply_inputs(self) -> None:
        """Overwrite the input images with the input forces."""
        for masked in self._inputs:
            masked.words[masked.index] = masked.words[masked.index] & masked.keep | masked.forced

    def apply_outputs(self) -> None:
        """Overwrite the output images with the output forces; remember the logic's own words."""
        for masked in self._outputs:
            masked.logic_value = masked.words[masked.index]
            masked.words[masked.index] = masked.logic_value & masked.keep | masked.forced

    def restore_outputs(self) -> None:
        """Restore the logic's own output words."""
        for masked in self._outputs:
            if masked.logic_value is not None:
                masked.words[masked.index], masked.logic_value = masked.logic_value, None

    def _changed(self) -> None:
        self._dirty = True
        self._on_change()

    def _masks(self, image: str) -> tuple[_MaskedWord, ...]:
        """Return the words of all images of a kind, "I" or "O", that have forced bits."""
        masks: dict[tuple[int, int], _MaskedWord] = {}
        for target, value in self._values.items():
            if target.image == image:
                key = target.slot, target.word
                slot = self._rack.slots[target.slot]
                words = (slot.inputs if image == "I" else slot.outputs).raw.cast("H")
                masked = masks.setdefault(key, _MaskedWord(words, target.word))
                _add_force(masked, target.bit, value)
        return tuple(masks.values())


def check_value(address: str, target: Address, value: object) -> None:
    """Raise a ValueError that names the address if a value does not fit a word or bit."""
    kind, lowest, highest = ("word", WORD_MIN, UNSIGNED_MAX) if target.bit is None else ("bit", 0, 1)
    if not isinstance(value, int) or not lowest <= value <= highest:
        raise ValueError(f"{address!r} cannot be forced to {value!r}: a {kind} is {lowest} to {highest}")


def _add_force(masked: _MaskedWord, bit: int | None, value: int) -> None:
    """Add a force on a bit, or on the whole word for None; a later force takes precedence."""
    mask = WORD_MASK if bit is None else 1 << bit
    forced_bits = value & WORD_MASK if bit is None else value << bit
    masked.keep &= ~mask
    masked.forced = masked.forced & ~mask | forced_bits
