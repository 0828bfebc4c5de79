"""Waits of sequences as signals: `sequences.cycle` (a code per line and wait), `sequences.cycle.line`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial

import numpy as np

from ..read.sequence_steps import Step
from .signal import Array, Signal, SignalKind
from .stream import Block

FIELD = "sequences"
"""Prefix of the names of these signals."""

LINE = "line"
NOT_BEGUN = "not begun"
"""State of a sequence before its first step."""

Steps = Mapping[str, Sequence[Step]]
"""The steps of each sequence, in order of the scans."""


def sequence_signals(steps: Steps) -> Iterator[Signal]:
    """Yield two signals for each sequence: its wait, and the line number of the wait.

    The first signal has a code for each line and wait, in the order of their first appearance; code 0 is
    `NOT_BEGUN`.
    """
    for name, sequence_steps in steps.items():
        codes = {NOT_BEGUN: 0}
        waits = [codes.setdefault(step.label, len(codes)) for step in sequence_steps]
        scans = np.array([step.scan for step in sequence_steps], np.int64)
        names = {code: label for label, code in codes.items()}
        read_codes = partial(_values, scans, np.array([0, *waits], np.uint16))
        yield Signal(f"{FIELD}.{name}", SignalKind.CODE, read_codes, names, title=name)
        lines = np.array([0, *(step.line for step in sequence_steps)], np.int32)
        yield Signal(f"{FIELD}.{name}.{LINE}", SignalKind.NUMBER, partial(_values, scans, lines), bits=32)


def _values(scans: Array, values: Array, block: Block) -> Array:
    """Return the value in force in each scan of a block; before the first step, it is the first value."""
    in_force: Array = values[np.searchsorted(scans, block.scan, side="right")]
    return in_force
