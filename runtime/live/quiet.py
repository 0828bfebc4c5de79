"""What a server's process keeps from the user's terminal, and gives back to the system."""

from __future__ import annotations

import ctypes
import gc
import logging
import sys

CLIENT_LOGS = ("asyncio", "asyncua", "websockets")
"""Loggers of the libraries that talk to clients."""


def quiet(*libraries: str) -> None:
    """Let libraries log nothing: what a client sends is no news to the user, and our messages tell the rest.

    Args:
        libraries: names of their loggers; those below them are meant, too.
    """
    for name in [*libraries, *logging.root.manager.loggerDict]:
        if name.partition(".")[0] in libraries:
            logger = logging.getLogger(name)
            logger.handlers[:] = [logging.NullHandler()]
            logger.propagate = False


def give_back_memory() -> None:
    """Give unused memory back to the system; glibc keeps what is between used blocks until it is trimmed."""
    gc.collect()
    if sys.platform == "linux":
        trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
        if trim is not None:
            trim(0)
