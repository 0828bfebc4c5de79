"""What a client does when it can no longer see a motor that it has started: it stops it.

fault while watching --> stop, asked for again and again --> answered: the motor stands
                                                         --> not answered: it may still be moving
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from .link import LinkError, StoppedError


class LostSightError(LinkError):
    """A motion was started and can no longer be watched.

    Attributes:
        stopped: whether the controller has answered a stop since.
        why: what went wrong, in words.
    """

    def __init__(self, why: str, *, stopped: bool, received: bytes = b"") -> None:
        outcome = (
            "the motor was stopped" if stopped else "a stop was not answered: THE MOTOR MAY STILL BE MOVING"
        )
        super().__init__(f"{why}; {outcome}", received)
        self.stopped = stopped
        self.why = why


def try_to_stop(stop: Callable[[], None]) -> bool:
    """Stop the motor; return whether the controller has answered."""
    try:
        stop()
    except LinkError:
        return False
    return True


@contextmanager
def stopped_when_lost(stop: Callable[[], None]) -> Iterator[None]:
    """Stop the motor if the line fails meanwhile.

    Raises:
        LostSightError: the line has failed.
    """
    try:
        yield
    except (LostSightError, StoppedError):
        raise
    except LinkError as fault:
        raise LostSightError(fault.reason, stopped=try_to_stop(stop), received=fault.received) from fault
