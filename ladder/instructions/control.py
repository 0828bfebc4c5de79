"""Program control: jumps, routines, MCR."""

from __future__ import annotations

from ..compiler.rungs import RungWriter
from ..interpreter import Interpreter
from ..lowered import Call, OperandResolver
from ..operand_checks import OperandError
from ..operands import Place, Resolved
from ..spec import Use, action, always, condition
from ..tags import OVERRIDE
from ..tree import Address, Number, Operand

__all__ = ["JMP", "LBL", "JSR", "RET", "SBR", "TND", "MCR", "AFI", "NOP"]  # noqa: RUF022


def _write_jmp(rungs: RungWriter, label: str) -> None:
    if rungs.sections[label] <= rungs.section:
        rungs.writer.line(f"jumped_back({rungs.values.site})")
    rungs.writer.line(f"at = {rungs.sections[label]}")
    rungs.writer.line("continue")


# --- JSR: call a routine, of rungs or in Python, and take its answers


def _resolve_jsr(resolver: OperandResolver, given: tuple[Operand, ...]) -> tuple[Call]:
    name = given[0]
    if not isinstance(name, Address) or name.steps:
        raise OperandError(f"{name} is not a routine", "write the routine's name")
    count = 0
    if len(given) > 1:
        number = given[1]
        if not isinstance(number, Number) or number.value not in range(len(given) - 1):
            raise OperandError(f"{number} is not the number of inputs", f"allowed are 0 to {len(given) - 2}")
        count = int(number.value)
    if count == 0 and [str(each) for each in given[2:]] == ["0"]:
        given = given[:2]  # JSR(Sub,0,0), as some exports have it: neither inputs nor returns
    inputs = tuple(map(resolver.value, given[2 : 2 + count]))
    return (Call(resolver.named(name.name), inputs, tuple(map(resolver.target, given[2 + count :]))),)


def _jsr(machine: Interpreter, call: Call) -> None:
    inputs = [machine.value(each) for each in call.inputs]
    recursive = call.routine in machine.lowered.recursive
    if recursive:
        machine.fault_log.called(machine.site)
    answers = machine.call(call.routine, inputs)
    if recursive:
        machine.fault_log.returned()
    machine.take(call.returns, answers)


def _prescan_jsr(machine: Interpreter, call: Call) -> None:
    """Prescan the routine, one that calls itself once."""
    if call.routine in machine.prescanned:
        return
    if call.routine in machine.lowered.recursive:
        machine.prescanned.add(call.routine)
    machine.prescan(call.routine)
    machine.prescanned.discard(call.routine)


def _write_jsr(rungs: RungWriter, call: Call) -> None:
    inputs = "".join(f"{_plain(rungs, each)}, " for each in call.inputs)
    if call.routine in rungs.writer.lowered.functions:
        text = f"python({call.routine!r}, ({inputs}))"
    else:
        text = f"{rungs.functions[call.routine]}(now, ({inputs}))"
    recursive = call.routine in rungs.writer.lowered.recursive
    if recursive:
        rungs.writer.line(f"called({rungs.values.site})")
    answers = ""
    if call.returns:
        answers = rungs.values.keep(f"{text} or ()")
    else:
        rungs.writer.line(text)
    if recursive:
        rungs.writer.line("returned()")
    for number, place in enumerate(call.returns):
        with rungs.writer.block(f"if len({answers}) > {number}:"):
            _take(rungs, place, f"{answers}[{number}]")


def _plain(rungs: RungWriter, operand: Resolved) -> str:
    return rungs.values.leaf_term(operand).text


def _take(rungs: RungWriter, place: Place, text: str) -> None:
    """Write a parameter into its tag."""
    rungs.values.clear_flags()
    kind = place.type
    value = rungs.values.keep(f"answer({rungs.values.site}, {text}, {kind.name!r})")
    if kind.is_bool:
        rungs.values.set_bit(place, value)
        return
    rungs.values.assign(place, value)
    if rungs.writer.flags:
        rungs.values.result_flags(place)


# --- RET and SBR: values out of a routine and into it


def _resolve_ret(resolver: OperandResolver, given: tuple[Operand, ...]) -> tuple[Resolved, ...]:
    return tuple(map(resolver.value, given))


def _ret(machine: Interpreter, *values: Resolved) -> None:
    machine.leave(tuple(map(machine.value, values)))


def _write_ret(rungs: RungWriter, *values: Resolved) -> None:
    rungs.writer.line(f"return ({''.join(f'{_plain(rungs, each)}, ' for each in values)})")


def _resolve_sbr(resolver: OperandResolver, given: tuple[Operand, ...]) -> tuple[Place, ...]:
    return tuple(map(resolver.target, given))


def _sbr(machine: Interpreter, *places: Place) -> bool:
    machine.take(places, machine.inputs)
    return True


def _write_sbr(rungs: RungWriter, *places: Place) -> str:
    for number, place in enumerate(places):
        _take(rungs, place, f"given[{number}]")
    return "True"


# --- MCR: a false rung toggles the override


def _mcr(machine: Interpreter, power: bool) -> None:
    if not power:
        machine.set_status(OVERRIDE, not machine.status(OVERRIDE))


def _write_mcr(rungs: RungWriter, power: str) -> None:
    if power == "True":
        return
    with rungs.writer.block(f"if not ({power}):"):
        rungs.set_override(f"not {rungs.override}")


# --- the rows

JMP = action("JMP", Use.LABEL, run=lambda machine, label: machine.jump(label), write=_write_jmp)
LBL = condition(
    "LBL", Use.LABEL, run=lambda _machine, _label: True, write=lambda _rungs, _label: "True", alone=True
)
JSR = action(
    "JSR",
    Use.ROUTINE,
    Use.CONSTANT,
    Use.PARAMETERS,
    optional=1,
    resolve=_resolve_jsr,
    run=_jsr,
    write=_write_jsr,
    prescan=_prescan_jsr,
)
RET = action("RET", Use.PARAMETERS, resolve=_resolve_ret, run=_ret, write=_write_ret)
SBR = condition(
    "SBR",
    Use.PARAMETERS,
    resolve=_resolve_sbr,
    run=_sbr,
    write=_write_sbr,
    inline=lambda *_places: False,
    alone=True,
)
TND = action(
    "TND",
    run=lambda machine: machine.leave(()),
    write=lambda rungs: rungs.writer.line("return ()"),
)
MCR = always("MCR", run=_mcr, write=_write_mcr)
AFI = condition("AFI", run=lambda _machine: False, write=lambda _rungs: "False", alone=True)
NOP = condition("NOP", run=lambda _machine: True, write=lambda _rungs: "True", alone=True)
