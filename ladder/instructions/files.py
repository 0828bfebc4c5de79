"""File instructions: they work on stretches of memory."""

from __future__ import annotations

from .. import arithmetic as math
from ..compiler.rungs import RungWriter
from ..interpreter import Interpreter
from ..memory import Value
from ..operand_checks import OperandError
from ..operands import Constant, Group, Resolved, width_of
from ..regions import Region, copy, plain, region_of
from ..spec import Use, action
from ..types import LINT, Elementary, Structure

__all__ = ["COP", "CPS", "FLL"]

# --- COP, CPS: bytes from one place to another


def _first(machine: Interpreter, region: Region) -> int:
    return region.first(lambda index, length: machine.subscript(index, length, region.text))


def _cop(machine: Interpreter, source: Resolved, target: Resolved, length: Resolved) -> None:
    origin, goal = (region_of(each, machine.memory.layout) for each in (source, target))
    first, at = _first(machine, origin), _first(machine, goal)
    copy(machine.memory, origin, first, goal, at, machine.integer(length))


def _write_cop(rungs: RungWriter, source: Resolved, target: Resolved, length: Resolved) -> None:
    layout = rungs.writer.lowered.layout
    regions = region_of(source, layout), region_of(target, layout)
    if isinstance(length, Constant) and _write_slices(rungs, *regions, int(length.value)):
        return
    firsts = [_write_first(rungs, each) for each in regions]
    count = rungs.values.term(length, LINT.bits).text
    site = rungs.values.site
    rungs.writer.line(f"copy(region[{site}, 0], {firsts[0]}, region[{site}, 1], {firsts[1]}, {count})")


def _write_first(rungs: RungWriter, region: Region) -> str:
    flat = rungs.values.flat(region.indices, region.dims, region.text)
    return f"({flat}) * {region.rest}" if region.rest != 1 else flat


def _write_slices(rungs: RungWriter, source: Region, target: Region, length: int) -> bool:
    """Write a copy between lists of one type as slices; return whether that is possible."""
    first, at = source.fixed_first, target.fixed_first
    if plain(source) is None or plain(source) != plain(target) or first is None or at is None:
        return False
    count = min(length, target.left(at), source.left(first))
    if count < 1:
        return True
    origin, goal = source.parts[0].leaf, target.parts[0].leaf
    text = f"{rungs.writer.name(origin)}[{first}:{first + count}]"
    if origin.output:
        text += ".tolist()"
    if goal.output:
        text = f'array("h", {text})'
    rungs.writer.line(f"{rungs.writer.name(goal)}[{at}:{at + count}] = {text}")
    return True


# --- FLL: one value into elements of an array, without flags and faults


def _check_fll(_source: Resolved, target: Resolved, _length: Resolved) -> None:
    if isinstance(target, Group) and isinstance(target.type, Structure):
        raise OperandError(f"FLL does not fill a {target.type.name}", "COP a structure over it")


def _fll(machine: Interpreter, source: Resolved, target: Resolved, length: Resolved) -> None:
    region = region_of(target, machine.memory.layout)
    first = _first(machine, region)
    count = min(machine.integer(length), region.left(first))
    value = machine.number(source, width_of(source))
    leaf = region.parts[0].leaf
    for number in range(count):
        machine.memory.write(leaf, first + number, _converted(leaf.type, value))


def _converted(kind: Elementary, value: Value) -> Value:
    if kind.is_real:
        return math.real(value)
    return math.wrap(math.whole(value) if isinstance(value, float) else int(value), kind.bits)


def _write_fll(rungs: RungWriter, source: Resolved, target: Resolved, length: Resolved) -> None:
    region = region_of(target, rungs.writer.lowered.layout)
    first = _write_first(rungs, region)
    count = rungs.values.term(length, LINT.bits).text
    value = rungs.values.term(source, width_of(source)).text
    rungs.writer.line(f"fill(region[{rungs.values.site}, 1], {first}, {count}, {value})")


# --- the rows

COP = action("COP", Use.SOURCE, Use.DESTINATION, Use.INTEGER, run=_cop, write=_write_cop)
CPS = action("CPS", Use.SOURCE, Use.DESTINATION, Use.INTEGER, run=_cop, write=_write_cop)
FLL = action("FLL", Use.NUMBER, Use.DESTINATION, Use.INTEGER, check=_check_fll, run=_fll, write=_write_fll)
