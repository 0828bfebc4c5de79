"""Makes the contents of a frame: one scan, and the changes since the last frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from scanrack.io_images.amci3601.words import is_stepper
from scanrack.io_images.memory_layout import MemoryLayout, memory_layout
from scanrack.io_images.module_words import INPUT, ModuleWords, Quantity
from scanrack.runtime.live.ring import Row, Rows
from scanrack.runtime.loop.scan import MODE_MASK, CpuMode, mode_name
from scanrack.runtime.machine.spec import INPUT_NAMES
from scanrack.traces.read.number_formats import NumberFormats

from ..history.watched_machines import PER_SLOT

Json = dict[str, Any]

MOVING = ("MOVING_CW", "MOVING_CCW")
"""Status bits of modules that report whether they move."""

DEEP = ("words", "values", "machine", "power", "tags")
"""Parts of a frame of which only changed keys are sent."""


def values_of(words: ModuleWords) -> dict[str, Quantity]:
    """Return the quantities of a module by their names on the page, inputs first."""
    return {quantity.name.removeprefix("programmed_"): quantity for quantity in words.quantities}


def described_values(words: ModuleWords) -> list[Json]:
    """Return the quantities of a module for `hello`.

    `words` are places in the words of its slot, inputs before outputs; `format` is null if the module's
    configuration selects it.
    """
    rows = []
    for name, quantity in values_of(words).items():
        first = quantity.word + (0 if quantity.image in INPUT else len(words.inputs))
        rows.append(
            {
                "name": name,
                "title": name.replace("_", " ").capitalize(),
                "unit": quantity.unit,
                "words": list(range(first, first + quantity.words)),
                "format": quantity.format and quantity.format.value,
            }
        )
    return rows


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
    def values(self) -> Mapping[int, Mapping[str, Quantity]]:
        """The quantities of each slot, by name."""
        return {slot: values_of(words) for slot, words in self.slots.items()}

    def of(self, row: Row, before: Rows, formats: NumberFormats, *, past: bool = False) -> Json:
        """Return the part of a frame about the images and machines of a row.

        Args:
            formats: number formats of modules whose configuration selects them.
            before: an earlier row, for speeds; may be empty.
            past: whether the row is not the latest. Shaft and encoder are then unknown: machines are read
                only at intervals, and a trace has no figures.
        """
        words, scan = row["words"].tolist(), int(row["scan"])
        picture: Json = {"words": {}, "values": {}, "machine": {}}
        for slot, places in self.layout.places.items():
            images = {image: words[places.columns(image)] for image in ("I", "O")}
            picture["words"][str(slot)] = images["I"] + images["O"]
            if self.values[slot]:
                value = formats.reader(slot, scan)
                picture["values"][str(slot)] = {
                    name: value(quantity, images[quantity.image])
                    for name, quantity in self.values[slot].items()
                }
        past = past or not row["wall_ns"]  # a row from a trace
        for place, slot in enumerate(self.machines):
            figures = row["figures"][PER_SLOT * place :][:PER_SLOT].tolist()
            machine = self._machine(slot, words, picture["values"].get(str(slot), {}), figures, past=past)
            picture["machine"][str(slot)] = machine | {"speed": self._speed(slot, row, before, formats)}
        return picture

    def _machine(
        self, slot: int, words: Sequence[int], values: Json, figures: Sequence[int], *, past: bool
    ) -> Json:
        """Return a machine's values for a page, except its speed."""
        shaft, encoder, levels, zero = figures
        module, places = self.slots[slot], self.layout.places[slot]
        inputs, outputs = words[places.columns("I")], words[places.columns("O")]
        configured = not module.configures("I", inputs)
        values = values if configured else {}
        read_levels = _levels(module, inputs) if past else levels
        known = read_levels if configured or not past else None  # the mirror of a configuration has no levels
        return {
            "position": values.get("position"),
            "shaft": None if past else shaft,
            "encoder": None if past else encoder,
            "zero": zero,  # 0 for a trace, which has no machine
            "target": None if module.configures("O", outputs) else values.get("target"),
            "inputs": {
                name: None if known is None else bool(known & bit.value) for name, bit in INPUT_NAMES.items()
            },
        }

    def _speed(self, slot: int, row: Row, before: Rows, formats: NumberFormats) -> int | None:
        """Return the speed of a stepper's position, steps/s; None if unknown."""
        if slot not in self.slots or not len(before) or before[0]["now_ns"] >= row["now_ns"]:
            return None
        inputs, module = self.layout.places[slot].columns("I"), self.slots[slot]
        samples = [(int(sample["scan"]), sample["words"][inputs].tolist()) for sample in (row, before[0])]
        position = module.quantity("position")
        if position is None or any(module.configures("I", words) for _, words in samples):
            return None  # in configuration mode, these words are a mirror
        if not _moves(module, row["words"][inputs].tolist()):
            return 0
        now, then = (formats.value(slot, scan, position, words) for scan, words in samples)
        return round((now - then) * 1e9 / (int(row["now_ns"]) - int(before[0]["now_ns"])))


def _moves(module: ModuleWords, inputs: Sequence[int]) -> bool:
    """Return whether a module reports that it moves; True if it does not report this."""
    status = module.groups.get("status", {})
    moving = [status[name] for name in MOVING if name in status]
    return not moving or any(inputs[place.word] >> place.bit & 1 for place in moving)


def _levels(module: ModuleWords, inputs: Sequence[int]) -> int | None:
    """Return the levels of a machine's inputs as the module reads them; None if some are not shown."""
    return inputs[1] if is_stepper(module) else None


def mode_of(flags: int) -> str:
    """Return the mode in the flags of a scan: run, program or test."""
    mode = CpuMode(flags & MODE_MASK)
    return mode_name(CpuMode.TEST if mode is CpuMode.SINGLE_SCAN else mode)


def changed(frame: Json, last: Json) -> Json:
    """Return the differences from the last frame; then replace the contents of `last` with this frame."""
    changes: Json = {}
    for key, value in frame.items():
        if key in DEEP:
            last_value = last.setdefault(key, {})
            new = {
                name: entry
                for name, entry in value.items()
                if name not in last_value or last_value[name] != entry
            }
            last_value.update(new)
            if new:
                changes[key] = new
        elif key not in last or last[key] != value:
            changes[key] = last[key] = value
    return changes


def speed_reached(rows: Any) -> float | None:
    """Return the speed in these rows as a multiple of real time; None if there are too few rows."""
    if len(rows) < 2:
        return None
    virtual = int(rows["now_ns"][-1]) - int(rows["now_ns"][0])
    wall = int(rows["wall_ns"][-1]) - int(rows["wall_ns"][0])
    return round(virtual / wall, 4) if wall > 0 else None


def late_scans(rows: Any, flag: int) -> int:
    """Return the number of late rows."""
    return int(np.count_nonzero(rows["flags"] & flag))
