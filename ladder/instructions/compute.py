"""Compute instructions, and the conversion TRN."""

from __future__ import annotations

from typing import Any

from ..compiler.rungs import RungWriter
from ..compiler.terms import Term
from ..interpreter import Interpreter
from ..model.operands import Place, Resolved, width_of
from ..model.spec import Spec, Use, action


def computation(name: str, operator: str, *operands: Use, **parts: Any) -> Spec:
    """Return the row of an instruction that stores an operator's result in its last operand."""
    return action(
        name,
        *operands,
        Use.TARGET,
        run=lambda machine, *resolved: machine.compute(operator, resolved[:-1], resolved[-1]),
        write=lambda rungs, *resolved: rungs.values.compute(operator, resolved[:-1], resolved[-1]),
        **parts,
    )


BINARY: dict[str, Any] = {"captions": ("Source A", "Source B", "Dest"), "instead": "write an expression"}
UNARY: dict[str, Any] = {"captions": ("Source", "Dest"), "instead": "write an expression"}
ASSIGNED = "write an assignment"
SOURCE_DEST: dict[str, Any] = UNARY | {"instead": ASSIGNED}


def store_expression(machine: Interpreter, target: Place, expression: Resolved) -> None:
    """Store the value of an expression."""
    machine.clear_flags()
    machine.store(target, machine.number(expression, width_of(expression, target)))


# --- TRN: truncate a REAL


def _trn(machine: Interpreter, source: Resolved, target: Place) -> None:
    """Store a number truncated to an integer; record an overflow if it is infinite or NaN."""
    machine.clear_flags()
    value = machine.number(source, width_of(source))
    if machine.is_float(value):
        if machine.is_infinite(value) or machine.is_nan(value):
            machine.fault_log.overflow(machine.site)
        value = machine.truncated(value)
    machine.store(target, value)


def _write_trn(rungs: RungWriter, source: Resolved, target: Place) -> None:
    """Write code that does the same as `_trn`."""
    rungs.values.clear_flags()
    term = rungs.values.term(source, width_of(source))
    if term.real:
        # the range is that of a float
        term = Term(f"cut({rungs.values.site}, {term.text})", -(1 << 1024), 1 << 1024)
    rungs.values.store_wide(target, term)


# --- the rows

CPT = action(
    "CPT",
    Use.TARGET,
    Use.EXPRESSION,
    run=store_expression,
    write=lambda rungs, target, expression: rungs.values.expression(target, expression),
    captions=("Dest", "Expression"),
    instead=ASSIGNED,
)
ADD = computation("ADD", "+", Use.NUMBER, Use.NUMBER, **BINARY)
SUB = computation("SUB", "-", Use.NUMBER, Use.NUMBER, **BINARY)
MUL = computation("MUL", "*", Use.NUMBER, Use.NUMBER, **BINARY)
DIV = computation("DIV", "/", Use.NUMBER, Use.NUMBER, **BINARY)
MOD = computation("MOD", "MOD", Use.NUMBER, Use.NUMBER, **BINARY)
SQR = computation("SQR/SQRT", "SQR", Use.NUMBER, **SOURCE_DEST)
NEG = computation("NEG", "NEG", Use.NUMBER, **UNARY)
ABS = computation("ABS", "ABS", Use.NUMBER, **SOURCE_DEST)
TRN = action("TRN/TRUNC", Use.NUMBER, Use.TARGET, run=_trn, write=_write_trn, **SOURCE_DEST)
