"""Calls to add-on instructions: the base row for each definition's `Spec` [1756-PM010]."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

from ..compiler.calls import write_call
from ..compiler.rungs import RungWriter
from ..interpreter import Interpreter
from ..model.spec import Spec, always, do_nothing
from ..state.lowered import ADD_ON, AddOnCall, Node


def _run(machine: Interpreter, power: bool, call: AddOnCall) -> bool:
    """Copy the inputs, run the routine for the rung's state, copy the outputs, and return EnableOut.

    If there is no routine for the state, only copy the inputs and return false.
    """
    machine.copy_parameters(call.inputs)
    machine.put(call.enable_in, power)
    machine.put(call.enable_out, power)
    routine = call.logic if power else call.otherwise
    if routine is None:
        return False
    with machine.within(call):
        machine.call(routine, ())
    machine.copy_parameters(call.outputs)
    return machine.truth(machine.get(call.enable_out))


def _write(rungs: RungWriter, power: str, call: AddOnCall) -> str:
    """Write code that does the same as `_run`; return the expression for EnableOut."""
    power = rungs.kept(power)
    _write_copies(rungs, call.inputs)
    rungs.values.set_bit(call.enable_in, power)
    rungs.values.set_bit(call.enable_out, power)

    def write_call_of(routine: str | None) -> None:
        if routine is None:
            return
        write_call(rungs.values, routine, call)
        _write_copies(rungs, call.outputs)

    rungs.either(power, lambda: write_call_of(call.logic), lambda: write_call_of(call.otherwise))
    return rungs.values.keep(rungs.values.read(call.enable_out))


def _write_copies(rungs: RungWriter, copies: tuple[tuple[Node, ...], ...]) -> None:
    site = rungs.values.site
    for series in copies:
        rungs.series(series, "True", needed=False)
    rungs.values.site = site


def _special(machine: Interpreter, call: AddOnCall, *, prescan: bool) -> None:
    """Copy the inputs, scan Logic, run the routine for prescan or postscan, and copy the outputs."""
    machine.copy_parameters(call.inputs, prescan=prescan)
    machine.put(call.enable_in, False)
    machine.put(call.enable_out, False)
    scan, routine = (machine.prescan, call.prescan) if prescan else (machine.postscan, call.postscan)
    with machine.within(call):
        scan(call.logic)
        if routine is not None:
            machine.call(routine, ())
    machine.copy_parameters(call.outputs, prescan=prescan)


ADD_ON_CALL = always(
    ADD_ON,
    run=_run,
    write=_write,
    prove=lambda machine, power, call: machine.call_add_on(power, call),
    prescan=partial(_special, prescan=True),
    postscan=partial(_special, prescan=False),
    decides=True,
)
OFF = "__EnableInFalse"
"""Suffix in structured text of a call that runs as on a false rung: `Valve__EnableInFalse(V1);`."""

ADD_ON_OFF_CALL = always(
    ADD_ON,
    run=lambda machine, _power, call: _run(machine, False, call),
    write=lambda rungs, _power, call: _write(rungs, "False", call),
    prove=lambda machine, power, call: machine.call_add_on_off(power, call),
    postscan=do_nothing,
    decides=True,
)
"""A call that runs as on a false rung, where an ordinary call would run Logic; it does not prescan."""


def with_off_calls(specs: Mapping[str, Spec]) -> dict[str, Spec]:
    """Return add-on specs, and specs of their calls that run as on a false rung, by uppercase name."""
    off = (replace(spec, name=f"{spec.name}{OFF}") for spec in specs.values())
    return {**specs, **{spec.name.upper(): spec for spec in off}}
