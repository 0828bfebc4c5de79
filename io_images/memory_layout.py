"""The places of module images in a rack's block of memory.

Each slot has its output image and its input image, with two bytes per word. The block ends with 0 to 3 words
of padding, so that the tags after it in a trace need no padding:

    byte  0        16       32       40       44    48
          slot 1   slot 1   slot 2   slot 2   pad
          outputs  inputs   outputs  inputs           8 + 8 words, then 4 + 2
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from .dataclass import dataclass
from .image import WORDS_MAX
from .module_words import INPUT, ModuleWords

ALIGNED_TO = 8
"""The size of the block is a multiple of this number of bytes, the size of the widest tag."""


class ImagePlaces(NamedTuple):
    """Places of a module's images in the block, in bytes."""

    outputs: slice
    inputs: slice

    def image(self, image: str) -> slice:
        """Return the byte slice of an image: "I" or "in", "O" or "out"."""
        return self.inputs if image in INPUT else self.outputs

    def columns(self, image: str) -> slice:
        """Return the slice of an image in the block, counted in words."""
        place = self.image(image)
        return slice(place.start // 2, place.stop // 2)

    @property
    def whole(self) -> slice:
        """The byte slice of both images."""
        return slice(self.outputs.start, self.inputs.stop)

    @property
    def words(self) -> slice:
        """The slice of both images in the block, counted in words."""
        return slice(self.outputs.start // 2, self.inputs.stop // 2)


@dataclass(frozen=True, slots=True)
class MemoryLayout:
    """The layout of a block.

    Attributes:
        places: the places of the images by slot number, in the order of the block.
        size: bytes of the block, including padding.
    """

    places: Mapping[int, ImagePlaces]
    size: int

    @property
    def words(self) -> int:
        """Words of the block, including padding."""
        return self.size // 2

    @property
    def padding(self) -> int:
        """Words of padding at its end."""
        input_ends = (place.inputs.stop for place in self.places.values())
        return (self.size - max(input_ends, default=0)) // 2


NO_MEMORY = MemoryLayout({}, 0)
"""The layout of a rack without modules."""


def memory_layout(slots: Iterable[tuple[int, ModuleWords]]) -> MemoryLayout:
    """Return the layout of the block for slots, given as number and module words, in block order.

    >>> from .module_words import PLAIN_WORDS, numbered
    >>> layout = memory_layout([(1, PLAIN_WORDS), (3, ModuleWords("Small", numbered(1), numbered(2)))])
    >>> layout.places[3].inputs, layout.size, layout.padding
    (slice(34, 38, None), 40, 1)

    Raises:
        ValueError: an image has no words, or more than 250.
    """
    places, offset = {}, 0
    for number, words in slots:
        for names, image in ((words.outputs, "output"), (words.inputs, "input")):
            if not 1 <= len(names) <= WORDS_MAX:
                raise ValueError(
                    f"slot {number}: {words.message} has {len(names)} {image} words: must be 1 to {WORDS_MAX}"
                )
        outputs_end = offset + 2 * len(words.outputs)
        end = outputs_end + 2 * len(words.inputs)
        places[number] = ImagePlaces(slice(offset, outputs_end), slice(outputs_end, end))
        offset = end
    return MemoryLayout(places, -(-offset // ALIGNED_TO) * ALIGNED_TO)
