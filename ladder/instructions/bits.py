"""Bit instructions: contacts, coils, one-shots."""

from __future__ import annotations

from ..compiler.rungs import RungWriter
from ..compiler.writer import both
from ..interpreter import Interpreter
from ..model.operands import Place
from ..model.spec import Use, action, always, condition

# --- contacts and coils


def _ote(machine: Interpreter, power: bool, bit: Place) -> None:
    machine.put(bit, power)


def _write_ote(rungs: RungWriter, power: str, bit: Place) -> None:
    if bit.bit is not None or bit.leaf.dims:
        power = rungs.kept(power)
    rungs.values.set_bit(bit, power)


# --- one-shots: the storage bit holds the rung's state of the last scan


def _ons(machine: Interpreter, power: bool, storage: Place) -> bool:
    passes = power and not machine.get(storage)
    machine.put(storage, power)
    return passes


def _write_ons(rungs: RungWriter, power: str, storage: Place) -> str:
    power = rungs.kept(power)
    passes = rungs.values.keep(both(power, f"not {rungs.values.read(storage)}"))
    rungs.values.set_bit(storage, power)
    return passes


def _osr(machine: Interpreter, power: bool, storage: Place, output: Place) -> None:
    before = machine.get(storage)
    machine.put(storage, power)
    machine.put(output, power and not before)


def _write_osr(rungs: RungWriter, power: str, storage: Place, output: Place) -> None:
    power = rungs.kept(power)
    before = rungs.values.keep(rungs.values.read(storage))
    rungs.values.set_bit(storage, power)
    rungs.values.set_bit(output, rungs.kept(both(power, f"not {before}")))


def _prescan_osr(machine: Interpreter, storage: Place, output: Place) -> None:
    machine.put(storage, True)
    machine.put(output, False)


def _osf(machine: Interpreter, power: bool, storage: Place, output: Place) -> None:
    before = machine.get(storage)
    machine.put(storage, power)
    machine.put(output, bool(before) and not power)


def _write_osf(rungs: RungWriter, power: str, storage: Place, output: Place) -> None:
    power = rungs.kept(power)
    before = rungs.values.keep(rungs.values.read(storage))
    rungs.values.set_bit(storage, power)
    rungs.values.set_bit(output, rungs.kept(both(before, f"not {power}")))


def _prescan_osf(machine: Interpreter, storage: Place, output: Place) -> None:
    machine.put(storage, False)
    machine.put(output, False)


# --- the rows

XIC = condition(
    "XIC",
    Use.BIT,
    run=lambda machine, bit: machine.get(bit),
    write=lambda rungs, bit: rungs.values.read(bit),
    symbol="┤ ├",
)
XIO = condition(
    "XIO",
    Use.BIT,
    run=lambda machine, bit: not machine.get(bit),
    write=lambda rungs, bit: f"not {rungs.values.read(bit)}",
    symbol="┤/├",
)
OTE = always(
    "OTE",
    Use.COIL,
    run=_ote,
    write=_write_ote,
    prescan=lambda machine, bit: machine.put(bit, False),
    symbol="( )",
    instead="write bit := condition;",
)
OTL = action(
    "OTL",
    Use.LATCH,
    run=lambda machine, bit: machine.put(bit, True),
    write=lambda rungs, bit: rungs.values.set_bit(bit, "True"),
    symbol="(L)",
    instead="write IF condition THEN bit := 1; END_IF;",
)
OTU = action(
    "OTU",
    Use.LATCH,
    run=lambda machine, bit: machine.put(bit, False),
    write=lambda rungs, bit: rungs.values.set_bit(bit, "False"),
    symbol="(U)",
    instead="write IF condition THEN bit := 0; END_IF;",
)
ONS = condition(
    "ONS",
    Use.STORAGE,
    run=_ons,
    write=_write_ons,
    prescan=lambda machine, storage: machine.put(storage, True),
    decides=True,
    symbol="[ONS]",
)
OSR = always(
    "OSR",
    Use.STORAGE,
    Use.COIL,
    run=_osr,
    write=_write_osr,
    prescan=_prescan_osr,
    captions=("Storage", "Output"),
    instead="use OSRI",
)
OSF = always(
    "OSF",
    Use.STORAGE,
    Use.COIL,
    run=_osf,
    write=_write_osf,
    prescan=_prescan_osf,
    captions=("Storage", "Output"),
    instead="use OSFI",
)
