"""Names of a module's words and bits, for the rack, addresses and traces.

    outputs, inputs    the names of the words of each image; a module has as many words as names
    groups             bits by group and name, as in `slot1.status.MOVE_COMPLETE`

The record of a module in `runtime.modules.record` contains both.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import field
from enum import IntFlag
from typing import NamedTuple

from .dataclass import dataclass
from .image import WORDS, checked_size
from .number_formats import NumberFormat


class BitPlace(NamedTuple):
    """The place of a named bit."""

    image: str  # "I" for the input image, "O" for the output image
    word: int  # from 0
    bit: int  # 0 to 15


INPUT = ("I", "in")
"""Names of an input image in addresses and in traces; the names of an output image are "O" and "out"."""

_IMAGES = {"I": "input", "O": "output"}

CONFIGURES = 15
"""The bit of a status or command word that is on in configuration mode."""


@dataclass(frozen=True, slots=True)
class Quantity:
    """A number in one or two words of an image.

    Attributes:
        name: name of its signal, as in `slot1.in.position`.
        image: "I" for the input image, "O" for the output image.
        word: its first word, from 0.
        words: 1 or 2.
        unit: for example "steps".
        format: format of two words; None if the configuration selects it; the module's events then report it.
        counts: whether it changes continuously while the axis moves.
    """

    name: str
    image: str
    word: int
    words: int = 2
    unit: str = ""
    format: NumberFormat | None = NumberFormat.THOUSANDS
    counts: bool = False


@dataclass(frozen=True, slots=True)
class Modes:
    """The two modes of a module whose words have different meanings in configuration mode.

    Attributes:
        live: mask of the bits of the status word with the same meaning in both modes.
        input: the input word with the bit `CONFIGURES`, which is on in configuration mode; in the output
            image, word 0 has it.
    """

    live: int
    input: int = 0

    def word(self, image: str) -> int:
        """Return the word with the mode bit in an image, "I" or "in", "O" or "out"."""
        return self.input if image in INPUT else 0


Groups = Mapping[str, Mapping[str, BitPlace]]
"""Places of named bits, by group and name."""


@dataclass(frozen=True, slots=True)
class ModuleWords:
    """Names of a module's words and bits.

    Attributes:
        message: prefix of its message types in a trace: letters and digits, beginning with a capital.
        outputs: names of the words from logic to module, in lower case, as many as the module has.
        inputs: names of the words from module to logic.
        groups: its named bits.
        profile: bits of input word 0, by their names in the module's add-on profile, as in
            `Local:1:I.ModuleOK`.
        profile_words: image and word of words, by their names in that profile, as in `Local:3:I.Ch0Data`.
        data_bits: size of the value `Data` in each image: 16 or 32 bits from word 0, with bits such as
            `Local:2:I.Data.3`; 0 if it is an array of words.
        terminals: for a card, the mask of the terminals in each word of an image, from word 0.
        card: for a card, its catalog number, used to find its members in `cards`.
        errors: names of the bits of the input image that report an error.
        quantities: the numbers in its words.
        modes: the modes of a module with a configuration mode; None for other modules.

    Raises:
        ValueError: a named bit or a quantity is outside the images, or a bit has two names in a group.
    """

    message: str
    outputs: tuple[str, ...]
    inputs: tuple[str, ...]
    groups: Groups = field(default_factory=dict, compare=False)
    profile: Mapping[str, int] = field(default_factory=dict, compare=False)
    profile_words: Mapping[str, tuple[str, int]] = field(default_factory=dict, compare=False)
    data_bits: int = field(default=0, compare=False)
    terminals: Mapping[str, Sequence[int]] = field(default_factory=dict, compare=False)
    card: str = field(default="", compare=False)
    errors: tuple[str, ...] = field(default=(), compare=False)
    quantities: tuple[Quantity, ...] = field(default=(), compare=False)
    modes: Modes | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        sizes = {"I": len(self.inputs), "O": len(self.outputs)}
        for quantity in self.quantities:
            last_word = sizes.get(quantity.image, 0) - quantity.words
            if quantity.words not in (1, 2) or not 0 <= quantity.word <= last_word:
                raise ValueError(f"{self.message}: {quantity}: must be 1 or 2 words of image I or O")
        for group, names in self.groups.items():
            _refuse_clashes(f"{self.message}: {group}", names, sizes)

    def named(self, image: str) -> tuple[str, ...]:
        """Return the names of the words of an image, "I" or "in", "O" or "out"."""
        return self.inputs if image in INPUT else self.outputs

    def quantities_in(self, image: str) -> list[Quantity]:
        """Return the quantities of an image, "I" or "in", "O" or "out"."""
        return [quantity for quantity in self.quantities if (quantity.image in INPUT) == (image in INPUT)]

    def quantity(self, name: str) -> Quantity | None:
        """Return the quantity with a name such as "position"; None if the module lacks it."""
        return next((quantity for quantity in self.quantities if quantity.name == name), None)

    @property
    def is_axis(self) -> bool:
        """Whether the module reports a position."""
        return self.quantity("position") is not None

    def place(self, name: str) -> BitPlace | None:
        """Return the place of a named bit of the input image; None if the module lacks it."""
        places = (names[name] for names in self.groups.values() if name in names)
        return next((place for place in places if place.image in INPUT), None)

    def covered(self, image: str) -> set[int]:
        """Return the numbers of the words in an image that contain named bits or two-word quantities."""
        words: set[int] = set()
        for quantity in self.quantities_in(image):
            if quantity.words > 1:
                words.update(range(quantity.word, quantity.word + quantity.words))
        if self.modes is not None:
            for names in self.groups.values():
                words.update(
                    place.word for place in names.values() if (place.image in INPUT) == (image in INPUT)
                )
        return words

    def configures(self, image: str, words: Sequence[int]) -> bool:
        """Return whether the words of an image are in configuration mode."""
        return self.modes is not None and bool(words[self.modes.word(image)] >> CONFIGURES & 1)

    def live(self, image: str, word: int) -> int:
        """Return the mask of the bits in a word that have the same meaning in both modes."""
        if self.modes is None:
            return 0xFFFF
        if word != self.modes.word(image):
            return 0
        return self.modes.live if image in INPUT else 1 << CONFIGURES

    def bits(self, image: str, word: int) -> Iterator[tuple[str, int]]:
        """Yield the name and number of each named bit in a word."""
        for names in self.groups.values():
            yield from (
                (name, place.bit)
                for name, place in names.items()
                if (place.image, place.word) == (image, word)
            )

    def terminals_instead(self, image: str, word: int, bit: int) -> str:
        """Return a card's terminals, such as "inputs 0 to 7", if a bit is not a terminal; otherwise ""."""
        masks = self.terminals.get(image)
        if masks is None or (word < len(masks) and masks[word] >> bit & 1):
            return ""
        kind = "inputs" if image == "I" else "outputs"
        return f"{kind} {numbers_of(masks)}" if any(masks) else f"no {kind}"


def _refuse_clashes(group: str, names: Mapping[str, BitPlace], sizes: Mapping[str, int]) -> None:
    """Raise a ValueError if a bit of a group is outside the images or has two names.

    Args:
        group: name of the group, for messages.
        sizes: number of words by image.
    """
    names_by_place: dict[BitPlace, str] = {}
    for name, place in names.items():
        if place.word not in range(sizes.get(place.image, 0)) or place.bit not in range(16):
            last_word = sizes.get(place.image, max(sizes.values())) - 1
            raise ValueError(
                f"{group}.{name}: {place}: must be of image I or O, word 0 to {last_word}, bit 0 to 15"
            )
        other_name = names_by_place.setdefault(place, name)
        if other_name != name:
            image = _IMAGES[place.image]
            raise ValueError(
                f"{group}: {other_name} and {name} are both bit {place.bit} of {image} word {place.word}; "
                f"free bits: {_free_bits(place.image, names.values())}"
            )


def _free_bits(image: str, named_bits: Collection[BitPlace]) -> str:
    """Return the unnamed bits of words that also have named bits, as text."""
    masks: dict[int, int] = {}
    for place in named_bits:
        if place.image == image:
            masks[place.word] = masks.get(place.word, 0xFFFF) & ~(1 << place.bit)
    free_texts = [f"{numbers_of([mask])} of word {word}" for word, mask in sorted(masks.items()) if mask]
    return "; ".join(free_texts) or "none"


def terminals_in(masks: Sequence[int]) -> list[int]:
    """Return the numbers of the terminals in masks, one mask per word."""
    return [16 * word + bit for word, mask in enumerate(masks) for bit in range(16) if mask >> bit & 1]


def numbers_of(masks: Sequence[int]) -> str:
    """Return the numbers of terminals as text.

    >>> numbers_of((0xFFFF, 0x0001)), numbers_of((0x00FF, 0x00FF))
    ('0 to 16', '0 to 7, 16 to 23')
    """
    number_runs: list[list[int]] = []  # first and last number of each
    for terminal in terminals_in(masks):
        if number_runs and terminal == number_runs[-1][1] + 1:
            number_runs[-1][1] = terminal
        else:
            number_runs.append([terminal, terminal])
    return ", ".join(str(first) if first == last else f"{first} to {last}" for first, last in number_runs)


def flag_places(image: str, *words: type[IntFlag]) -> Mapping[str, BitPlace]:
    """Return the bits of an image by name, from the flags of its words."""
    return {
        str(flag.name): BitPlace(image, word, flag.value.bit_length() - 1)
        for word, flags in enumerate(words)
        for flag in flags
    }


def numbered(size: int) -> tuple[str, ...]:
    """Return the names word0, word1, ...; raise a ValueError for an illegal number of words."""
    return tuple(f"word{index}" for index in range(checked_size(size)))


PLAIN_WORDS = ModuleWords("Plain", numbered(WORDS), numbered(WORDS))
"""The words of a module without names: eight in each image."""
