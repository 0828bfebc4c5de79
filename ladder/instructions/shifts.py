"""Shift instructions: bits of an array, and queues and stacks of elements.

They act when the rung goes true; .EN (.EU for FFU and LFU) stores the rung's state. For queues, prescan sets
this bit, so a rung that is true at power-up loads and unloads nothing. For BSL and BSR, prescan
clears it.
"""

from __future__ import annotations

from collections.abc import Callable

from ..compiler.queues import write_load, write_shift, write_unload
from ..interpreter import Interpreter
from ..interpreter.files import Control, Elements
from ..model.arithmetic import wrap
from ..model.operand_checks import OperandError, described, mismatch
from ..model.operands import Group, Place, Resolved, width_moved
from ..model.spec import IN_RUNGS, Spec, Use, always, on_control
from ..model.types import DINT, Elementary
from .prescans import prescan_sets

# --- BSL, BSR: all bits of the DINTs that LEN reaches move by one


def check_dints(array: Resolved, *_others: Resolved) -> None:
    """Raise an OperandError unless an array has type DINT."""
    if isinstance(array, (Place, Group)) and array.type != DINT:
        raise mismatch(array.text, array, "an array of DINT", "declare it as DINT")


def _shift(left: bool) -> Callable[[Interpreter, bool, Resolved, Group, Place], None]:
    """Return the function of BSL or BSR, which shifts once when the rung goes true."""

    def run(machine: Interpreter, power: bool, array: Resolved, group: Group, source: Place) -> None:
        control = Control(machine, group)
        if not power:
            control.set(EN=False, DN=False, ER=False, POS=0)
        elif not control["EN"]:
            control.set(EN=True)
            if control["LEN"] < 0:
                control.set(ER=True)
            else:
                _move_bits(machine, array, control, source, left=left)

    return run


def _move_bits(machine: Interpreter, array: Resolved, control: Control, source: Place, *, left: bool) -> None:
    """Shift the LEN bits by one. The source is shifted in, and UL receives the bit that is shifted out."""
    elements, length = Elements(machine, array), control["LEN"]
    if not length:
        control.set(DN=True, POS=0)
        return
    words = -(-length // DINT.bits)
    value = sum((machine.whole(elements[word]) & 0xFFFF_FFFF) << DINT.bits * word for word in range(words))
    new, last = machine.whole(machine.get(source)), length - 1
    if left:
        unloaded, value = value >> last & 1, value << 1 | new
    else:
        unloaded, value = value & 1, value >> 1 & ~(1 << last) | new << last
    for word in range(words):
        elements[word] = wrap(value >> DINT.bits * word, DINT.bits)
    control.set(UL=unloaded, DN=True, POS=length)


def _bit_shift(name: str, *, left: bool) -> Spec:
    """Return the row of BSL or BSR."""
    return always(
        name,
        Use.ARRAY,
        Use.CONTROL,
        Use.BIT,
        Use.PRESET,
        optional=1,
        check=check_dints,
        run=_shift(left),
        write=write_shift(left),
        partly=True,
        prescan=prescan_sets(1, EN=False, DN=False, ER=False, POS=0),
        instead=IN_RUNGS,
    )


# --- FFL, LFL: load a queue or a stack


def _check_load(source: Resolved, queue: Resolved, _control: Resolved) -> None:
    _check_same(queue, source)


def _check_unload(queue: Resolved, target: Resolved, _control: Resolved) -> None:
    _check_same(queue, target)


def _check_same(queue: Resolved, single: Resolved) -> None:
    """Raise an OperandError unless the types fit: two numbers, or one structure type."""
    assert isinstance(queue, (Place, Group))
    are_numbers = not isinstance(single, Group) and isinstance(queue.type, Elementary)
    if not are_numbers and not (isinstance(single, Group) and single.type == queue.type):
        raise OperandError(
            f"{described(single)} is not of the type of {queue.text}, {queue.type.name}", "use one type"
        )


def _load(machine: Interpreter, power: bool, source: Resolved, queue: Resolved, group: Group) -> None:
    """Run FFL or LFL: store the source at POS when the rung goes true, unless the queue is full."""
    control = Control(machine, group)
    rises = power and not control["EN"]
    control.set(EN=power)
    control.check()
    length, position = control["LEN"], control["POS"]
    if rises and position < length:
        _store_item(machine, source, Elements(machine, queue), position)
        control.set(POS=position + 1)
    _show_level(control)


def _show_level(control: Control) -> None:
    control.set(DN=control["POS"] >= control["LEN"], EM=control["POS"] == 0)


def _store_item(machine: Interpreter, source: Resolved, queue: Elements, number: int) -> None:
    """Store the source as an element of a queue, converted if the types differ."""
    if isinstance(source, (Place, Group)) and source.type == queue.type:
        queue.put(number, Elements(machine, source).take(0))
    else:
        assert isinstance(queue.type, Elementary)
        queue[number] = machine.converted(queue.type, machine.number(source, width_moved(source, queue.type)))


# --- FFU, LFU: unload the first or the last element; 0 if there is none


def _unload(first: bool) -> Callable[[Interpreter, bool, Resolved, Resolved, Group], None]:
    """Return the function of FFU or LFU, which unloads an element when the rung goes true."""

    def run(machine: Interpreter, power: bool, queue: Resolved, target: Resolved, group: Group) -> None:
        control = Control(machine, group)
        rises = power and not control["EU"]
        control.set(EU=power)
        control.check()
        if rises:
            level = min(control["POS"], control["LEN"])
            control.set(POS=max(level - 1, 0))
            elements = Elements(machine, queue)
            if level:
                _deliver(machine, elements, 0 if first else level - 1, target)
                _remove(elements, control["LEN"] if first else level, shift=first)
            else:
                _deliver(machine, elements, None, target)
        _show_level(control)

    return run


def _remove(elements: Elements, end: int, *, shift: bool) -> None:
    """Clear the element before `end`; with `shift`, first move each element down by one."""
    if shift:
        for number in range(1, end):
            elements.put(number - 1, elements.take(number))
    elements.put(end - 1, bytes(len(elements.take(end - 1))))


def _deliver(machine: Interpreter, queue: Elements, number: int | None, target: Resolved) -> None:
    """Write an element to the target; None writes 0."""
    if isinstance(target, Place) and target.type != queue.type:
        machine.put(target, machine.converted(target.type, 0 if number is None else queue[number]))
        return
    into = Elements(machine, target)
    into.put(0, bytes(len(into.take(0))) if number is None else queue.take(number))


# --- the rows


def _load_queue(name: str) -> Spec:
    uses, prescan = (Use.ITEM, Use.ARRAY), prescan_sets(-1, EN=True)
    methods = {"run": _load, "write": write_load, "partly": True}
    return on_control(name, *uses, **methods, check=_check_load, prescan=prescan, instead=IN_RUNGS)


def _unload_queue(name: str, *, first: bool) -> Spec:
    uses, prescan = (Use.ARRAY, Use.ITEM_TARGET), prescan_sets(-1, EU=True)
    methods = {"run": _unload(first), "write": write_unload(first), "partly": True}
    return on_control(name, *uses, **methods, check=_check_unload, prescan=prescan, instead=IN_RUNGS)


BSL = _bit_shift("BSL", left=True)
BSR = _bit_shift("BSR", left=False)
FFL = _load_queue("FFL")
FFU = _unload_queue("FFU", first=True)
LFL = _load_queue("LFL")
LFU = _unload_queue("LFU", first=False)
