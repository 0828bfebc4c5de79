"""Statements of structured text as instructions.

They are not in `FAMILIES`, because they never appear in rungs. `lowering.statements` converts statements to
steps with these instructions.
"""

from __future__ import annotations

from dataclasses import replace

from ..compiler.rungs import RungWriter
from ..interpreter import Interpreter
from ..model.operands import Group, Place, Resolved, width_of
from ..model.spec import Spec, Use, action, condition
from .compare import CMP
from .compute import CPT
from .control import TND

# --- bits


def _set(machine: Interpreter, target: Place, value: Resolved) -> None:
    machine.put(target, machine.condition(value))


def _write_set(rungs: RungWriter, target: Place, value: Resolved) -> None:
    text = rungs.values.condition(value)
    if target.bit is not None or target.leaf.dims:
        text = rungs.kept(text)
    rungs.values.set_bit(target, text)


# --- strings


def set_text(machine: Interpreter, target: Group, value: Resolved) -> None:
    """Set a string to another string, truncated to its size."""
    machine.set_text(target, machine.text(value))


def write_set_text(rungs: RungWriter, target: Group, value: Resolved) -> None:
    """Write the Python code for `set_text`."""
    text = rungs.values.keep(rungs.values.characters(value))
    rungs.values.set_characters(target, text)


# --- the selector of CASE, compared in the common width of selector and labels


def _select(machine: Interpreter, selector: Resolved, *labels: Resolved) -> bool:
    machine.selected = machine.number(selector, width_of(selector, *labels))
    return True


# --- the rows


def assignment(target: Place | Group, *, retentive: bool) -> Spec:
    """Return the row of an assignment; prescan and postscan clear the target of `[:=]`."""
    sign = ":=" if retentive else "[:=]"
    if isinstance(target, Group):
        return _ASSIGNMENTS["text", sign]
    return _ASSIGNMENTS["bit" if target.type.is_bool else "number", sign]


def _clear(machine: Interpreter, target: Place | Group, _value: Resolved) -> None:
    if isinstance(target, Group):
        machine.set_text(target, b"")
    else:
        machine.put(target, target.type.zero)


_ASSIGNMENTS = {
    (kind, name): action(name, *uses, run=run, write=write, prescan=clear, postscan=clear)
    for kind, uses, run, write in (
        ("bit", (Use.LATCH, Use.TRUTH), _set, _write_set),
        ("number", (Use.TARGET, Use.EXPRESSION), CPT.run, CPT.write),
        ("text", (Use.TARGET, Use.TEXT_OR_NUMBER), set_text, write_set_text),
    )
    for name, clear in ((":=", None), ("[:=]", _clear))
}

CONDITION = condition("IF", Use.TRUTH, run=CMP.run, write=CMP.write)
"""The condition of IF, ELSIF, WHILE, UNTIL and FOR, or an expression passed to an add-on instruction."""


CASE = condition(
    "CASE",
    Use.EXPRESSION,
    Use.PARAMETERS,
    run=_select,
    write=lambda rungs, *operands: rungs.values.term(operands[0], width_of(*operands)).text,
    prove=lambda machine, power, *operands: machine.select(
        power, lambda: machine.number(operands[0], width_of(*operands))
    ),
)
EXIT = action(
    "EXIT",
    run=lambda machine: machine.leave_loop(),
    write=lambda rungs: rungs.writer.line("break"),
    prove=lambda machine, power: machine.exit_loop(power),
    leaves=True,
)
RETURN = replace(TND, name="RETURN")
