"""Turns a run of the prover into operator's orders on a rack, and into a scenario for `scanrack fuzz`.

    prover      scan 1      scan 2                          scan 3
    ms          0           35                              70
    rack        |  |  |  |  |  |  |  |  |  |  |  |  |  |  | |         scans of its own length
    inputs      at once     before the last or the first of the scans in between

Tags are written; words of a module's inputs are forced.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from scanrack.io_images.module_words import ModuleWords
from scanrack.ladder.model.tags import Layout
from scanrack.ladder.prove.answers import ScenarioStep, tag_text, value_text
from scanrack.ladder.prove.replaying import ScanOf
from scanrack.ladder.prove.system import Key
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.live.actions import Action, Force, Mode, Write

from ..fuzz.scenarios.scenario import OperatorAction, Scenario


@dataclass(frozen=True, slots=True)
class RackScenario:
    """Orders before scans of a rack, the number of scans, and the inputs that no order can set."""

    orders: tuple[tuple[int, Action], ...]
    scans: int
    left_out: tuple[str, ...] = ()

    def scenario(self, scan_ns: int) -> Scenario:
        """Return the orders as a scenario that `scanrack fuzz` can replay."""
        return Scenario(orders=tuple(OperatorAction(scan * scan_ns, order) for scan, order in self.orders))

    def without_forces(self) -> RackScenario:
        """Return the scenario without forces on module words."""
        kept = tuple(order for order in self.orders if not isinstance(order[1], Force))
        return RackScenario(kept, self.scans, self.left_out)

    @property
    def forced(self) -> tuple[str, ...]:
        """The module words that are forced, each once."""
        return tuple(dict.fromkeys(order.tag for _, order in self.orders if isinstance(order, Force)))


def on_scans_of(
    layout: Layout, scans: Sequence[ScanOf], scan_ns: int, *, inputs_first: bool = False
) -> RackScenario:
    """Return a run as orders on a rack with scans of `scan_ns`.

    Args:
        inputs_first: of the scans that replace a long one, inputs change before the first, not the last.
    """
    orders: list[tuple[int, Action]] = []
    begin = 0
    for number, model_scan in enumerate(scans):
        count = max(1, round(model_scan.ms * 1_000_000 / scan_ns)) if number else 0
        first = begin + (1 if inputs_first and number else count)
        if model_scan.turned:
            count = max(count, 2)
            orders.append((begin + 1, Mode("program")))
            orders.append((begin + count, Mode("run")))
            first = begin + count
        orders += [(first, order) for order in _orders(layout, model_scan.inputs)]
        begin += count
    left_out = {tag_text(layout, key) for scan in scans for key in scan.inputs if not _is_set(layout, key)}
    return RackScenario(tuple(orders), begin + 1, tuple(sorted(left_out)))


def _is_set(layout: Layout, key: Key) -> bool:
    """Whether an order can set an input; it can't set a connection fault or a hidden value."""
    leaf = layout.leaf(key[0])
    return leaf.is_image or (leaf.slot is None and not key[0].startswith(("S:", "~")))


def _orders(layout: Layout, inputs: dict[Key, Any]) -> Iterator[Action]:
    for key, value in sorted(inputs.items()):
        leaf = layout.leaf(key[0])
        if leaf.is_image:
            yield Force(f"Local:{leaf.slot}:I.Data[{key[1]}]", int(value))
        elif _is_set(layout, key):
            yield Write(tag_text(layout, key), value)


def step_text(step: ScenarioStep, spec: RackSpec) -> str:
    """Return a scan of a scenario as text, with the names of the bits in module words."""
    words = {slot.number: slot.words for slot in spec.slot}
    texts = []
    for name, value in step.changes:
        match = _WORD.fullmatch(name)
        bits = [] if match is None else _bits(words.get(int(match[1])), int(match[2]), int(value))
        texts.append(value_text(name, value) + (f" ({' '.join(bits)})" if bits else ""))
    return step.text(texts)


_WORD = re.compile(r"Local:(\d+):I\.Data\[(\d+)\]")


def _bits(words: ModuleWords | None, word: int, value: int) -> list[str]:
    """Return the names of the bits of an input word that are set."""
    return [] if words is None else [name for name, bit in words.bits("I", word) if value >> bit & 1]
