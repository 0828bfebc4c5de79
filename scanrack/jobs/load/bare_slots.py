"""Slots without modules, for programs that are attached but do not run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.image import Image
from scanrack.io_images.module_words import ModuleWords


@dataclass(frozen=True, slots=True)
class BareSlot:
    """A slot without a module."""

    words: ModuleWords
    inputs: Image = field(default_factory=Image)  # the input image, all 0
    outputs: Image = field(default_factory=Image)


def bare_slots(words: Mapping[int, ModuleWords]) -> dict[int, BareSlot]:
    """Return a slot for each number, with the names of its words."""
    return {number: BareSlot(slot_words) for number, slot_words in words.items()}
