"""Runs a function in a copy of the process, where the rack, machine and program continue."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any


def can_copy() -> bool:
    """Return whether this system can copy a process; only POSIX systems can."""
    return hasattr(os, "fork")


def in_copy(work: Callable[[], str]) -> str:
    """Return the text that a function returns in a copy of the process; "" if it raises an exception."""
    system: Any = os  # type checkers on other systems don't know fork
    read, write = os.pipe()
    child: int = system.fork()
    if not child:
        os.close(read)
        try:
            os.write(write, work().encode())
        finally:
            os._exit(0)  # a function that raises returns no text
    os.close(write)
    with os.fdopen(read, "rb") as answer:
        text = answer.read().decode()
    os.waitpid(child, 0)
    return text
