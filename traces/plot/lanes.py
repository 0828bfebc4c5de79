"""The lanes of a timing chart: one for the ramp, and one per bit that changes.

Causes are above effects: commands come first, then bits for the motion and its end, errors, and inputs.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scanrack.io_images.module_words import INPUT, ModuleWords

from ..signals import decode
from .changes import Changes

GROUPS = ("command", "status", "error", "input", "output", "tag")
"""Kinds of lanes, from top to bottom."""

REST, ACCELERATING, CONSTANT, DECELERATING, HELD = range(5)
RAMP_STATES = ("at rest", "accelerating", "constant speed", "decelerating", "held")
"""Meanings of the ramp lane's values."""


_INPUTS = ("IN_", "INPUT_")
"""Prefixes of status bits that show an input."""


@dataclass(frozen=True, slots=True)
class Lane:
    """A row of a chart that shows a bit, the ramp state, or the values of a tag.

    Attributes:
        group: one of GROUPS; "ramp" for the ramp, "band" for a band.
        row: indexes of the first scan and of the scans in which the value changes; 0 = first scan read.
        time_ns: virtual times of these scans.
        value: values in these scans: 0 or 1, an index of RAMP_STATES, or the code of a band's text.
    """

    name: str
    group: str
    row: NDArray[np.int64]
    time_ns: NDArray[np.int64]
    value: NDArray[np.integer[Any]]

    @property
    def steady(self) -> bool:
        """Whether the lane's value never changes."""
        return len(self.value) == 1


@dataclass(frozen=True, slots=True)
class Band(Lane):
    """A lane whose values are texts or have names, such as the steps of a sequence."""

    names: Mapping[int, str] = field(default_factory=dict)  # name or text of each value

    def text(self, value: int) -> str:
        """Return the name or text of a value; two quotes for an empty text."""
        return self.names.get(value, str(value)) or '""'


def bit_lanes(words: ModuleWords, inputs: Changes, outputs: Changes) -> list[Lane]:
    """Return a lane for every named bit of a module with two modes, including those that never change."""
    lanes = []
    for names in words.groups.values():
        for name, (image, word, bit) in names.items():
            changes = inputs if image in INPUT else outputs
            values = decode.module_bit(changes.values, words, image, word, 1 << bit)
            lanes.append(_lane(name, _group(words, name, image), changes, values))
    return sorted(lanes, key=lambda lane: GROUPS.index(lane.group))


def _group(words: ModuleWords, name: str, image: str) -> str:
    """Return the kind of lane of a bit, one of `GROUPS`."""
    if image not in INPUT:
        return "command"
    if name in words.errors or name == "POSITION_INVALID":
        return "error"
    return "input" if name.startswith(_INPUTS) else "status"


def card_lanes(words: ModuleWords, inputs: Changes, outputs: Changes) -> list[Lane]:
    """Return a lane for every named bit of a card, inputs above outputs."""
    lanes = []
    for image, changes, group in (("I", inputs, "input"), ("O", outputs, "output")):
        for names in words.groups.values():
            for name, place in names.items():
                if place.image == image:
                    lanes.append(_lane(name, group, changes, changes.values[:, place.word] >> place.bit & 1))
    return lanes


def ramp_lane(words: ModuleWords, inputs: Changes) -> Lane:
    """Return the lane of the ramp state."""

    def is_on(name: str) -> NDArray[np.bool_]:
        return decode.input_bit(inputs.values, words, name)

    is_moving = is_on(decode.CW) | is_on(decode.CCW)
    conditions = [is_on("ACCELERATING"), is_on("DECELERATING"), is_moving, is_on("HOLD_STATE")]
    states = np.select(conditions, [ACCELERATING, DECELERATING, CONSTANT, HELD], REST)
    return _lane("ramp", "ramp", inputs, states)


def _lane(name: str, group: str, changes: Changes, values: NDArray[Any]) -> Lane:
    is_new = np.ones(len(values), bool)
    is_new[1:] = values[1:] != values[:-1]
    return Lane(name, group, changes.row[is_new], changes.time_ns[is_new], values[is_new].astype(np.int8))


def at_pixels(
    lane: Lane, start_ns: int, end_ns: int, pixels: int
) -> tuple[NDArray[np.int64], NDArray[np.integer[Any]]]:
    """Return the times and values of a lane with at most two changes per pixel.

    The first and last changes on each pixel are kept, so that even the shortest pulse is visible.
    """
    span_ns = max(1, end_ns - start_ns)
    pixel = (lane.time_ns - start_ns) * pixels // span_ns
    is_kept = np.ones(len(pixel), bool)
    is_kept[1:-1] = (pixel[1:-1] != pixel[:-2]) | (pixel[1:-1] != pixel[2:])
    return lane.time_ns[is_kept], lane.value[is_kept]
