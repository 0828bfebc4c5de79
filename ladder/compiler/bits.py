"""Bit instructions: contacts, coils, one-shots."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..operands import Place
from .writer import both

if TYPE_CHECKING:
    from .steps import RungWriter


def one_shot(rungs: RungWriter, power: str, storage: Place) -> str:
    """ONS: return the power behind it; the storage bit follows the rung."""
    power = rungs.kept(power)
    passes = rungs.values.keep(both(power, f"not {rungs.values.read(storage)}"))
    rungs.values.set_bit(storage, power)
    return passes


def xic(rungs: RungWriter, bit: Place) -> str:
    """XIC: the bit itself."""
    return rungs.values.read(bit)


def xio(rungs: RungWriter, bit: Place) -> str:
    """XIO: the bit's opposite."""
    return f"not {rungs.values.read(bit)}"


def ote(rungs: RungWriter, power: str, bit: Place) -> None:
    """OTE: the bit follows the rung."""
    if bit.bit is not None or bit.leaf.dims:
        power = rungs.kept(power)
    rungs.values.set_bit(bit, power)


def osr(rungs: RungWriter, power: str, storage: Place, output: Place) -> None:
    """OSR: the output is true in the scan in which the rung becomes true."""
    power = rungs.kept(power)
    before = rungs.values.keep(rungs.values.read(storage))
    rungs.values.set_bit(storage, power)
    rungs.values.set_bit(output, rungs.kept(both(power, f"not {before}")))


def osf(rungs: RungWriter, power: str, storage: Place, output: Place) -> None:
    """OSF: the output is true in the scan in which the rung becomes false."""
    power = rungs.kept(power)
    before = rungs.values.keep(rungs.values.read(storage))
    rungs.values.set_bit(storage, power)
    rungs.values.set_bit(output, rungs.kept(both(before, f"not {power}")))
