"""The cyclic garbage collector, paused while large trees are built.

Each collection goes through all objects that there are. While a program of thousands of rungs is read and
compiled, they only become more: a third of the time goes into searching them for garbage that is not there.
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def collector_paused() -> Iterator[None]:
    """Pause the collector for the time of a `with`, if it is on."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
