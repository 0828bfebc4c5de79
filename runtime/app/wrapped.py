"""A logic around another one: attached and closed as that is."""

from __future__ import annotations

from collections.abc import Mapping

from ..loop.rack import Slot
from ..loop.scan import AttachedLogic, Logic


class Wrapped:
    """A logic that calls another one; see `AttachedLogic`."""

    def __init__(self, logic: Logic) -> None:
        self._logic = logic

    def __attach_logic__(self, slots: Mapping[int, Slot]) -> None:
        """Attach the logic inside, if it asks for that."""
        if isinstance(self._logic, AttachedLogic):
            self._logic.__attach_logic__(slots)

    def __close_logic__(self) -> None:
        """Close the logic inside, if it asks for that."""
        if isinstance(self._logic, AttachedLogic):
            self._logic.__close_logic__()
