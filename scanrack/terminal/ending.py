"""Ends a process that Python would keep alive because of a thread in the user's program."""

from __future__ import annotations

import os
import threading
from time import sleep

from .status import complain

GRACE_S = 2.0
"""Maximum time that a thread may run after the command has ended, s."""

SILENT_S = 0.2
"""Time before the first message, s; most threads end at once."""


def end_in_time(status: object) -> None:
    """Let the process end with `status` within `GRACE_S` seconds, even if threads still run."""
    if _running_threads():
        code = status if isinstance(status, int) else int(status is not None)
        threading.Thread(target=_end_process, args=(code,), daemon=True).start()


def _running_threads() -> list[str]:
    """Return the names of the threads that Python waits for."""
    main = threading.main_thread()
    return [thread.name for thread in threading.enumerate() if thread is not main and not thread.daemon]


def _end_process(status: int) -> None:
    """Give threads of the program `GRACE_S` seconds, with a message; then end the process with them."""
    sleep(SILENT_S)
    names = ", ".join(_running_threads())
    complain(f"threads of the program still run, and are ended in {GRACE_S:g} s: {names}")
    sleep(GRACE_S - SILENT_S)
    os._exit(status)
