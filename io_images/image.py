"""The image of 16-bit words that logic and a module exchange over the backplane.

A 3601 exchanges eight words in each direction; the words of other modules are named by their `ModuleWords`.
Words are signed in the PLC (INT). Bits are numbered 0 to 15 from the least significant bit. An image is a
view of little-endian bytes, so a rack can keep all images in one block of memory, and a recorder can copy
that block without encoding it.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from operator import index
from typing import NoReturn

WORDS = 8
"""Words in an image of a 3601 [manual, chapter 1: 8 input and 8 output words]; the default for `Image`."""

WORDS_MAX = 250
"""Maximum words in an image: 500 bytes, the limit of a CIP I/O connection without a large forward open."""

WORD_MIN = -32_768
WORD_MAX = 32_767
UNSIGNED_MAX = 65_535

if sys.byteorder != "little":  # pragma: no cover - none of the supported machines
    raise RuntimeError("scanrack keeps its images little-endian and needs a little-endian machine")


def signed_word(value: int) -> int:
    """Return a signed or unsigned word (-32,768 to 65,535) as a signed word.

    >>> signed_word(0x843E), signed_word(63)
    (-31682, 63)

    Raises:
        ValueError: the value is not a whole number or does not fit in 16 bits.
    """
    try:
        value = index(value)
    except TypeError:
        raise ValueError(f"word {value!r} is not allowed: a word is a whole number") from None
    if not WORD_MIN <= value <= UNSIGNED_MAX:
        raise ValueError(f"word {value} is out of range: must be {WORD_MIN} to {UNSIGNED_MAX}")
    return value - 65_536 if value > WORD_MAX else value


class Image:
    """Signed words that logic, modules and recorders share: eight, or `size` words.

    `raw` is the memory as little-endian bytes; `words` is the same memory as signed integers. Indexing and
    iterating an image access its words; writing also accepts unsigned words.

    >>> image = Image([0x843E, 0x003F, 1])
    >>> image[0], image.bit(0, 15), bytes(image.raw[:4]).hex(), len(image)
    (-31682, True, '3e843f00', 8)
    >>> Image([7], size=2)
    Image([7, 0])

    Args:
        words: up to `size` words, -32,768 to 65,535 each; missing words are 0.
        size: number of words, 1 to 250.
        buffer: writable bytes, two per word, to use as the image's memory; their number sets the size.

    Raises:
        ValueError: there are more than `size` words, a word is out of range, or the size or the buffer is
            invalid.
    """

    __slots__ = ("raw", "words")

    raw: memoryview
    words: memoryview

    def __init__(
        self,
        words: Iterable[int] = (),
        *,
        size: int = WORDS,
        buffer: memoryview | bytearray | None = None,
    ) -> None:
        self.raw = memoryview(bytearray(2 * checked_size(size)) if buffer is None else buffer).cast("B")
        if len(self.raw) % 2 or not 1 <= len(self.raw) // 2 <= WORDS_MAX or self.raw.readonly:
            kind = "read-only" if self.raw.readonly else "writable"
            raise ValueError(
                f"an image needs 2 to {2 * WORDS_MAX} writable bytes, two a word: got {len(self.raw)}, {kind}"
            )
        self.words = self.raw.cast("h")
        values = list(words)
        if len(values) > len(self.words):
            raise ValueError(f"an image has {len(self.words)} words, got {len(values)}")
        for word, value in enumerate(values):
            self.words[word] = signed_word(value)

    def __deepcopy__(self, _memo: object) -> Image:
        return Image(buffer=bytearray(self.raw))

    def __getitem__(self, word: int) -> int:
        try:
            return self.words[word]
        except (IndexError, TypeError, NotImplementedError):
            raise _no_such_word(self, word) from None

    def __setitem__(self, word: int, value: int) -> None:
        try:
            self.words[word] = signed_word(value)
        except (IndexError, TypeError, NotImplementedError):
            raise _no_such_word(self, word) from None

    def __len__(self) -> int:
        return len(self.words)

    def __iter__(self) -> Iterator[int]:
        return iter(self.words.tolist())

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Image):
            return self.raw.tobytes() == other.raw.tobytes()
        return NotImplemented

    __hash__ = None  # type: ignore[assignment]  # an image is mutable

    def __bytes__(self) -> bytes:
        return self.raw.tobytes()

    def __repr__(self) -> str:
        return f"Image({self.words.tolist()})"

    def _repr_html_(self) -> str:
        """Return the words as HTML for a notebook: number, value, hexadecimal, and the bits that are on."""
        from .static_html import card, rows

        table = (
            (str(word), f"{value:,}", f"{value & 0xFFFF:04X}h", " ".join(map(str, _bits_on(value))))
            for word, value in enumerate(self)
        )
        return card("Image", rows(table))

    def bit(self, word: int, bit: int) -> bool:
        """Return whether `bit` (0 to 15) of `word` (from 0) is set."""
        _check_address(self.words, word, bit)
        return bool(self.words[word] >> bit & 1)

    def set_bit(self, word: int, bit: int, on: bool) -> None:
        """Set or clear `bit` (0 to 15) of `word` (from 0)."""
        _check_address(self.words, word, bit)
        unsigned = self.words[word] & 0xFFFF
        unsigned = unsigned | 1 << bit if on else unsigned & ~(1 << bit)
        self.words[word] = signed_word(unsigned)

    def copy(self) -> Image:
        """Return an image with its own memory and the same words."""
        return Image(buffer=bytearray(self.raw))

    def load(self, other: Image) -> None:
        """Copy all words of `other`; raise a ValueError if it is not an image of the same size."""
        if not isinstance(other, Image):
            raise ValueError(f"{other!r} is not an image: write load(Image([...])) or load(move.to_image())")
        if len(other.words) != len(self.words):
            raise ValueError(
                f"an image of {len(other.words)} words does not fit into one of {len(self.words)}"
            )
        self.raw[:] = other.raw

    def clear(self) -> None:
        """Set all words to 0."""
        self.raw[:] = bytes(len(self.raw))

    def read_only(self) -> Image:
        """Return a read-only view of the same memory."""
        return _ReadOnlyImage(self)


class _ReadOnlyImage(Image):
    """A read-only view of an input image for logic; only the module may write the image."""

    __slots__ = ()

    def __init__(self, image: Image) -> None:
        self.raw = image.raw.toreadonly()
        self.words = self.raw.cast("h")

    def __setitem__(self, word: int, value: int) -> NoReturn:
        _refuse_to_write()

    def set_bit(self, word: int, bit: int, on: bool) -> NoReturn:
        _refuse_to_write()

    def load(self, other: Image) -> NoReturn:
        _refuse_to_write()

    def clear(self) -> NoReturn:
        _refuse_to_write()


def checked_size(size: int) -> int:
    """Return `size`, the number of words in an image; raise a ValueError unless it is 1 to 250."""
    if type(size) is not int or not 1 <= size <= WORDS_MAX:
        raise ValueError(f"an image of {size!r} words is not allowed: 1 to {WORDS_MAX}")
    return size


def _refuse_to_write() -> NoReturn:
    raise ValueError("an input image is read-only: the module writes it; to hold an input, use a force")


def _no_such_word(image: Image, word: object) -> ValueError:
    return ValueError(f"no such word: {word!r}; words are 0 to {len(image) - 1}")


def _check_address(words: memoryview, word: object, bit: object) -> None:
    if not (isinstance(word, int) and isinstance(bit, int) and 0 <= word < len(words) and 0 <= bit <= 15):
        last_word = len(words) - 1
        raise ValueError(f"no such bit: word {word}, bit {bit}; words are 0 to {last_word}, bits 0 to 15")


def _bits_on(value: int) -> list[int]:
    return [bit for bit in range(16) if value >> bit & 1]
