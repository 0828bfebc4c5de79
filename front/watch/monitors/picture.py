"""The contents of a frame: one scan, and the changes since the last frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ...io_images.amci3601.words import is_stepper
from ...io_images.memory_layout import MemoryLayout, memory_layout
from ...io_images.module_words import ModuleWords
from ...runtime.live.ring import Row, Rows
from ...runtime.loop.scan import MODE_MASK, CpuMode, mode_name
from ...runtime.machine.spec import INPUT_NAMES
from ..history.watched_machines import PER_SLOT

Json = dict[str, Any]

DEEP = ("words", "values", "machine", "power", "tags")
"""Parts of a frame of which only changed keys are sent."""


class StepperValue(NamedTuple):
    """A value in the words of a 3601 in command mode [chapters 5 and 6].

    Attributes:
        words: places in the words of its slot, the inputs before the outputs; of two the first has the
            thousands.
    """

    name: str
    title: str
    unit: str
    words: tuple[int, ...]

    def of(self, words: Sequence[int]) -> int:
        """Return the value in the words of its slot."""
        first, *rest = (words[each] for each in self.words)
        return first * 1000 + rest[0] if rest else first


_VALUES = (
    ("position", "Position", "steps", ("position_msw", "position_lsw")),
    ("encoder", "Encoder", "counts", ("encoder_msw", "encoder_lsw")),
    ("captured", "Captured", "steps", ("captured_msw", "captured_lsw")),
    ("target", "Target", "steps", ("target_msw", "target_lsw")),
    ("speed", "Speed", "steps/s", ("speed_msw", "speed_lsw")),
    ("acceleration", "Acceleration", "steps/ms/s", ("acceleration",)),
    ("deceleration", "Deceleration", "steps/ms/s", ("deceleration",)),
)
"""Name, title, unit and words by name."""


def values_of(words: ModuleWords) -> tuple[StepperValue, ...]:
    """Return the values of a module: those of a stepper whose words it has; none of another module."""
    if not is_stepper(words):
        return ()
    names = [*words.inputs, *words.outputs]
    return tuple(
        StepperValue(name, title, unit, tuple(names.index(each) for each in own))
        for name, title, unit, own in _VALUES
        if set(own) <= set(names)
    )


@dataclass(frozen=True)
class Places:
    """The layout of a row."""

    slots: Mapping[int, ModuleWords]
    machines: Sequence[int]

    @cached_property
    def layout(self) -> MemoryLayout:
        """The places of the images."""
        return memory_layout(self.slots.items())

    @cached_property
    def values(self) -> Mapping[int, tuple[StepperValue, ...]]:
        """The values of each slot."""
        return {slot: values_of(words) for slot, words in self.slots.items()}

    def of(self, row: Row, before: Rows, *, past: bool = False) -> Json:
        """Return a frame's contents about the images and machines of a row.

        Args:
            before: an earlier row, for speeds; or none.
            past: the row is not the latest one, so that shaft and encoder are unknown: machines are read only
                at intervals, and a trace has no figures at all.
        """
        words = row["words"].tolist()
        shown: Json = {"words": {}, "values": {}, "machine": {}}
        for slot, places in self.layout.places.items():
            own = shown["words"][str(slot)] = words[places.columns("I")] + words[places.columns("O")]
            if self.values[slot]:
                shown["values"][str(slot)] = {each.name: each.of(own) for each in self.values[slot]}
        figures = row["figures"].tolist()
        past = past or not row["wall_ns"]  # a row of a trace
        for place, slot in enumerate(self.machines):
            shaft, encoder, levels, zero = figures[PER_SLOT * place :][:PER_SLOT]
            configured = shown["words"][str(slot)][0] >= 0
            values = shown["values"].get(str(slot), {}) if configured else {}
            if past:
                shaft = encoder = None
                levels = shown["words"][str(slot)][1]  # status LSW: the levels as the module reads them
            known = configured or not past  # a configuration's mirror has no levels
            commanded = words[self.layout.places[slot].columns("O").start] >= 0  # else these words configure
            shown["machine"][str(slot)] = {
                "position": values.get("position"),
                "shaft": shaft,
                "encoder": encoder,
                "zero": zero,  # 0 in a trace, which has no machine
                "target": values.get("target") if commanded else None,
                "speed": self._speed(slot, row, before),
                "inputs": {
                    name: bool(levels & bit.value) if known else None for name, bit in INPUT_NAMES.items()
                },
            }
        return shown

    def _speed(self, slot: int, row: Row, before: Rows) -> int | None:
        """Return the speed of a stepper's position, steps/s; None if unknown."""
        if slot not in self.slots or not len(before) or before[0]["now_ns"] >= row["now_ns"]:
            return None
        inputs = self.layout.places[slot].columns("I")
        both = [each["words"][inputs].tolist() for each in (row, before[0])]
        position = next((each for each in self.values[slot] if each.name == "position"), None)
        if position is None or any(each[0] < 0 for each in both):
            return None  # in configuration mode these words are a mirror
        now, then = map(position.of, both)
        return round((now - then) * 1e9 / (int(row["now_ns"]) - int(before[0]["now_ns"])))


def mode_of(flags: int) -> str:
    """Return the mode in the flags of a scan: run, program or test."""
    mode = CpuMode(flags & MODE_MASK)
    return mode_name(CpuMode.TEST if mode is CpuMode.SINGLE_SCAN else mode)


def changed(frame: Json, last: Json) -> Json:
    """Return the differences from the last frame, which is then replaced."""
    found: Json = {}
    for key, value in frame.items():
        if key in DEEP:
            known = last.setdefault(key, {})
            new = {name: each for name, each in value.items() if name not in known or known[name] != each}
            known.update(new)
            if new:
                found[key] = new
        elif key not in last or last[key] != value:
            found[key] = last[key] = value
    return found


def speed_reached(rows: Any) -> float | None:
    """Return the speed of these rows as a multiple of real time; None for too few of them."""
    if len(rows) < 2:
        return None
    virtual = int(rows["now_ns"][-1]) - int(rows["now_ns"][0])
    wall = int(rows["wall_ns"][-1]) - int(rows["wall_ns"][0])
    return round(virtual / wall, 4) if wall > 0 else None


def late_scans(rows: Any, flag: int) -> int:
    """Return the number of late rows."""
    return int(np.count_nonzero(rows["flags"] & flag))
