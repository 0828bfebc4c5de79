"""The contents of a frame: a scan, and the changes since the last frame."""

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
"""Status bits with which modules report that they are moving."""

SENT_BY_KEY = ("words", "values", "machine", "power", "tags")
"""Parts of a frame for which only changed keys are sent."""


def values_of(words: ModuleWords) -> dict[str, Quantity]:
    """Return the quantities of a module by their names on a page, inputs first."""
    return {quantity.name.removeprefix("programmed_"): quantity for quantity in words.quantities}


def described_values(words: ModuleWords) -> list[Json]:
    """Return the quantities of a module for `hello`.

    `words` are indexes into the slot's words, inputs before outputs. `format` is null if the module's
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
class RowLayout:
    """The layout of a row."""

    slots: Mapping[int, ModuleWords]
    machines: Sequence[int]

    @cached_property
    def layout(self) -> MemoryLayout:
        """The locations of the images in memory."""
        return memory_layout(self.slots.items())

    @cached_property
    def values(self) -> Mapping[int, Mapping[str, Quantity]]:
        """The quantities of each slot, by name."""
        return {slot: values_of(words) for slot, words in self.slots.items()}

    def picture_of(self, row: Row, earlier: Rows, formats: NumberFormats, *, past: bool = False) -> Json:
        """Return the images and machines of a row for a frame.

        Args:
            formats: number formats of modules whose configuration selects them.
            earlier: an earlier row for the speeds, or no rows.
            past: whether the row is not the latest. The shaft and encoder are then unknown, since machines
                are read only at intervals and traces have no figures.
        """
        words, scan = row["words"].tolist(), int(row["scan"])
        picture: Json = {"words": {}, "values": {}, "machine": {}}
        for slot, image_places in self.layout.places.items():
            images = {image: words[image_places.columns(image)] for image in ("I", "O")}
            picture["words"][str(slot)] = images["I"] + images["O"]
            if self.values[slot]:
                value = formats.reader(slot, scan)
                picture["values"][str(slot)] = {
                    name: value(quantity, images[quantity.image])
                    for name, quantity in self.values[slot].items()
                }
        has_figures = not past and bool(row["wall_ns"])  # a row from a trace has no wall time
        for index, slot in enumerate(self.machines):
            figures = row["figures"][PER_SLOT * index :][:PER_SLOT].tolist()
            values = picture["values"].get(str(slot), {})
            machine = self._machine(slot, words, values, figures, has_figures=has_figures)
            picture["machine"][str(slot)] = machine | {"speed": self._speed(slot, row, earlier, formats)}
        return picture

    def _machine(
        self, slot: int, words: Sequence[int], values: Json, figures: Sequence[int], *, has_figures: bool
    ) -> Json:
        """Return a machine's values for a page, except its speed."""
        shaft, encoder, machine_levels, zero = figures
        module, images = self.slots[slot], self.layout.places[slot]
        inputs, outputs = words[images.columns("I")], words[images.columns("O")]
        mirrors_configuration = module.configures("I", inputs)  # then the words are no position or levels
        if mirrors_configuration:
            values = {}
        levels: int | None = machine_levels
        if not has_figures:
            levels = None if mirrors_configuration else _levels(module, inputs)
        return {
            "position": values.get("position"),
            "shaft": shaft if has_figures else None,
            "encoder": encoder if has_figures else None,
            "zero": zero,  # 0 for a trace, which has no machine
            "target": None if module.configures("O", outputs) else values.get("target"),
            "inputs": {
                name: None if levels is None else bool(levels & bit.value)
                for name, bit in INPUT_NAMES.items()
            },
        }

    def _speed(self, slot: int, row: Row, earlier: Rows, formats: NumberFormats) -> int | None:
        """Return the speed of a stepper's position, steps/s; None if unknown."""
        if slot not in self.slots or not len(earlier) or earlier[0]["now_ns"] >= row["now_ns"]:
            return None
        inputs, module = self.layout.places[slot].columns("I"), self.slots[slot]
        samples = [(int(sample["scan"]), sample["words"][inputs].tolist()) for sample in (row, earlier[0])]
        position = module.quantity("position")
        if position is None or any(module.configures("I", words) for _, words in samples):
            return None  # in configuration mode the words mirror the configuration
        if not _moves(module, row["words"][inputs].tolist()):
            return 0
        present, past = (formats.value(slot, scan, position, words) for scan, words in samples)
        return round((present - past) * 1e9 / (int(row["now_ns"]) - int(earlier[0]["now_ns"])))


def _moves(module: ModuleWords, inputs: Sequence[int]) -> bool:
    """Return whether a module reports that it is moving; True if it has no status bits for this."""
    status = module.groups.get("status", {})
    moving = [status[name] for name in MOVING if name in status]
    return not moving or any(inputs[place.word] >> place.bit & 1 for place in moving)


def _levels(module: ModuleWords, inputs: Sequence[int]) -> int | None:
    """Return the levels of a machine's inputs from the module's input image; None if some are missing."""
    return inputs[1] if is_stepper(module) else None


def mode_of(flags: int) -> str:
    """Return the mode, which is run, program or test, from a scan's flags."""
    mode = CpuMode(flags & MODE_MASK)
    return mode_name(CpuMode.TEST if mode is CpuMode.SINGLE_SCAN else mode)


def changes_since(sent: Json, picture: Json) -> Json:
    """Return the parts of a picture that differ from the sent ones; update `sent` with them."""
    changes: Json = {}
    for key, value in picture.items():
        if key in SENT_BY_KEY:
            sent_entries = sent.setdefault(key, {})
            new_entries = {
                name: entry
                for name, entry in value.items()
                if name not in sent_entries or sent_entries[name] != entry
            }
            sent_entries.update(new_entries)
            if new_entries:
                changes[key] = new_entries
        elif key not in sent or sent[key] != value:
            changes[key] = sent[key] = value
    return changes


def speed_reached(rows: Any) -> float | None:
    """Return the speed of the scans in rows, as a multiple of real time; None for fewer than two rows."""
    if len(rows) < 2:
        return None
    virtual_ns = int(rows["now_ns"][-1]) - int(rows["now_ns"][0])
    wall_ns = int(rows["wall_ns"][-1]) - int(rows["wall_ns"][0])
    return round(virtual_ns / wall_ns, 4) if wall_ns > 0 else None


def count_flag(rows: Any, flag: int) -> int:
    """Return the number of rows with a flag."""
    return int(np.count_nonzero(rows["flags"] & flag))
