"""Logging and memory of a server process."""

from __future__ import annotations

import ctypes
import gc
import logging
import sys

CLIENT_LOGS = ("asyncio", "asyncua", "websockets")
"""Loggers of the libraries that communicate with clients."""


def quiet(*libraries: str) -> None:
    """Turn off the logging of libraries, since clients' requests don't concern the user.

    Args:
        libraries: names of the libraries' loggers; child loggers are included.
    """
    for name in [*libraries, *logging.root.manager.loggerDict]:
        if name.partition(".")[0] in libraries:
            logger = logging.getLogger(name)
            logger.handlers[:] = [logging.NullHandler()]
            logger.propagate = False


def give_back_memory() -> None:
    """Return unused memory to the system; glibc keeps free memory between used blocks until trimmed."""
    gc.collect()
    if sys.platform == "linux":
        trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
        if trim is not None:
            trim(0)
