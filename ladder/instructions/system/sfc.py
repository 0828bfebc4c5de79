"""Instructions for sequential function charts: SFR, SFP, EOT."""

from __future__ import annotations

from ...interpreter import Interpreter
from ...model.chart import STEP_TYPE, STOP_TYPE
from ...model.operand_checks import OperandError, is_logical, mismatch
from ...model.operands import Constant, Group, Resolved
from ...model.spec import Use, action
from ...model.tree import Number, Operand
from ...model.types import DINT
from ...state.lowered import OperandResolver
from ..charts import EXECUTING, NEW, PAUSED
from ..control import routine_named

EOT_STATE = "~eot"
"""Name of the leaf with the state bit that EOT returns to a transition."""


def _chart_of(resolver: OperandResolver, name: Operand) -> str:
    return routine_named(resolver, name, "write the name of a sequential function chart")


def _resolve_sfr(resolver: OperandResolver, operands: tuple[Operand, ...]) -> tuple[object, ...]:
    """Return the chart's routine, and the target step, or 0 for its initial step."""
    routine = _chart_of(resolver, operands[0])
    if isinstance(operands[1], Number) and operands[1].value == 0:
        return routine, Constant(0, DINT)
    step = resolver.any_operand(operands[1])
    if not isinstance(step, Group) or step.dims or step.type.name not in (STEP_TYPE, STOP_TYPE):
        raise mismatch(operands[1], step, "a step", "name a step or a stop, or 0")
    return routine, step


def _sfr(machine: Interpreter, routine: str, step: Group | Constant) -> None:
    """Move the chart to a step, and set the step's Reset bit."""
    chart = machine.lowered.charts[routine]
    target = chart.initial if isinstance(step, Constant) else chart.node_of(step)
    assert target is not None
    machine.put(chart.reset, target.index)
    machine.put(target.bits["Reset"], True)


_STATES = {"EXECUTING": False, "0": False, "PAUSED": True, "1": True}
"""Whether SFP pauses the chart, by its target state."""


def _resolve_sfp(resolver: OperandResolver, operands: tuple[Operand, ...]) -> tuple[object, ...]:
    """Return the chart's routine, and a key of `_STATES`."""
    word = str(operands[1]).upper()
    if word not in _STATES:
        raise OperandError(f"{operands[1]} is not a state of a chart", "write Executing or Paused")
    return _chart_of(resolver, operands[0]), word


def _sfp(machine: Interpreter, routine: str, word: str) -> None:
    """Pause a chart, or continue a paused one."""
    chart = machine.lowered.charts[routine]
    state = machine.whole(machine.get(chart.state))
    if _STATES[word]:
        machine.put(chart.state, PAUSED)
    elif state == PAUSED:
        machine.put(chart.state, EXECUTING if machine.get(chart.seen) else NEW)


def _resolve_eot(resolver: OperandResolver, operands: tuple[Operand, ...]) -> tuple[Resolved, ...]:
    """Reserve memory for the state bit; return the operand, which must be a bit."""
    resolver.kept(EOT_STATE, 0)
    bit = resolver.any_operand(operands[0])
    if not is_logical(bit):
        raise mismatch(operands[0], bit, "a bit", "name a BOOL")
    return (bit,)


SFR = action(
    "SFR",
    Use.ROUTINE,
    Use.BLOCK,
    resolve=_resolve_sfr,
    run=_sfr,
    captions=("SFC Routine Name", "Step Name"),
)
SFP = action(
    "SFP",
    Use.ROUTINE,
    Use.KEYWORD,
    resolve=_resolve_sfp,
    run=_sfp,
    captions=("SFC Routine Name", "Target State"),
)
EOT = action(
    "EOT",
    Use.TRUTH,
    resolve=_resolve_eot,
    run=lambda machine, bit: machine.set_status(EOT_STATE, int(machine.condition(bit))),
    write=lambda rungs, bit: rungs.values.set_flag(EOT_STATE, f"int({rungs.values.condition(bit)})"),
    captions=("State Bit",),
)
