"""The cyclic garbage collector, paused while large trees are built.

Each collection visits all live objects. Reading and compiling a program of thousands of rungs creates no
garbage, yet collections take a third of the time. After the pause, all objects move to the oldest generation.
Otherwise the next collection would visit the whole tree at once. The collector does not count
this move, so old garbage would remain. A full collection therefore runs after every few large trees.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count

LARGE = 100_000
"""Number of new objects above which a tree is large, because visiting them takes tens of ms."""

COLLECTED = 8
"""Number of large trees after which all garbage is collected."""

_large_trees = count(1)


@contextmanager
def collector_paused() -> Iterator[None]:
    """Pause the collector, if it is on, inside a `with`."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            frozen_elsewhere = gc.get_freeze_count() > 0  # `unfreeze` would unfreeze these objects
            if gc.get_count()[0] > LARGE and not frozen_elsewhere:
                if next(_large_trees) % COLLECTED:
                    gc.freeze()
                    gc.unfreeze()
                else:
                    gc.collect()
            gc.enable()
