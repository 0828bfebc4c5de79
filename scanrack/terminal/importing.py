"""What a command imports before it works, at the least cost."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext

from scanrack.io_images.dataclass import of_libraries_too

_own = False


def own_process() -> None:
    """Note that this process is a command's: what it imports stays until its end."""
    global _own
    _own = True


def imported() -> AbstractContextManager[None]:
    """Return a block that imports the modules of a command.

    In a process of its own nothing is searched for garbage meanwhile, and what was imported never is: Python
    would search it all at the end.
    """
    return _imported() if _own else nullcontext()


@contextmanager
def _imported() -> Iterator[None]:
    gc.disable()
    try:
        with of_libraries_too():
            yield
    finally:
        gc.freeze()
        gc.enable()
