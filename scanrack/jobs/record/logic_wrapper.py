"""Logic that wraps other logic, and attaches and closes it."""

from __future__ import annotations

from collections.abc import Mapping

from scanrack.runtime.loop.rack import Slot
from scanrack.runtime.loop.scan import LogicScan, ScanLogic, attached


class LogicWrapper:
    """Logic that calls other logic; see `AttachedLogic`."""

    def __init__(self, logic: ScanLogic) -> None:
        self._logic = logic

    def __call__(self, scan: LogicScan) -> object:
        """Call the inner logic."""
        return self._logic(scan)

    def __attach_logic__(self, slots: Mapping[int, Slot]) -> None:
        """Attach the inner logic, if it supports that."""
        if (inner_logic := attached(self._logic)) is not None:
            inner_logic.__attach_logic__(slots)

    def __close_logic__(self) -> None:
        """Close the inner logic, if it supports that."""
        if (inner_logic := attached(self._logic)) is not None:
            inner_logic.__close_logic__()


def unwrapped(logic: ScanLogic) -> ScanLogic:
    """Return the innermost logic."""
    while isinstance(logic, LogicWrapper):
        logic = logic._logic
    return logic
