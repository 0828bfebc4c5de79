"""Records which words or bits of its input images a program reads.

    status.MOVE_COMPLETE     words[0] & 8080h    two bits: its own, and the mode that gives it meaning
    status.position          words[2], words[3]  whole words
    inputs.bit(0, 14)        words[0] >> 14 & 1  one bit

`WatchedWords` replaces the words of an image; each `WatchedWord` notes the bits that are used.
Reads through the image's 16 bytes (`raw`, `bytes(image)`) are not noticed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import field
from typing import Any

from scanrack.io_images.dataclass import dataclass
from scanrack.runtime.loop.rack import Slot

ALL_BITS = 0xFFFF
_SIGN = 1 << 15


@dataclass(slots=True)
class Reads:
    """The words and bits that a program reads from a rack's input images.

    Attributes:
        masks: the bits used, by slot and word, in the order of the first reads; 0 = the word was only copied.
        on: whether reads are noted.
        counts: returns whether a read is by the user's code.
    """

    masks: dict[tuple[int, int], int] = field(default_factory=dict)
    on: bool = False
    counts: Callable[[], bool] = lambda: True

    def note(self, slot: int, word: int, mask: int) -> None:
        """Note a read."""
        if self.on and self.counts():
            self.masks[slot, word] = self.masks.get((slot, word), 0) | mask & ALL_BITS

    def watch(self, slots: Mapping[int, Slot]) -> None:
        """Start to watch the input images that a program's scan reads."""
        for number, slot in slots.items():
            image: Any = slot.inputs
            if not isinstance(image.words, WatchedWords):
                image.words = WatchedWords(image.words, number, self)


class WatchedWords:
    """The eight words of an image, used in place of their memoryview."""

    def __init__(self, words: memoryview, slot: int, reads: Reads) -> None:
        self._words, self._slot, self._reads, self._note = words, slot, reads, reads.note

    def __getitem__(self, index: Any) -> Any:
        """Return a word or a list of words; while reads are noted, each reports which bits are used."""
        value = self._words[index]
        if not self._reads.on and isinstance(value, int):
            return value
        if not isinstance(value, int):
            return [self[number] for number in range(*index.indices(len(self._words)))]
        word = range(len(self._words))[index]
        self._note(self._slot, word, 0)
        return WatchedWord(value, lambda mask: self._note(self._slot, word, mask))

    def __len__(self) -> int:
        return len(self._words)

    def __iter__(self) -> Iterator[Any]:
        return (self[word] for word in range(len(self)))

    def tolist(self) -> list[Any]:
        """Return the words, see `memoryview.tolist`."""
        return list(self)

    def __eq__(self, other: object) -> bool:
        return self.tolist() == other

    __hash__ = None  # type: ignore[assignment]  # like a writable memoryview, it has none

    def __getattr__(self, name: str) -> Any:
        """Return any other attribute of the memoryview; this counts as reading all words."""
        for word in range(len(self)):
            self._note(self._slot, word, ALL_BITS)
        return getattr(self._words, name)


class WatchedWord(int):
    """A word that notes which of its bits are used; otherwise an ordinary integer."""

    _plain: int
    _note: Callable[[int], None]
    _shift: int

    def __new__(cls, value: int, note: Callable[[int], None], shift: int = 0) -> WatchedWord:
        """Make a word that has been shifted right by `shift` bits."""
        word = super().__new__(cls, value)
        word._plain, word._note, word._shift = value, note, shift
        return word

    def __and__(self, mask: int) -> int:
        self._note((mask & ALL_BITS) << self._shift)
        return self._plain & mask

    __rand__ = __and__

    def __rshift__(self, bits: int) -> int:
        return WatchedWord(self._plain >> bits, self._note, self._shift + bits)

    def __lt__(self, other: int) -> bool:
        return self._compared(other, int.__lt__)

    def __ge__(self, other: int) -> bool:
        return self._compared(other, int.__ge__)

    def _compared(self, other: int, compare: Callable[[int, int], bool]) -> bool:
        """Compare the word with a number; a comparison with 0 uses only the sign."""
        self._note(_SIGN if other == 0 and not self._shift else ALL_BITS)
        return compare(self._plain, other)


def _whole(name: str) -> Callable[..., Any]:
    """Return an operation of `int` that uses all bits of a word."""
    plain_operation = getattr(int, name)

    def operation(word: WatchedWord, *others: Any) -> Any:
        word._note(ALL_BITS << word._shift)
        return plain_operation(word._plain, *others)

    return operation


# fmt: off
_USE_ALL = (
    "__add__", "__radd__", "__sub__", "__rsub__", "__mul__", "__rmul__", "__floordiv__",
    "__rfloordiv__", "__truediv__", "__rtruediv__", "__mod__", "__rmod__", "__divmod__",
    "__rdivmod__", "__pow__", "__rpow__", "__lshift__", "__or__", "__ror__", "__xor__", "__rxor__",
    "__neg__", "__pos__", "__abs__", "__invert__", "__bool__", "__eq__", "__ne__", "__gt__",
    "__le__", "__hash__", "__index__", "__int__", "__float__", "__str__", "__repr__", "__format__",
    "__round__", "bit_length", "bit_count", "to_bytes", "conjugate",
)
# fmt: on
for _name in _USE_ALL:
    setattr(WatchedWord, _name, _whole(_name))
