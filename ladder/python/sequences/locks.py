"""A lock, so that only one sequence at a time uses a resource."""

from __future__ import annotations

from types import TracebackType

from typing_extensions import override

from .parts import Part
from .waits import until


class Lock(Part):
    """A lock with one owner at a time; sequences get it in the order of their requests.

    async with self.zone:
        await self.axis.move_to(4000, ...)

    A free lock is taken in the same scan. The end of the block releases it, even after `Abort`.
    """

    loose = True

    def __init__(self) -> None:
        super().__init__()
        self._queue: list[object] = []

    @property
    def taken(self) -> bool:
        """Whether a sequence owns the lock."""
        return bool(self._queue)

    @override
    def reset_part(self) -> None:
        self._queue = []

    async def __aenter__(self) -> None:
        """Take the lock, or wait until it is free; an exception during the wait withdraws the request."""
        request = object()
        self._queue.append(request)
        try:
            if self._queue[0] is not request:
                await until(lambda: self._queue[0] is request, f"{self.name or 'a lock'} free")
        except BaseException:
            self._queue.remove(request)
            raise

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        del self._queue[0]
