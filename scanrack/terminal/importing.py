"""Imports the modules of a command quickly."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext

from scanrack.io_images.dataclass import of_libraries_too

_is_own_process = False


def own_process() -> None:
    """Note that this process belongs to a command and keeps its imported modules until it ends."""
    global _is_own_process
    _is_own_process = True


def imported() -> AbstractContextManager[None]:
    """Return a block that imports the modules of a command.

    In a command's own process the garbage collector pauses during the import, and then skips the imported
    objects. Otherwise it would search all of them at the end.
    """
    return _imported() if _is_own_process else nullcontext()


@contextmanager
def _imported() -> Iterator[None]:
    """Pause the garbage collector during the block, then exclude all objects from its searches."""
    gc.disable()
    try:
        with of_libraries_too():
            yield
    finally:
        gc.freeze()
        gc.enable()
