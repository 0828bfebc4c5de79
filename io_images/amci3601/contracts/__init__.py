"""Contracts of the 3601: what its input images never do, one row per rule of the manual.

A proof takes a module's inputs as free words and narrows them by these rows. Random runs of the module
model and all golden recordings keep each of them; one that a run breaks is a defect of the row or of the
model.

>>> [contract.name for contract in broken(now=(0x4003, 0, 0, 0, 0, 0, 0, 0))]
['one direction']
>>> len(contracts_of({"clear_status_after_config": False})) < len(CONTRACTS)
True
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from .contract import Contract, Reach
from .fact import Fact, Reading, Side
from .rows import ROWS, TYPICAL

__all__ = ["CONTRACTS", "TYPICAL", "Contract", "Fact", "Reach", "Reading", "Side", "broken", "contracts_of"]

CONTRACTS: tuple[Contract, ...] = ROWS
"""All contracts."""


def contracts_of(
    readings: Mapping[str, object] | None = None, *, reach: Reach = Reach.OUTPUTS, adapter: bool = False
) -> tuple[Contract, ...]:
    """Return the contracts that hold for a module.

    Args:
        readings: options of the simulated 3601 that differ from the default, by name.
        reach: `Reach.OUTPUTS` if images are exchanged once in each scan, `Reach.UPDATE` if at most once,
            `Reach.IMAGE` otherwise.
        adapter: whether it is an adapter that acts as a 3601.
    """
    chosen = readings or {}
    return tuple(
        row
        for row in CONTRACTS
        if row.reach <= reach
        and (row.adapters or not adapter)
        and all(chosen.get(name, needed) == needed for name, needed in row.readings.items())
    )


def broken(
    now: Sequence[int], was: Sequence[int] | None = None, told: Sequence[int] | None = None
) -> tuple[Contract, ...]:
    """Return the contracts that images break: all if there are three, fewer without `told` or `was`."""
    reach = Reach.IMAGE if was is None else Reach.UPDATE if told is None else Reach.OUTPUTS
    nothing = (0,) * 8
    return tuple(
        row for row in contracts_of(reach=reach) if not row.fact.holds(now, was or nothing, told or nothing)
    )
