"""The contents of a frame: one scan, and the changes since the last frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...io_images.amci3601.words import is_stepper
from ...io_images.image import IMAGE_BYTES
from ...io_images.module_words import ModuleWords
from ...runtime.live.ring import Row, Rows
from ...runtime.loop.scan import MODE_MASK, CpuMode, mode_name
from ...runtime.machine.spec import INPUT_NAMES
from ..history.watched_machines import PER_SLOT

Json = dict[str, Any]
WORDS_PER_IMAGE = IMAGE_BYTES // 2

DEEP = ("words", "values", "machine", "power", "tags")
"""Parts of a frame of which only changed keys are sent."""


@dataclass(frozen=True, slots=True)
class Places:
    """The layout of a row."""

    slots: Mapping[int, ModuleWords]
    machines: Sequence[int]

    def of(self, row: Row, before: Rows, *, past: bool = False) -> Json:
        """Return a frame's contents about the images and machines of a row.

        Args:
            before: an earlier row, for speeds; or none.
            past: the row is not the latest one, so that shaft and encoder are unknown: machines are read
                only at
                intervals, and a trace has no figures at all.
        """
        words = row["words"].tolist()
        shown: Json = {"words": {}, "values": {}, "machine": {}}
        for place, (slot, names) in enumerate(self.slots.items()):
            at = 2 * place * WORDS_PER_IMAGE
            outputs, inputs = (
                words[at : at + WORDS_PER_IMAGE],
                words[at + WORDS_PER_IMAGE :][:WORDS_PER_IMAGE],
            )
            shown["words"][str(slot)] = [*inputs, *outputs]
            if is_stepper(names):
                shown["values"][str(slot)] = _values(inputs, outputs)
        figures = row["figures"].tolist()
        past = past or not row["wall_ns"]  # a row of a trace
        for place, slot in enumerate(self.machines):
            shaft, encoder, levels = figures[PER_SLOT * place :][:PER_SLOT]
            configured = shown["words"][str(slot)][0] >= 0
            values = shown["values"].get(str(slot), {}) if configured else {}
            if past:
                shaft = encoder = None
                levels = shown["words"][str(slot)][1]  # status LSW: the levels as the module reads them
            known = configured or not past  # a configuration's mirror has no levels
            commanded = shown["words"][str(slot)][WORDS_PER_IMAGE] >= 0  # else these words configure
            shown["machine"][str(slot)] = {
                "position": values.get("position"),
                "shaft": shaft,
                "encoder": encoder,
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
        at = (2 * list(self.slots).index(slot) + 1) * WORDS_PER_IMAGE + 2
        if row["words"][at - 2] < 0 or before[0]["words"][at - 2] < 0:
            return None  # in configuration mode these words are a mirror
        now, then = (int(each["words"][at]) * 1000 + int(each["words"][at + 1]) for each in (row, before[0]))
        return round((now - then) * 1e9 / (int(row["now_ns"]) - int(before[0]["now_ns"])))


def _values(inputs: Sequence[int], outputs: Sequence[int]) -> Json:
    """Return the values in the words of a 3601 in command mode [chapters 5 and 6]."""
    return {
        "position": inputs[2] * 1000 + inputs[3],
        "encoder": inputs[4] * 1000 + inputs[5],
        "captured": inputs[6] * 1000 + inputs[7],
        "target": outputs[2] * 1000 + outputs[3],
        "speed": outputs[4] * 1000 + outputs[5],
        "acceleration": outputs[6],
        "deceleration": outputs[7],
    }


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
