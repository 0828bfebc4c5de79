"""MC_Stop: stop the axis, and hold it during a `with` block."""

from __future__ import annotations

from types import TracebackType
from typing import Self

from .command import Command, Outcome
from .kinds import STOP


class Stop(Command):
    """A stop; when used in a `with`, it refuses all other commands until the end of the block.

    with self.axis.stop() as stop:
        await stop
        await self.go.rises
    """

    __slots__ = ("_in_block",)

    def __init__(self, axis: str) -> None:
        super().__init__(axis, STOP, "stop()")
        self._in_block = False

    @property
    def holds(self) -> bool:
        """Whether it is holding the axis, which it does while it is running and inside its `with`."""
        return self.outcome is Outcome.BUSY or (self._in_block and self.outcome is not Outcome.ERROR)

    def __enter__(self) -> Self:
        self._in_block = True
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._in_block = False
