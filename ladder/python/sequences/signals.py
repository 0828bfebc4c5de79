"""Inputs and outputs: bits and words of the rack's images, by address or by meaning.

    start = Input("Local:2:I.Data.0")         a terminal of a card; I:2.0/0 and Data[0].0 are the same
    estop = Input("slot1.status.IN_ESTOP")    a bit by its meaning
    ready = Input("ready")                    a terminal by its name in the rack file
    level = InputWord("Local:3:I.Ch0Data")    a word, signed
    lamp: Output = Output("Local:2:O.Data.0")

The value is from the current scan's input latch. An input itself is true or false; `.rises`, `.falls`, `.on`
and `.off` are waits. In configuration mode, a status bit of a 3601 that is named by its meaning is false,
because the module then mirrors other bits.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any, Self, overload

from scanrack.io_images.addresses import Address
from scanrack.io_images.amci3601.bits import LIVE_BITS
from scanrack.io_images.amci3601.words import is_stepper
from scanrack.io_images.image import WORD_MAX, WORD_MIN, Image
from typing_extensions import override

from .parts import Clock, DeclarationError, Level, Part, Slots, words_of
from .places import find_bit, find_word
from .waits import Edge, Place, Wait, until

_BY_MEANING = re.compile(r"slot\d+\.status\.\w+", re.IGNORECASE)
_SIGN_BIT = 15
_MODE = 1 << _SIGN_BIT
_WORD_BITS = 16


def mask_of(bit: int) -> int:
    """Return the mask of a bit of a signed word.

    >>> mask_of(0), mask_of(15)
    (1, -32768)
    """
    return 1 << bit if bit < _SIGN_BIT else WORD_MIN


class Signal(Part):
    """A place in an image, by address or by a bare name of one slot, see `scanrack.io_images.addresses`."""

    image = "I"
    search = staticmethod(find_bit)

    def __init__(self, address: str) -> None:
        super().__init__()
        self.address = address
        self.at: Address | None = None  # the place, once the logic is attached to a rack

    @override
    def attach(self, slots: Slots, clock: Clock) -> None:
        self.at = self.find(slots)

    def find(self, slots: Slots) -> Address:
        """Return its place in a rack; raise a ValueError if it is unknown, in the other image, or a word."""
        try:
            return self.search(self.address, self.image, words_of(slots))
        except ValueError as error:
            raise DeclarationError.at(self.declared, f"{self.name}: {error}") from None


class Input(Signal, Level):
    """A bit of an input image, true or false in the current scan; `read` returns it as a bool."""

    def __init__(self, address: str) -> None:
        super().__init__(address)
        self.read: Callable[[], bool] = _unattached(self)
        self._place: Place | None = None  # the word that `read` reads; None = several words, or unknown

    @override
    def attach(self, slots: Slots, clock: Clock) -> None:
        """Find the bit; a stepper's bit that is named by its meaning is guarded, see `_reader`."""
        self.at = address = self.find(slots)
        assert address.bit is not None, "find_bit refuses words"
        module = words_of(slots)[address.slot]
        guarded = is_stepper(module) and _BY_MEANING.fullmatch(self.address) is not None
        self.read, self._place = _reader(
            slots[address.slot].inputs, address.word, address.bit, guarded=guarded
        )

    def __bool__(self) -> bool:
        return self.read()

    def __call__(self) -> bool:
        """Return whether it is on, so an input can be a condition, as in `steady(self.door, "1 s")`."""
        return self.read()

    @property
    def rises(self) -> Wait[None]:
        """A wait for the next change to on, after the scan of the await."""
        return Edge(self.read, True, f"{self.name} rises", self._place)

    @property
    def falls(self) -> Wait[None]:
        """A wait for the next change to off, after the scan of the await."""
        return Edge(self.read, False, f"{self.name} falls", self._place)

    @property
    def on(self) -> Wait[None]:
        """A wait until it is on, from the next scan on."""
        return until.of_input(self.read, f"{self.name} on", self._place)

    @property
    def off(self) -> Wait[None]:
        """A wait until it is off, from the next scan on."""
        return until.of_input(lambda: not self.read(), f"{self.name} off", self._place)

    def __repr__(self) -> str:
        return f"Input({self.address!r})"


def _reader(image: Image, word: int, bit: int, *, guarded: bool) -> tuple[Callable[[], bool], Place | None]:
    """Return the reader of a bit, and the 16-bit or 32-bit word that it reads, or None if it reads more.

    In configuration mode, a guarded bit is false unless it is a live bit.
    """
    words, mask = image.words, mask_of(bit)
    if not guarded or (word == 0 and mask & LIVE_BITS):
        return lambda: words[word] & mask != 0, (words, word, mask)
    if word == 0:
        both_bits = mask | _MODE
        return lambda: words[0] & both_bits == mask, (words, 0, both_bits)
    pair = (image.raw.cast("i"), 0, 1 << _WORD_BITS + bit | _MODE)  # little-endian, see io_images.image
    return lambda: words[word] & mask != 0 and words[0] >= 0, pair if word == 1 else None


def _unattached(part: Part) -> Callable[[], bool]:
    """Return a reader that raises a ValueError, for an input without a rack."""

    def refuse() -> bool:
        raise ValueError(f"{part.name or 'an input'} has no slot before the first scan")

    return refuse


class InputWord(Signal):
    """A word of an input image as a number, -32,768 to 32,767: `self.level` is an `int`."""

    search = staticmethod(find_word)

    @overload
    def __get__(self, logic: None, owner: type) -> Self: ...
    @overload
    def __get__(self, logic: object, owner: type) -> int: ...
    def __get__(self, logic: Any, owner: type) -> Any:
        if logic is None:
            return self
        words, word, _ = _place(self, logic)
        return words[word]


class OutputWord(InputWord):
    """A word of an output image: `self.setpoint = 4000` writes it."""

    image = "O"

    @override
    def owns(self) -> tuple[int, int, int] | None:
        return None if self.at is None else (self.at.slot, self.at.word, -1)

    def __set__(self, logic: object, value: int) -> None:
        if not WORD_MIN <= value <= WORD_MAX:
            raise ValueError(f"{self.name} = {value} is out of range; must be {WORD_MIN} to {WORD_MAX}")
        words, word, _ = _place(self, logic)
        words[word] = value


_LEVELS = (bool, int, Level)  # values accepted by an output; any text would be true


class Output(Signal):
    """A bit of an output image as a `bool`; for pyright, declare `lamp: Output = Output(...)`."""

    image = "O"

    @override
    def owns(self) -> tuple[int, int, int] | None:
        return None if self.at is None else (self.at.slot, self.at.word, mask_of(self.at.bit or 0))

    @overload
    def __get__(self, logic: None, owner: type) -> Self: ...
    @overload
    def __get__(self, logic: object, owner: type) -> bool: ...
    def __get__(self, logic: Any, owner: type) -> Any:
        if logic is None:
            return self
        words, word, mask = _place(self, logic)
        return words[word] & mask != 0

    def __set__(self, logic: Any, on: bool | Level) -> None:
        """Set the bit from True, False, a number, or an object with a level, such as an input."""
        try:
            words, word, mask = logic._places[self.name]
        except KeyError:
            words, word, mask = _place(self, logic)  # raises a ValueError before the first scan
        if on is False:
            if words[word] & mask:
                words[word] ^= mask
        elif on is True:
            if not words[word] & mask:
                words[word] ^= mask
        elif isinstance(on, _LEVELS):
            self.__set__(logic, bool(on))
        else:
            raise TypeError(f"{self.name} = {on!r} is not allowed; an output must be True or False")

    def __repr__(self) -> str:
        return f"Output({self.address!r})"


def _place(part: Signal, logic: Any) -> Place:
    """Return the place of a descriptor's value in an instance."""
    try:
        place: Place = logic._places[part.name]
    except KeyError:
        raise ValueError(f"{part.name} has no slot before the first scan") from None
    return place


def place_of(part: Signal, slots: Slots) -> Place:
    """Return the place of an attached signal."""
    address = part.at
    assert address is not None, "the signal is attached"
    slot = slots[address.slot]
    words = slot.inputs.words if address.image == "I" else slot.outputs.words
    return words, address.word, 0 if address.bit is None else mask_of(address.bit)
