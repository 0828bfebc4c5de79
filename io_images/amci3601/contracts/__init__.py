"""Contracts of the 3601: facts that are always true for its images, one row per rule of the manual.

A proof treats a module's inputs as free words and restricts them by these rows. Tests check the contracts in
random runs of the module model and in all golden recordings. If a run breaks a contract, the row or the model
is wrong.

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
    """Return the contracts that apply to a module.

    Args:
        readings: options of the simulated 3601 that differ from the default, by name.
        each_update: whether the program sees every update of the module; if not, only contracts about a
            single image apply.
        adapter: whether the module is an adapter that acts as a 3601.
    """
    changed_readings = readings or {}

    def keeps(contract: Contract) -> bool:
        """Return whether a contract applies to the module; some contracts need certain values of options."""
        if contract.needs_two_images and not each_update:
            return False
        if adapter and not contract.adapters:
            return False
        # an option that was not changed has the value that the contract needs
        return all(changed_readings.get(name, value) == value for name, value in contract.readings.items())

    return tuple(filter(keeps, CONTRACTS))


def broken(
    now: Sequence[int], was: Sequence[int] | None = None, sent: Sequence[int] = (0,) * 8
) -> tuple[Contract, ...]:
    """Return the contracts that images break; without `was`, check only contracts about a single image."""
    rows = contracts_of(each_update=was is not None)
    return tuple(row for row in rows if not row.fact.holds(now, was or (0,) * 8, sent))
