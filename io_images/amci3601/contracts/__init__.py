"""Contracts of the 3601: facts that its input images always keep, one row per rule of the manual.

A proof treats a module's inputs as free words and restricts them by these rows. Random runs of the module
model and all golden recordings keep each contract; if a run breaks one, the defect is in the row or in the
model.

>>> [contract.name for contract in broken(now=(0x4003, 0, 0, 0, 0, 0, 0, 0))]
['one direction']
>>> len(contracts_of({"clear_status_after_config": False})) < len(CONTRACTS)
True
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from .contract import Contract
from .fact import Fact, Reading, Side
from .rows import ROWS, TYPICAL

__all__ = ["CONTRACTS", "TYPICAL", "Contract", "Fact", "Reading", "Side", "broken", "contracts_of"]

CONTRACTS: tuple[Contract, ...] = ROWS
"""All contracts."""


def contracts_of(
    readings: Mapping[str, object] | None = None, *, each_update: bool = True, adapter: bool = False
) -> tuple[Contract, ...]:
    """Return the contracts that hold for a module.

    Args:
        readings: options of the simulated 3601 that differ from the default, by name.
        each_update: whether the program sees each update of the module; if not, only contracts about a single
            image hold.
        adapter: whether the module is an adapter that acts as a 3601.
    """
    chosen_readings = readings or {}
    return tuple(
        row
        for row in CONTRACTS
        if (each_update or not row.needs_two_images)
        and (row.adapters or not adapter)
        and all(chosen_readings.get(name, needed) == needed for name, needed in row.readings.items())
    )


def broken(
    now: Sequence[int], was: Sequence[int] | None = None, sent: Sequence[int] = (0,) * 8
) -> tuple[Contract, ...]:
    """Return the contracts that images break; without `was`, check only contracts about a single image."""
    rows = contracts_of(each_update=was is not None)
    return tuple(row for row in rows if not row.fact.holds(now, was or (0,) * 8, sent))
