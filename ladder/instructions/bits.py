"""Bit instructions: contacts, coils, one-shots."""

from __future__ import annotations

from ..compiler.rungs import RungWriter
from ..compiler.writer import both
from ..interpreter import Interpreter
from ..model.operands import Place
from ..model.spec import Spec, Use, action, always, condition, do_nothing

# --- contacts and coils


def _write_ote(rungs: RungWriter, power: str, bit: Place) -> None:
    if bit.bit is not None or bit.leaf.dims:
        power = rungs.kept(power)
    rungs.values.set_bit(bit, power)


# --- one-shots: the storage bit has the rung's state in the last scan


def _ons(machine: Interpreter, power: bool, storage: Place) -> bool:
    passes = power and not machine.get(storage)
    machine.put(storage, power)
    return passes


def _write_ons(rungs: RungWriter, power: str, storage: Place) -> str:
    power = rungs.kept(power)
    passes = rungs.values.keep(both(power, f"not {rungs.values.read(storage)}"))
    rungs.values.set_bit(storage, power)
    return passes


def _edge_row(name: str, instead: str, *, rising: bool) -> Spec:
    """Return the row of OSR or OSF; the output is true for one scan when the rung becomes true or false."""

    def run(machine: Interpreter, power: bool, storage: Place, output: Place) -> None:
        was_on = machine.truth(machine.get(storage))
        machine.put(storage, power)
        machine.put(output, power and not was_on if rising else was_on and not power)

    def write(rungs: RungWriter, power: str, storage: Place, output: Place) -> None:
        power = rungs.kept(power)
        was_on = rungs.values.keep(rungs.values.read(storage))
        rungs.values.set_bit(storage, power)
        fires = both(power, f"not {was_on}") if rising else both(was_on, f"not {power}")
        rungs.values.set_bit(output, rungs.kept(fires))

    def prescan(machine: Interpreter, storage: Place, output: Place) -> None:
        machine.put(storage, rising)
        machine.put(output, False)

    back_ends = {"run": run, "write": write, "prescan": prescan, "postscan": do_nothing}
    return always(name, Use.STORAGE, Use.COIL, **back_ends, captions=("Storage", "Output"), instead=instead)


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
    run=lambda machine, power, bit: machine.put(bit, power),
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
OSR = _edge_row("OSR", "use OSRI", rising=True)
OSF = _edge_row("OSF", "use OSFI", rising=False)
