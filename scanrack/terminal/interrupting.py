"""The end of a command by a signal."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from scanrack.runtime.loop.pace import ending_as_interrupt, interrupted_by

from .status import INTERRUPTED, complain


@contextmanager
def interrupted() -> Iterator[None]:
    """Let a signal that ends the process interrupt a command, with one message.

    Commands with unfinished work, such as a trace, complete it on their way out.

    Raises:
        SystemExit: the command was interrupted.
    """
    with ending_as_interrupt():
        try:
            yield
        except KeyboardInterrupt:
            raise SystemExit(complain(f"stopped by {interrupted_by()}", INTERRUPTED)) from None
