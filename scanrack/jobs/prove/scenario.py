"""Turns a run of the prover into operator actions on a rack, and into a scenario for `scanrack fuzz`.

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
    """A run of the prover on a rack."""

    orders: tuple[tuple[int, Action], ...]  # operator actions, each with the scan that follows it
    scans: int  # number of scans
    left_out: tuple[str, ...] = ()  # inputs that no action can set

    def scenario(self, scan_ns: int) -> Scenario:
        """Return the operator actions as a scenario that `scanrack fuzz` can replay."""
        return Scenario(orders=tuple(OperatorAction(scan * scan_ns, order) for scan, order in self.orders))

    def without_forces(self) -> RackScenario:
        """Return the scenario without forces on module words."""
        kept = tuple((scan, order) for scan, order in self.orders if not isinstance(order, Force))
        return RackScenario(kept, self.scans, self.left_out)

    @property
    def forced(self) -> tuple[str, ...]:
        """The module words that are forced, without duplicates."""
        return tuple(dict.fromkeys(order.tag for _, order in self.orders if isinstance(order, Force)))


def on_scans_of(
    layout: Layout, scans: Sequence[ScanOf], scan_ns: int, *, inputs_first: bool = False
) -> RackScenario:
    """Return a run as operator actions on a rack with scans of `scan_ns`.

    Args:
        inputs_first: whether inputs change before the first of the scans that replace a long one; otherwise,
            they change before the last.
    """
    orders: list[tuple[int, Action]] = []
    last_scan = 0  # the rack's scan for the previous scan of the prover
    for number, model_scan in enumerate(scans):
        count = max(1, round(model_scan.ms * 1_000_000 / scan_ns)) if number else 0
        inputs_scan = last_scan + (1 if inputs_first and number else count)
        if model_scan.turned:
            count = max(count, 2)
            orders.append((last_scan + 1, Mode("program")))
            orders.append((last_scan + count, Mode("run")))
            inputs_scan = last_scan + count
        orders += [(inputs_scan, order) for order in _orders(layout, model_scan.inputs)]
        last_scan += count
    keys = {key for model_scan in scans for key in model_scan.inputs}
    left_out = sorted({tag_text(layout, key) for key in keys if not _can_set(layout, key)})
    return RackScenario(tuple(orders), last_scan + 1, tuple(left_out))


def _can_set(layout: Layout, key: Key) -> bool:
    """Return whether an operator action can set an input (not a connection fault or hidden value)."""
    path, _ = key
    leaf = layout.leaf(path)
    return leaf.is_image or (leaf.slot is None and not path.startswith(("S:", "~")))


def _orders(layout: Layout, inputs: dict[Key, Any]) -> Iterator[Action]:
    """Yield the operator actions that set inputs: forces of module words, and writes of tags."""
    for key, value in sorted(inputs.items()):
        path, index = key
        leaf = layout.leaf(path)
        if leaf.is_image:
            yield Force(f"Local:{leaf.slot}:I.Data[{index}]", int(value))
        elif _can_set(layout, key):
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
