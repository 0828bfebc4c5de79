"""Ends the process while a thread of the user's program still runs; Python would wait for it forever."""

from __future__ import annotations

import os
import threading
from time import sleep

from .status import complain

GRACE_S = 2.0
"""Longest time that a thread may run after the command has ended."""

SILENT_S = 0.2
"""Time before the first message; most threads end at once."""


def end_in_time(status: object) -> None:
    """Let the process end with `status` within `GRACE_S` seconds, even if threads still run."""
    if _going_on():
        code = status if isinstance(status, int) else int(status is not None)
        threading.Thread(target=_end, args=(code,), daemon=True).start()


def _going_on() -> list[str]:
    """Return the names of the threads that Python waits for."""
    main = threading.main_thread()
    return [thread.name for thread in threading.enumerate() if thread is not main and not thread.daemon]


def _end(status: int) -> None:
    sleep(SILENT_S)
    names = ", ".join(_going_on())
    complain(f"the program's thread continues and is ended in {GRACE_S:g} s: {names}")
    sleep(GRACE_S - SILENT_S)
    os._exit(status)
