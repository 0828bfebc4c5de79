"""Words on the backplane as data: no time, no input or output; only values can be invalid.

The rule of this package: words have a meaning and a meaning has words, and going
there and back changes nothing. Words that mean nothing are refused with a
`ValueError` with the reason, except by the classes that a module or its logic uses at every
scan (`Parameters`, `StatusView`), which accept any words.

An `Image` is signed words, eight for a 3601, and their bytes at once. The thousands
functions split what needs more than 16 bits; `amci3601` knows what the words
of an AMCI 3601 mean.

>>> from scanrack.io_images import Image, join_thousands, split_thousands
>>> split_thousands(-12_345), join_thousands(-12, 0)
((-12, -345), -12000)
>>> image = Image([0x843E, 0x003F, 1])
>>> image[0], image.bit(0, 15), len(bytes(image))
(-31682, True, 16)
"""

from __future__ import annotations

from .image import WORDS, Image, signed_word
from .thousands import (
    PARAMETER_MAX,
    PARAMETER_MIN,
    REPORTED_MAX,
    is_legal_pair,
    join_reported,
    join_thousands,
    split_reported,
    split_thousands,
)

__all__ = [
    "PARAMETER_MAX",
    "PARAMETER_MIN",
    "REPORTED_MAX",
    "WORDS",
    "Image",
    "is_legal_pair",
    "join_reported",
    "join_thousands",
    "signed_word",
    "split_reported",
    "split_thousands",
]
