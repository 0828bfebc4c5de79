"""Words on the backplane as plain data, without time or I/O.

Words can be converted to named objects and back without loss. Meaningless words raise a `ValueError` with the
reason. Only the classes that a module or its logic uses in every scan (`Parameters`, `StatusView`) accept any
words.

An `Image` contains signed words (eight for a 3601) and gives access to the same memory as bytes. The
thousands functions split values of more than 16 bits. `amci3601` defines the meaning of an AMCI 3601's words.

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
