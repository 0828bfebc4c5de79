"""Reduces a run to the inputs that break a property, without the solver's arbitrary choices.

First, each value is dropped in all scans at once. Then single bits of module words are cleared. The
program runs again after each step. If the run no longer breaks the property, the step is undone.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import islice

from ..lowering.runnable import LadderLogic
from ..model.errors import LadderFault
from ..model.tags import Layout
from ..run.edit import started_again
from ..run.engine import Engine
from .contracts import KeptBy
from .monitors import run_claims
from .replaying import ScanOf
from .system import Key

MOST_RUNS = 150
"""Maximum number of runs of the program."""

BITS = 16


def smallest(
    program: LadderLogic,
    scans: Sequence[ScanOf],
    bit: Key,
    assume: Sequence[Key] = (),
    modules: Sequence[KeptBy] = (),
) -> tuple[ScanOf, ...]:
    """Return a run with fewer inputs whose last scan still sets a bit.

    Args:
        assume: bits that must be set in each scan.
        modules: contracts that the inputs must keep.
    """
    simplest, layout = tuple(scans), program.build().layout
    for simpler in islice(_simplifications(layout, simplest), MOST_RUNS):
        simplified = simpler(simplest)
        if simplified != simplest and breaks(program, simplified, bit, assume, modules):
            simplest = simplified
    return simplest


def _simplifications(
    layout: Layout, scans: Sequence[ScanOf]
) -> Iterator[Callable[[Sequence[ScanOf]], tuple[ScanOf, ...]]]:
    """Yield functions that simplify a run: stay in run mode, drop an input, or clear a bit of a word."""
    for number, scan in enumerate(scans):
        if scan.turned or scan.again:
            yield partial(_in_run, number)
    for key in _keys(scans):
        yield partial(_dropped, key)
    for key in _keys(scans):
        if layout.leaf(key[0]).is_image:
            for number in range(BITS):
                yield partial(_masked, key, 1 << number)


def _keys(scans: Sequence[ScanOf]) -> list[Key]:
    """Return the inputs of a run, inputs of modules first."""
    keys = {key for scan in scans for key in scan.inputs}
    return sorted(keys, key=lambda key: (not key[0].startswith("LOCAL:"), key))


def _in_run(number: int, scans: Sequence[ScanOf]) -> tuple[ScanOf, ...]:
    return (*scans[:number], replace(scans[number], turned=False, again=False), *scans[number + 1 :])


def _dropped(key: Key, scans: Sequence[ScanOf]) -> tuple[ScanOf, ...]:
    return tuple(_without(scan, key) for scan in scans)


def _without(scan: ScanOf, key: Key) -> ScanOf:
    return replace(scan, inputs={name: value for name, value in scan.inputs.items() if name != key})


def _masked(key: Key, mask: int, scans: Sequence[ScanOf]) -> tuple[ScanOf, ...]:
    """Return the scans with some bits of a word cleared; drop entries that no longer change the word."""
    last_value, masked = 0, []
    for scan in scans:
        value = scan.inputs.get(key)
        word = last_value & 0xFFFF if value is None else int(value) & 0xFFFF & ~mask
        new_value = word - 0x10000 if word >= 0x8000 else word
        masked.append(
            _without(scan, key)
            if new_value == last_value
            else replace(scan, inputs={**scan.inputs, key: new_value})
        )
        last_value = new_value
    return tuple(masked)


def breaks(
    program: LadderLogic,
    scans: Sequence[ScanOf],
    bit: Key,
    assume: Sequence[Key],
    modules: Sequence[KeptBy] = (),
) -> bool:
    """Run the scans; return whether the last one sets a bit and every scan sets the assumed bits."""
    engine = program.compile()
    watches = [module.watch(engine) for module in modules]
    for number, scan in enumerate(scans):
        if scan.again:
            engine = started_again(engine, program.compile())
        scan.write_inputs(engine)
        if scan.turned or scan.again:
            watches = [module.watch(engine) for module in modules]
        if not all(keeps() for keeps in watches):
            return False
        try:
            scan.do(engine)
        except LadderFault:
            if number + 1 < len(scans):
                return False
            run_claims(engine)
        if not _are_set(engine, assume):
            return False
    return _are_set(engine, [bit])


def _are_set(engine: Engine, bits: Iterable[Key]) -> bool:
    """Return whether all bits are true now."""
    layout, memory = engine.lowered.layout, engine.memory
    return all(memory.read(layout.leaf(path), index) for path, index in bits)
