"""Program control: jumps, routines, MCR."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from ..compiler.rungs import RungWriter
from ..interpreter import Interpreter
from ..model.arithmetic import wrap
from ..model.operand_checks import OperandError, mismatch
from ..model.operands import DOUBLE, Group, Place, Resolved, is_integer
from ..model.spec import Use, action, always, condition, do_nothing
from ..model.tags import OVERRIDE
from ..model.tree import Address, Number, Operand
from ..model.types import DINT
from ..state.lowered import BROKEN, Call, OperandResolver
from ..state.memory import Passed


def _write_jmp(rungs: RungWriter, label: str) -> None:
    if rungs.sections[label] <= rungs.section:
        rungs.writer.line(f"jumped_back({rungs.values.site})")
    rungs.writer.line(f"at = {rungs.sections[label]}")
    rungs.writer.line("continue")


# --- JSR: call a routine of rungs or in Python, and store its return values


def routine_named(resolver: OperandResolver, name: Operand, remedy: str = "write the routine's name") -> str:
    """Return the full name of an operand's routine, or raise an OperandError."""
    if not isinstance(name, Address) or name.steps:
        raise OperandError(f"{name} is not a routine", remedy)
    return resolver.named(name.name)


def _resolve_jsr(resolver: OperandResolver, given: tuple[Operand, ...]) -> tuple[Call]:
    routine = routine_named(resolver, given[0])
    count = 0
    if len(given) > 1:
        number = given[1]
        if not isinstance(number, Number) or number.value not in range(len(given) - 1):
            raise OperandError(f"{number} is not the number of inputs", f"must be 0 to {len(given) - 2}")
        count = int(number.value)
    if count == 0 and [str(operand) for operand in given[2:]] == ["0"]:
        given = given[:2]  # JSR(Sub,0,0) in some exports: neither inputs nor returns
    inputs = tuple(_input(resolver, operand) for operand in given[2 : 2 + count])
    return (Call(routine, inputs, tuple(_output(resolver, operand) for operand in given[2 + count :])),)


def _input(resolver: OperandResolver, operand: Operand) -> Resolved:
    is_group = isinstance(resolver.any(operand), Group)
    return resolver.checked(Use.SOURCE, operand) if is_group else resolver.value(operand)


def _output(resolver: OperandResolver, operand: Operand) -> Place | Group:
    is_group = isinstance(resolver.any(operand), Group)
    return resolver.checked(Use.DESTINATION, operand) if is_group else resolver.target(operand)


def _call(machine: Interpreter, call: Call) -> tuple[Passed, ...]:
    inputs = [machine.value(operand) for operand in call.inputs]
    if call.routine not in machine.lowered.recursive:
        return machine.call(call.routine, inputs)
    machine.fault_log.called(machine.site)
    answers = machine.call(call.routine, inputs)
    machine.fault_log.returned()
    return answers


def _once(scan: Callable[[Interpreter, str], None]) -> Callable[..., None]:
    """Return the prescan or postscan of a call; a recursive routine is scanned only once."""

    def run(machine: Interpreter, call: Call, *_values: Resolved) -> None:
        if call.routine in machine.prescanned:
            return
        if call.routine in machine.lowered.recursive:
            machine.prescanned.add(call.routine)
        scan(machine, call.routine)
        machine.prescanned.discard(call.routine)

    return run


@contextmanager
def _writing_call(rungs: RungWriter, call: Call) -> Iterator[str]:
    """Write the code around a call; yield the code of the call itself."""
    inputs = "".join(f"{_plain(rungs, number, operand)}, " for number, operand in enumerate(call.inputs))
    if call.routine in rungs.writer.lowered.functions:
        text = f"python({call.routine!r}, ({inputs}))"
    else:
        text = f"{rungs.functions[call.routine]}(now, ({inputs}))"
    recursive = call.routine in rungs.writer.lowered.recursive
    if recursive:
        rungs.writer.line(f"called({rungs.values.site})")
    yield text
    if recursive:
        rungs.writer.line("returned()")


def _write_jsr(rungs: RungWriter, call: Call) -> None:
    answers = ""
    with _writing_call(rungs, call) as text:
        if call.returns:
            answers = rungs.values.keep(f"{text} or ()")
        else:
            rungs.writer.line(text)
    for number, place in enumerate(call.returns):
        with rungs.writer.block(f"if len({answers}) > {number}:"):
            _take(rungs, number, place, f"{answers}[{number}]")


def _plain(rungs: RungWriter, number: int, operand: Resolved) -> str:
    """Return code for the value of an input or return parameter, given its index among them."""
    if isinstance(operand, Group):
        return f"passed({rungs.values.site}, {number})"
    return rungs.values.leaf_term(operand, DOUBLE).text  # `answer` rounds it


def _take(rungs: RungWriter, number: int, place: Place | Group, text: str) -> None:
    """Write code that stores a parameter in its tag."""
    if isinstance(place, Group):
        rungs.writer.line(f"received({rungs.values.site}, {number}, {text})")
        return
    rungs.values.clear_flags()
    kind = place.type
    if kind.is_bool:
        rungs.values.set_bit(place, rungs.values.keep(f"True if {text} else False"))
        return
    if kind.is_integer:
        value = rungs.values.keep(text)
        fits = f"{value}.__class__ is int and {kind.lowest} <= {value} <= {kind.highest}"
        rungs.writer.line(f"if not ({fits}): {value} = answer({rungs.values.site}, {value}, {kind.name!r})")
    else:
        value = rungs.values.keep(f"answer({rungs.values.site}, {text}, {kind.name!r})")
    rungs.values.assign_result(place, value)


# --- RET and SBR: return values and inputs of a routine


def _write_ret(rungs: RungWriter, *values: Resolved) -> None:
    listed = "".join(f"{_plain(rungs, number, value)}, " for number, value in enumerate(values))
    rungs.writer.line(f"return ({listed})")


def _sbr(machine: Interpreter, *places: Place | Group) -> bool:
    machine.take(places, machine.inputs)
    return True


def _write_sbr(rungs: RungWriter, *places: Place | Group) -> str:
    for number, place in enumerate(places):
        _take(rungs, number, place, f"given[{number}]")
    return "True"


# --- FOR, BRK: call a routine repeatedly


def _resolve_for(resolver: OperandResolver, given: tuple[Operand, ...]) -> tuple[object, ...]:
    routine = routine_named(resolver, given[0])
    if len(given) < 5:
        given = (*given, Number(1, "1"))  # some exports omit the step
    index, *values = resolver.target(given[1]), *map(resolver.value, given[2:])
    for operand, resolved in zip(given[1:], (index, *values), strict=True):
        if not is_integer(resolved):
            raise mismatch(operand, resolved, "an integer", "use a DINT")
    if index.type != DINT:
        raise mismatch(given[1], index, "a DINT", "count in a DINT")
    return (Call(routine, (), ()), index, *values)


def _for(
    machine: Interpreter, call: Call, index: Place, initial: Resolved, terminal: Resolved, step: Resolved
) -> None:
    machine.put(index, wrap(machine.integer(initial), DINT.bits))
    while True:
        count, last, by = (machine.integer(operand) for operand in (index, terminal, step))
        if count < last if by < 0 else count > last:
            return
        if _call(machine, call) is BROKEN:
            return
        by = machine.integer(step)
        machine.put(index, wrap(machine.integer(index) + by, DINT.bits))
        machine.fault_log.jumped_back(machine.site)


def _write_for(
    rungs: RungWriter, call: Call, index: Place, initial: Resolved, terminal: Resolved, step: Resolved
) -> None:
    values = rungs.values

    def term(operand: Resolved) -> str:
        return values.keep(values.leaf_term(operand).text)

    def count_to(text: str) -> None:
        values.assign(index, f"wrap({text}, {DINT.bits})")

    count_to(term(initial))
    with rungs.writer.block("while True:"):
        count, last, by = term(index), term(terminal), term(step)
        with rungs.writer.block(f"if {count} < {last} if {by} < 0 else {count} > {last}:"):
            rungs.writer.line("break")
        with _writing_call(rungs, call) as text:
            answers = values.keep(text)
        with rungs.writer.block(f"if {answers} is broken:"):
            rungs.writer.line("break")
        by = term(step)
        count_to(f"{term(index)} + {by}")
        rungs.writer.line(f"jumped_back({values.site})")


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

JMP = action(
    "JMP",
    Use.LABEL,
    run=lambda machine, label: machine.jump(label),
    write=_write_jmp,
    prove=lambda machine, power, label: machine.jump_to(power, label),
    leaves=True,
    captions=("Label",),
    instead="write IF, or a loop",
)
LBL = condition(
    "LBL",
    Use.LABEL,
    run=lambda _machine, _label: True,
    write=lambda _rungs, _label: "True",
    alone=True,
    captions=("Label",),
)
JSR = action(
    "JSR",
    Use.ROUTINE,
    Use.CONSTANT,
    Use.PARAMETERS,
    optional=1,
    resolve=_resolve_jsr,
    run=lambda machine, call: machine.take(call.returns, _call(machine, call)),
    write=_write_jsr,
    prove=lambda machine, power, call: machine.call_with(power, call),
    prescan=_once(lambda machine, routine: machine.prescan(routine)),
    postscan=_once(lambda machine, routine: machine.postscan(routine)),
    captions=("Routine", "Inputs"),
)
RET = action(
    "RET",
    Use.PARAMETERS,
    resolve=lambda resolver, operands: tuple(_input(resolver, operand) for operand in operands),
    run=lambda machine, *values: machine.leave(tuple(map(machine.value, values))),
    write=_write_ret,
    prove=lambda machine, power, *values: machine.return_from(power, machine.values_of(values)),
    leaves=True,
)
SBR = condition(
    "SBR",
    Use.PARAMETERS,
    resolve=lambda resolver, operands: tuple(_output(resolver, operand) for operand in operands),
    run=_sbr,
    write=_write_sbr,
    prove=lambda machine, power, *places: machine.enter_with(power, places),
    inline=lambda *_places: False,
    alone=True,
)
TND = action(
    "TND",
    run=lambda machine: machine.leave(()),
    write=lambda rungs: rungs.writer.line("return ()"),
    prove=lambda machine, power: machine.return_from(power, ()),
    leaves=True,
)
FOR = action(
    "FOR",
    Use.ROUTINE,
    Use.INTEGER_TARGET,
    Use.INTEGER,
    Use.INTEGER,
    Use.INTEGER,
    optional=1,
    resolve=_resolve_for,
    run=_for,
    prove=lambda machine, power, *operands: machine.loop_call(power, *operands),
    write=_write_for,
    prescan=_once(lambda machine, routine: machine.prescan(routine)),
    postscan=_once(lambda machine, routine: machine.postscan(routine)),
)
BRK = action(
    "BRK",
    run=lambda machine: machine.leave(BROKEN),
    prove=lambda machine, power: machine.return_from(power, BROKEN),
    write=lambda rungs: rungs.writer.line("return broken"),
    leaves=True,
    instead="write EXIT in a loop",
)
MCR = always("MCR", run=_mcr, write=_write_mcr, postscan=do_nothing, instead="write IF")
AFI = condition("AFI", run=lambda _machine: False, write=lambda _rungs: "False", alone=True)
NOP = condition("NOP", run=lambda _machine: True, write=lambda _rungs: "True", alone=True)
