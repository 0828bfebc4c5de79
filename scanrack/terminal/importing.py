"""What a command imports before it works, at the least cost."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

from scanrack.io_images.dataclass import of_libraries_too


@contextmanager
def imported() -> Iterator[None]:
    """Import the modules of a command inside the block.

    Meanwhile nothing is searched for garbage, and what was imported never is: modules stay until the end, at
    which Python would search them all.
    """
    gc.disable()
    try:
        with of_libraries_too():
            yield
    finally:
        gc.freeze()
        gc.enable()
