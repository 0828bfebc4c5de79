"""The cyclic garbage collector, paused while large trees are built.

Each collection visits all live objects. While a program of thousands of rungs is read and compiled, nothing
becomes garbage, and collections take a third of the time. What a large tree leaves is then declared old, as
if it had survived them: otherwise the next collection would visit all of it at once. The collector does not
count this, so old garbage would stay: after every few large trees, all garbage is collected.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count

LARGE = 100_000
"""Number of new objects above which a tree counts as large: visiting them takes tens of ms."""

COLLECTED = 8
"""Large trees after which all garbage is collected."""

_large = count(1)


@contextmanager
def collector_paused() -> Iterator[None]:
    """Pause the collector inside a `with`, if it is on."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            if (
                gc.get_count()[0] > LARGE and not gc.get_freeze_count()
            ):  # what other code has frozen stays frozen
                if next(_large) % COLLECTED:
                    gc.freeze()
                    gc.unfreeze()
                else:
                    gc.collect()
            gc.enable()
