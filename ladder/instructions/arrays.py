"""Array instructions: an expression per element, a search, the size, and statistics.

FAL and FSC operate on elements beginning with POS; an expression names the element as `Data[Control.POS]`:

| mode | elements |
|---|---|
| ALL | all elements, in the scan when the rung becomes true |
| INC | one element each time the rung becomes true |
| a number | that number of elements per scan from then to the end, regardless of the rung |

AVE, SRT and STD operate on one dimension of an array, beginning with the named element.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..compiler.edges import write_once
from ..compiler.files import elements_left, subscripts_kept
from ..compiler.passes import write_fal, write_fsc
from ..compiler.rungs import RungWriter
from ..interpreter import Interpreter
from ..interpreter.files import Control, Elements
from ..model import arithmetic
from ..model.operand_checks import OperandError, array_of
from ..model.operands import Constant, Group, Place, Resolved
from ..model.spec import IN_RUNGS, WITH_CONTROL, Spec, Use, action, always, on_control
from ..model.types import Elementary, count_of
from ..state.regions import converted, region_of
from .compute import store_expression
from .prescans import prescan_sets

# --- FAL, FSC: passes


def _passes(machine: Interpreter, power: bool, control: Control, mode: str, step: Callable[[], bool]) -> None:
    """Run the passes of one scan; `step` handles the element at POS and returns whether to continue."""
    if not _begin_passes(power, control, mode):
        return
    control.check()
    remaining = 1
    if mode == "ALL":
        remaining = control["LEN"]
    elif mode.isdigit():
        remaining = int(mode)
    while remaining and control["POS"] < control["LEN"]:
        machine.fault_log.jumped_back(machine.site)
        if not step():
            return
        control.set(POS=control["POS"] + 1)
        remaining -= 1
    control.set(DN=control["POS"] >= control["LEN"])


def _begin_passes(power: bool, control: Control, mode: str) -> bool:
    """Set EN and POS according to the rung; return whether passes run in this scan."""
    rises = power and not control["EN"]
    under_way = mode.isdigit() and control["EN"] and not control["DN"]
    if not power and not under_way:
        _disable(control)
        return False
    if rises:
        control.set(EN=True)
        if mode != "INC":
            control.set(POS=0)
    return not control["DN"] and not control["ER"] and (rises or mode != "INC")


def _disable(control: Control) -> None:
    """Clear EN; if the operation is done, return to element 0."""
    if control["DN"]:
        control.set(DN=False, POS=0)
    control.set(EN=False)


def _fal(
    machine: Interpreter, power: bool, group: Group, mode: str, target: Place, expression: Resolved
) -> None:
    """Assign the expression to the elements of one scan; an overflow sets ER and ends the passes."""
    control = Control(machine, group)

    def assign() -> bool:
        overflows_before = machine.fault_log.overflows
        store_expression(machine, target, expression)
        fits = machine.fault_log.overflows == overflows_before
        control.set(ER=not fits)
        return fits

    _passes(machine, power, control, mode, assign)


def _fsc(machine: Interpreter, power: bool, group: Group, mode: str, expression: Resolved) -> None:
    """Search the elements of one scan; the first element that makes the expression true sets FD and IN."""
    control = Control(machine, group)
    if control["FD"]:
        if not power:
            control.set(FD=False, IN=False)
            _disable(control)
            return
        if control["IN"]:
            return
        control.set(FD=False, POS=control["POS"] + 1)  # the program has cleared IN, so the search continues

    def search() -> bool:
        if not machine.condition(expression):
            return True
        control.set(FD=True, IN=True)
        return False

    _passes(machine, power, control, mode, search)


# --- SIZE


def _check_dimension(array: Resolved, dimension: Constant, *_others: Resolved) -> None:
    count = len(array_of(array))
    if not 0 <= dimension.value < count:
        raise OperandError(f"dimension {dimension.value} is out of range", f"must be 0 to {count - 1}")


def _size(machine: Interpreter, array: Resolved, dimension: Constant, target: Place) -> None:
    """Store the length of a dimension; for an InOut with one dimension, the elements left in its array."""
    dims = array_of(array)
    if len(dims) > 1:
        size = dims[int(dimension.value)]
    else:
        store, region, first = machine.end(array)
        size = region.left(first, store) if region.whole else count_of(dims)
    machine.put(target, machine.converted(target.type, size))


def _write_size(rungs: RungWriter, array: Resolved, dimension: Constant, target: Place) -> None:
    """Write code that does the same as `_size`."""
    assert isinstance(array, (Place, Group))
    dims, region = array_of(array), region_of(array)
    size = str(dims[int(dimension.value)])
    if len(dims) == 1:
        texts = subscripts_kept(rungs.values, array)
        size = elements_left(rungs, region, texts) if region.whole else str(count_of(dims))
    size = f"max({size}, 0)" if not size.isdigit() else size  # a subscript may lie beyond the end
    rungs.values.assign(target, f"converted(types[{target.type.name!r}], {size})")


# --- AVE, STD, SRT: one dimension


def _check_numbers(array: Resolved, dimension: Constant, *others: Resolved) -> None:
    _check_dimension(array, dimension)
    if isinstance(array, Group) and not isinstance(array.type, Elementary):
        raise OperandError(f"{array.text} is an array of {array.type.name}", "use an array of numbers")


def _run_on_edge(machine: Interpreter, power: bool, group: Group, operate: Callable[[Control], bool]) -> None:
    """Run `operate` when the rung becomes true; `operate` returns whether there is a result."""
    control = Control(machine, group)
    if not power:
        _disable(control)
        control.set(ER=False)
    elif not control["EN"] and not control["ER"]:
        control.set(EN=True, POS=0)
        control.check()
        if operate(control):
            control.set(DN=True, POS=control["LEN"])
        else:
            control.set(ER=True)


def _values(machine: Interpreter, array: Resolved, dimension: Constant, control: Control) -> list[float]:
    """Return LEN elements of one dimension; fault if LEN is beyond its end."""
    elements = Elements(machine, array, int(dimension.value))
    length = control["LEN"]
    if length > len(elements):
        elements[length - 1]  # faults: LEN is beyond the end of the array
    return [elements[number] for number in range(length)]


def _statistic(compute: Callable[[list[float]], float], least: int) -> Callable[..., None]:
    """Return the function that executes a statistic; `least` is the minimum number of values."""

    def run(
        machine: Interpreter, power: bool, array: Resolved, dimension: Constant, target: Place, group: Group
    ) -> None:
        def operate(control: Control) -> bool:
            """Store the statistic; return whether it has enough values and no overflow."""
            machine.clear_flags()
            values = _values(machine, array, dimension, control)
            if len(values) < least:
                machine.fault_log.zero_divisor(machine.site)
                return False
            overflows_before = machine.fault_log.overflows
            result = compute(values)
            if target.type.is_real:
                result = float(converted(target.type, result))
            if not arithmetic.finite(result) and all(map(arithmetic.finite, values)):
                machine.fault_log.overflow(machine.site)
            machine.store(target, result)
            return machine.fault_log.overflows == overflows_before

        _run_on_edge(machine, power, group, operate)

    return run


def _average(values: list[float]) -> float:
    return sum(values) / len(values)


def _deviation(values: list[float]) -> float:
    """Return the standard deviation of a sample."""
    mean = _average(values)
    return arithmetic.root(sum((value - mean) * (value - mean) for value in values) / (len(values) - 1))


def _srt(machine: Interpreter, power: bool, array: Resolved, dimension: Constant, group: Group) -> None:
    """Sort LEN elements in ascending order when the rung becomes true."""

    def operate(control: Control) -> bool:
        values = sorted(_values(machine, array, dimension, control))
        elements = Elements(machine, array, int(dimension.value))
        for number, value in enumerate(values):
            elements[number] = value
        return True

    _run_on_edge(machine, power, group, operate)


def _dimension_row(name: str, *uses: Use, **parts: Any) -> Spec:
    prescan = prescan_sets(-1, EN=False, DN=False, ER=False)
    return on_control(
        name, *uses, write=write_once, partly=True, check=_check_numbers, prescan=prescan, **parts
    )


# --- the rows

_INSTEAD = "write a FOR loop"

FAL = always(
    "FAL",
    *(*WITH_CONTROL, Use.PASSES, Use.TARGET, Use.EXPRESSION),
    run=_fal,
    write=write_fal,
    instead=_INSTEAD,
)
FSC = always("FSC", *WITH_CONTROL, Use.PASSES, Use.CONDITION, run=_fsc, write=write_fsc, instead=_INSTEAD)
SIZE = action(
    "SIZE", Use.TABLE, Use.CONSTANT, Use.INTEGER_TARGET, check=_check_dimension, run=_size, write=_write_size
)
AVE = _dimension_row(
    "AVE", Use.TABLE, Use.CONSTANT, Use.TARGET, run=_statistic(_average, 1), instead=IN_RUNGS
)
SRT = _dimension_row("SRT", Use.ARRAY, Use.CONSTANT, run=_srt)
STD = _dimension_row(
    "STD", Use.TABLE, Use.CONSTANT, Use.TARGET, run=_statistic(_deviation, 2), instead=IN_RUNGS
)
