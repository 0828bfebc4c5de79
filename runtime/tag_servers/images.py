"""The images of modules as tags, such as `Local:1:I` on a CompactLogix or `I:1` in an SLC program."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from itertools import chain

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.enip.listing import (
    BOOL,
    DINT,
    INT,
    ExternalAccess,
    ListedTag,
    Listing,
    Part,
    StructuredKind,
)
from scanrack.io_images.enip.paths import PathStep
from scanrack.io_images.image import WORDS
from scanrack.io_images.module_words import PLAIN_WORDS, ModuleWords

WORD_BITS = 16
FAULT_BYTES = 4

GENERIC, PROFILE_3601 = "generic", "3601"
PROFILES = (GENERIC, PROFILE_3601)
"""Profiles, each of which names the members of `Local:n:I` differently."""

_WORD = re.compile(
    r"Local:(?P<slot>\d+):(?P<direction>[IO])\.Data(?:\[(?P<word>\d{1,3})\])?(?:\.(?P<bit>\d{1,2}))?",
    re.IGNORECASE,
)

_IMAGE = re.compile(r"Local:(?P<slot>\d{1,3}):(?P<direction>[IO])", re.IGNORECASE)

_OUTPUT = re.compile(r"Local:([0-9]+):O|O:([0-9]+)", re.IGNORECASE)

_FAULT = Part("Fault", DINT, (), 0)


@cache
def _output_type(words: int) -> StructuredKind:
    """Return the data type of an output image."""
    size = 2 * words
    return StructuredKind(f"AB:1769_MODULE_INT_{size}Bytes:O:0", size, (Part("Data", INT, (words,), 0),))


@cache
def _input_type(words: int) -> StructuredKind:
    """Return the data type of an input image in the generic profile."""
    data = Part("Data", INT, (words,), FAULT_BYTES)
    name = f"AB:1769_MODULE_INT_{2 * words}Bytes:I:0"
    return StructuredKind(name, FAULT_BYTES + 2 * words, (_FAULT, data))


_INPUTS_3601 = StructuredKind(
    "AM:1769_3601:I:0",
    FAULT_BYTES + 2 * WORDS,
    (
        _FAULT,
        Part("Data0", INT, (), FAULT_BYTES),
        Part("ConfigError", BOOL, (), FAULT_BYTES + 1, 5),
        Part("ModuleOK", BOOL, (), FAULT_BYTES + 1, 6),
        Part("ConfigMode", BOOL, (), FAULT_BYTES + 1, 7),
        *(Part(f"Data{word}", INT, (), FAULT_BYTES + 2 * word) for word in range(1, WORDS)),
    ),
)
"""Data type of an eight-word input image in the 3601 profile."""


@dataclass(frozen=True, slots=True)
class ImagePlace:
    """A word or bit in an image of a module."""

    slot: int
    output: bool
    offset: int  # bytes from the first word; negative in Fault, which the controller puts before the words
    bit: int | None = None  # in the byte at `offset`


def image_tags(
    slot: int, words: ModuleWords, *, files: bool, profile: str = GENERIC
) -> tuple[ListedTag, ListedTag]:
    """Return the tags of a slot's images, inputs first.

    Args:
        words: names of the words of the module.
        files: whether the tags are data files of an SLC program.
        profile: see `PROFILES`.
    """
    access, inputs, outputs = ExternalAccess.READ_ONLY, len(words.inputs), len(words.outputs)
    if files:
        return ListedTag(f"I:{slot}", "", INT, (inputs,), access), ListedTag(f"O:{slot}", "", INT, (outputs,))
    kind = _INPUTS_3601 if _has_profile(words, profile) else _input_type(inputs)
    return ListedTag(f"Local:{slot}:I", "", kind, (), access), ListedTag(
        f"Local:{slot}:O", "", _output_type(outputs)
    )


def _has_profile(words: ModuleWords, profile: str) -> bool:
    """Return whether a module's input image has the 3601 profile; otherwise it has the generic profile."""
    return profile == PROFILE_3601 and len(words.inputs) == WORDS


def with_images(listing: Listing, slots: Mapping[int, ModuleWords], profile: str) -> Listing:
    """Return the tags of a program, followed by the tags of the slots' images."""
    images = [image_tags(slot, words, files=listing.files, profile=profile) for slot, words in slots.items()]
    tags = (*listing.tags, *chain.from_iterable(images))
    aliases = (
        replace(alias, target=part_of_image(alias.target, slots, profile)) for alias in listing.aliases
    )
    return Listing(tags, listing.files, tuple(aliases))


def part_of_image(address: str, slots: Mapping[int, ModuleWords], profile: str) -> str:
    """Return an image's word or bit as an address in the image tags; return other addresses unchanged.

    >>> slots = {1: PLAIN_WORDS, 2: PLAIN_WORDS}
    >>> part_of_image("Local:2:I.Data.20", slots, GENERIC)
    'Local:2:I.Data[1].4'
    >>> part_of_image("Local:1:I.Data[4].0", slots, PROFILE_3601)
    'Local:1:I.Data4.0'

    Args:
        address: an address in a program; addresses of small cards have no subscript.
        slots: the words of the modules.
    """
    match = _WORD.fullmatch(address)
    if match is None or not (match["word"] or match["bit"]):
        return address
    word, bit = divmod(int(match["bit"] or 0), WORD_BITS)
    word += int(match["word"] or 0)
    words = slots.get(int(match["slot"]), PLAIN_WORDS)
    numbered = match["direction"].upper() == "I" and _has_profile(words, profile)
    data = f"Data{word}" if numbered else f"Data[{word}]"
    return f"Local:{match['slot']}:{match['direction']}.{data}" + (f".{bit}" if match["bit"] else "")


def output_slot(tag: str) -> int | None:
    """Return the slot of an output image by its tag name, or None for any other tag.

    >>> output_slot("Local:1:O"), output_slot("O:2"), output_slot("Local:1:I"), output_slot("Run")
    (1, 2, None, None)
    """
    match = _OUTPUT.fullmatch(tag)
    return None if match is None else int(match[1] or match[2])


def _image_part(name: str, *, output: bool) -> Part | None:
    kinds = (_output_type(WORDS),) if output else (_input_type(WORDS), _INPUTS_3601)
    return next((kind.by_name[name] for kind in kinds if name in kind.by_name), None)


def image_place(steps: Sequence[PathStep]) -> ImagePlace | None:
    """Return the image, word or bit that a path names in a module with eight words, or None for other paths.

    >>> image_place(["Local:1:I", "Data", 3]), image_place(["Local:2:I", "ModuleOK"])
    (ImagePlace(slot=1, output=False, offset=6, bit=None), ImagePlace(slot=2, output=False, offset=1, bit=6))
    """
    match = _IMAGE.fullmatch(str(steps[0])) if steps else None
    if match is None:
        return None
    slot, output = int(match["slot"]), match["direction"] in "Oo"
    fault_bytes = 0 if output else FAULT_BYTES
    if len(steps) == 1:
        return ImagePlace(slot, output, -fault_bytes)
    part = _image_part(str(steps[1]).upper(), output=output)
    if part is None or part == _FAULT:
        return None
    offset, steps_left = part.offset - fault_bytes, list(steps[2:])
    if part.dims and steps_left and isinstance(steps_left[0], int):
        offset += INT.size * steps_left[0]
        steps_left = steps_left[1:]
    if not steps_left:
        return ImagePlace(slot, output, offset, part.bit)
    bit = _bit_number(steps_left)
    if bit is None or part.bit is not None:
        return None
    return ImagePlace(slot, output, offset + bit // 8, bit % 8)


def _bit_number(steps: Sequence[PathStep]) -> int | None:
    text = str(steps[0])
    is_bit = len(steps) == 1 and text.isdecimal() and int(text) < WORD_BITS
    return int(text) if is_bit else None
