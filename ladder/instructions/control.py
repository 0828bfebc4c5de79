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
    """Write a jump to another section of the routine; a jump back counts for the watchdog."""
    if rungs.sections[label] <= rungs.section:
        rungs.writer.line(f"jumped_back({rungs.values.site})")
    rungs.writer.line(f"at = {rungs.sections[label]}")
    rungs.writer.line("continue")


# --- JSR: call a routine of rungs or in Python, and store its return values


def routine_named(resolver: OperandResolver, name: Operand, remedy: str = "write the routine's name") -> str:
    """Return the full name of the routine in an operand; raise an OperandError if it does not exist."""
    if not isinstance(name, Address) or name.steps:
        raise OperandError(f"{name} is not a routine", remedy)
    return resolver.named(name.name)


def _resolve_jsr(resolver: OperandResolver, operands: tuple[Operand, ...]) -> tuple[Call]:
    """Return the call of a JSR. Operands: routine, number of inputs, inputs, return tags."""
    routine = routine_named(resolver, operands[0])
    count = 0
    if len(operands) > 1:
        number = operands[1]
        if not isinstance(number, Number) or number.value not in range(len(operands) - 1):
            raise OperandError(f"{number} is not the number of inputs", f"must be 0 to {len(operands) - 2}")
        count = int(number.value)
    if count == 0 and [str(operand) for operand in operands[2:]] == ["0"]:
        operands = operands[:2]  # JSR(Sub,0,0) in some exports: neither inputs nor returns
    inputs = tuple(_input(resolver, operand) for operand in operands[2 : 2 + count])
    returns = tuple(_output(resolver, operand) for operand in operands[2 + count :])
    return (Call(routine, inputs, returns),)


def _input(resolver: OperandResolver, operand: Operand) -> Resolved:
    """Return an operand of a call: a structure or array to copy, or a value."""
    is_group = isinstance(resolver.any_operand(operand), Group)
    return resolver.checked(Use.SOURCE, operand) if is_group else resolver.value(operand)


def _output(resolver: OperandResolver, operand: Operand) -> Place | Group:
    """Return a target of a call: a structure or array to copy to, or a place."""
    is_group = isinstance(resolver.any_operand(operand), Group)
    return resolver.checked(Use.DESTINATION, operand) if is_group else resolver.target(operand)


def _call(machine: Interpreter, call: Call) -> tuple[Passed, ...]:
    """Call a routine and return its values. Recursive calls are counted, and fault if they are too deep."""
    inputs = [machine.value(operand) for operand in call.inputs]
    if call.routine not in machine.lowered.recursive:
        return machine.call(call.routine, inputs)
    machine.fault_log.called(machine.site)
    results = machine.call(call.routine, inputs)
    machine.fault_log.returned()
    return results


def _scan_routine_once(scan: Callable[[Interpreter, str], None]) -> Callable[..., None]:
    """Return the prescan or postscan function of a call; it scans a recursive routine only once."""

    def run(machine: Interpreter, call: Call, *_values: Resolved) -> None:
        """Scan the called routine, unless an outer call is already scanning it."""
        if call.routine in machine.prescanned:
            return
        if call.routine in machine.lowered.recursive:
            machine.prescanned.add(call.routine)
        scan(machine, call.routine)
        machine.prescanned.discard(call.routine)

    return run


@contextmanager
def _writing_call(rungs: RungWriter, call: Call) -> Iterator[str]:
    """Yield the code of a call; if the routine is recursive, surround it with code that counts the call."""
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
    """Write a call, and code that stores the values that the routine returns."""
    results = ""
    with _writing_call(rungs, call) as text:
        if call.returns:
            results = rungs.values.keep(f"{text} or ()")
        else:
            rungs.writer.line(text)
    for number, target in enumerate(call.returns):
        with rungs.writer.block(f"if len({results}) > {number}:"):
            _write_stored(rungs, number, target, f"{results}[{number}]")


def _plain(rungs: RungWriter, number: int, operand: Resolved) -> str:
    """Return code for the value of input or return parameter `number`, counted from 0."""
    if isinstance(operand, Group):
        return f"passed({rungs.values.site}, {number})"
    return rungs.values.leaf_term(operand, DOUBLE).text  # `answer` rounds it


def _write_stored(rungs: RungWriter, number: int, target: Place | Group, text: str) -> None:
    """Write code that stores parameter `number` in its tag; `text` is the code for its value."""
    if isinstance(target, Group):
        rungs.writer.line(f"received({rungs.values.site}, {number}, {text})")
        return
    rungs.values.clear_flags()
    kind = target.type
    if kind.is_bool:
        rungs.values.set_bit(target, rungs.values.keep(f"True if {text} else False"))
        return
    if kind.is_integer:
        value = rungs.values.keep(text)
        fits = f"{value}.__class__ is int and {kind.lowest} <= {value} <= {kind.highest}"
        rungs.writer.line(f"if not ({fits}): {value} = answer({rungs.values.site}, {value}, {kind.name!r})")
    else:
        value = rungs.values.keep(f"answer({rungs.values.site}, {text}, {kind.name!r})")
    rungs.values.assign_result(target, value)


# --- RET and SBR: return values and inputs of a routine


def _write_ret(rungs: RungWriter, *values: Resolved) -> None:
    listed = "".join(f"{_plain(rungs, number, value)}, " for number, value in enumerate(values))
    rungs.writer.line(f"return ({listed})")


def _sbr(machine: Interpreter, *targets: Place | Group) -> bool:
    """Store the inputs of the current call; return True, because SBR passes power on."""
    machine.take(targets, machine.inputs)
    return True


def _write_sbr(rungs: RungWriter, *targets: Place | Group) -> str:
    for number, target in enumerate(targets):
        _write_stored(rungs, number, target, f"given[{number}]")
    return "True"


# --- FOR, BRK: call a routine repeatedly


def _resolve_for(resolver: OperandResolver, operands: tuple[Operand, ...]) -> tuple[object, ...]:
    """Return the call and the index of a FOR, and its initial, terminal and step values."""
    routine = routine_named(resolver, operands[0])
    if len(operands) < 5:
        operands = (*operands, Number(1, "1"))  # some exports omit the step
    index, *values = resolver.target(operands[1]), *map(resolver.value, operands[2:])
    for operand, resolved in zip(operands[1:], (index, *values), strict=True):
        if not is_integer(resolved):
            raise mismatch(operand, resolved, "an integer", "use a DINT")
    if index.type != DINT:
        raise mismatch(operands[1], index, "a DINT", "count in a DINT")
    return (Call(routine, (), ()), index, *values)


def _for(
    machine: Interpreter, call: Call, index: Place, initial: Resolved, terminal: Resolved, step: Resolved
) -> None:
    """Call a routine for each value of the index, until it passes the terminal value or BRK runs.

    The operands are read again in each pass, because the routine can change them.
    """
    machine.put(index, wrap(machine.integer(initial), DINT.bits))
    while True:
        count, last, increment = (machine.integer(operand) for operand in (index, terminal, step))
        if count < last if increment < 0 else count > last:
            return
        if _call(machine, call) is BROKEN:
            return
        increment = machine.integer(step)
        machine.put(index, wrap(machine.integer(index) + increment, DINT.bits))
        machine.fault_log.jumped_back(machine.site)


def _write_for(
    rungs: RungWriter, call: Call, index: Place, initial: Resolved, terminal: Resolved, step: Resolved
) -> None:
    """Write code that does the same as `_for`."""
    values = rungs.values

    def term(operand: Resolved) -> str:
        return values.keep(values.leaf_term(operand).text)

    def count_to(text: str) -> None:
        values.assign(index, f"wrap({text}, {DINT.bits})")

    count_to(term(initial))
    with rungs.writer.block("while True:"):
        count, last, increment = term(index), term(terminal), term(step)
        with rungs.writer.block(f"if {count} < {last} if {increment} < 0 else {count} > {last}:"):
            rungs.writer.line("break")
        with _writing_call(rungs, call) as text:
            results = values.keep(text)
        with rungs.writer.block(f"if {results} is broken:"):
            rungs.writer.line("break")
        increment = term(step)
        count_to(f"{term(index)} + {increment}")
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

_PRESCAN = _scan_routine_once(lambda machine, routine: machine.prescan(routine))
_POSTSCAN = _scan_routine_once(lambda machine, routine: machine.postscan(routine))

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
    prescan=_PRESCAN,
    postscan=_POSTSCAN,
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
    prescan=_PRESCAN,
    postscan=_POSTSCAN,
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
