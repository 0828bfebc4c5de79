"""MC_Stop: stop the axis, and hold it during a `with` block."""

from __future__ import annotations

from types import TracebackType
from typing import Self

from .command import Command, Outcome
from .kinds import STOP


class Stop(Command):
    """A stop; used in a `with`, it refuses all other commands until the end of the block.

    with self.axis.stop() as stop:
        await stop
        await self.go.rises
    """

    __slots__ = ("_held",)

    def __init__(self, axis: str) -> None:
        super().__init__(axis, STOP, "stop()")
        self._held = False

    @property
    def keeps(self) -> bool:
        """Whether it holds the axis, as it does while it is running and inside its `with`."""
        return self.outcome is Outcome.BUSY or (self._held and self.outcome is not Outcome.ERROR)

    def __enter__(self) -> Self:
        self._held = True
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._held = False
