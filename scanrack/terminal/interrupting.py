"""Ends a command when a signal arrives."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from scanrack.runtime.loop.pace import ending_as_interrupt, interrupted_by

from .status import INTERRUPTED, complain


@contextmanager
def interrupted() -> Iterator[None]:
    """End a command with one message when a signal to end the process arrives.

    The command completes its work, such as a trace, before it ends.

    Raises:
        SystemExit: the command was interrupted.
    """
    with ending_as_interrupt():
        try:
            yield
        except KeyboardInterrupt:
            raise SystemExit(complain(f"stopped by {interrupted_by()}", INTERRUPTED)) from None
