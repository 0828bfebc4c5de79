"""Queues, stacks and shifted bits as Python code, see `instructions.shifts`.

Arrays of numbers in lists and views, and structures in bytes, are compiled to Python; other arrays are
interpreted.
"""

from __future__ import annotations

from collections.abc import Callable

from ..model.operands import Group, Place, Resolved
from ..model.types import DINT, Elementary
from .files import (
    ControlText,
    ElementText,
    byte_end,
    converted_text,
    has_elements,
    plus,
    subscripts_kept,
)
from .rungs import RungWriter

# --- FFL, LFL, FFU, LFU


def write_load(rungs: RungWriter, power: str, source: Resolved, queue: Resolved, group: Group) -> None:
    """Write FFL or LFL, which store the source at POS when the rung becomes true and there is room."""
    if not _can_be_written(rungs, queue, source):
        rungs.interpret(power)
        return
    control, power = ControlText(rungs, group), rungs.kept(power)
    rises = rungs.values.keep(f"{power} and not {control['EN']}")
    control.set(EN=power)
    control.check()
    with rungs.writer.block(f"if {rises} and {control['POS']} < {control['LEN']}:"):
        position = rungs.values.keep(control["POS"])
        _write_item(rungs, source, queue, position)
        control.set(POS=f"{position} + 1")
    _write_level(control)


def _can_be_written(rungs: RungWriter, queue: Resolved, single: Resolved) -> bool:
    """Return whether a queue, and the structure that is loaded or unloaded, can be written as Python."""
    if has_elements(rungs, queue):
        return not isinstance(single, Group) and not (isinstance(single, Place) and single.bit is not None)
    return all(isinstance(group, Group) and _in_bytes(rungs, group) for group in (queue, single))


def _in_bytes(rungs: RungWriter, operand: Group) -> bool:
    """Return whether a group is a structure that is stored in bytes."""
    return (
        not isinstance(operand.type, Elementary) and rungs.writer.layout.byte_spot(operand.path) is not None
    )


def _write_item(rungs: RungWriter, source: Resolved, queue: Resolved, number: str) -> None:
    """Write code that copies a source (a number or a structure in bytes) to an item of a queue."""
    line, keep = rungs.writer.line, rungs.values.keep
    if has_elements(rungs, queue):
        elements = ElementText(rungs, queue)
        value = elements.value_of(source)
        elements.check(number)
        line(f"{elements[number]} = {value}")
        return
    into, source_end = byte_end(rungs, queue), byte_end(rungs, source)
    assert into is not None
    assert source_end is not None
    assert isinstance(queue, Group)
    site_and_tag = f"{rungs.values.site}, {queue.text!r}"
    count = f"{into.left} // {into.size}"
    line(f"if {number} >= {count}: outside({number}, {count}, {site_and_tag})")
    offset = keep(f"{into.at} + {number} * {into.size}")
    item = f"{source_end.tag}.B[{source_end.at}:{plus(source_end.at, str(source_end.size))}]"
    line(f"{into.tag}.B[{offset}:{offset} + {into.size}] = {item}")


def _write_level(control: ControlText) -> None:
    """Write code that sets DN if the queue is full and EM if it is empty."""
    control.set(DN=f"{control['POS']} >= {control['LEN']}")
    control.set(EM=f"{control['POS']} == 0")


def write_unload(first: bool) -> Callable[[RungWriter, str, Resolved, Resolved, Group], None]:
    """Return the writer of FFU, which unloads the first item, or of LFU, which unloads the last one."""

    def write(rungs: RungWriter, power: str, queue: Resolved, target: Resolved, group: Group) -> None:
        """Write the instruction, which unloads an item into `target` when the rung becomes true."""
        if not _can_be_written(rungs, queue, target):
            rungs.interpret(power)
            return
        control, power = ControlText(rungs, group), rungs.kept(power)
        rises = rungs.values.keep(f"{power} and not {control['EU']}")
        control.set(EU=power)
        control.check()
        with rungs.writer.block(f"if {rises}:"):
            level = rungs.values.keep(f"min({control['POS']}, {control['LEN']})")
            control.set(POS=f"max({level} - 1, 0)")
            write_item = _write_unloaded_number if has_elements(rungs, queue) else _write_unloaded_structure
            write_item(rungs, queue, target, control, level, first=first)
        _write_level(control)

    return write


def _write_unloaded_number(
    rungs: RungWriter, queue: Resolved, target: Resolved, control: ControlText, level: str, *, first: bool
) -> None:
    """Write code that unloads a number and moves the remaining elements."""
    assert isinstance(target, Place)
    values, line = rungs.values, rungs.writer.line
    elements = ElementText(rungs, queue)
    number = "0" if first else values.keep(f"{level} - 1")
    if target.type == elements.type:
        subscripts_kept(values, target)  # the target's subscripts are checked first
    item, zero = values.keep(repr(elements.type.zero)), elements.type.zero
    with rungs.writer.block(f"if {level}:"):
        elements.check(number)
        line(f"{item} = {elements[number]}")
    values.assign(target, converted_text(values.term_of(item, elements.type), target.type))
    with rungs.writer.block(f"if {level}:"):
        if first:
            _write_move_down(rungs, queue, (elements.row, elements.at, elements.left), control, repr(zero))
        else:
            line(f"{elements[number]} = {zero!r}")


def _write_unloaded_structure(
    rungs: RungWriter, queue: Resolved, target: Resolved, control: ControlText, level: str, *, first: bool
) -> None:
    """Write code that unloads a structure in bytes and moves the remaining elements."""
    assert isinstance(queue, Group)
    line, keep = rungs.writer.line, rungs.values.keep
    queue_end, target_end = byte_end(rungs, queue), byte_end(rungs, target)
    assert queue_end is not None
    assert target_end is not None
    size, row = queue_end.size, f"{queue_end.tag}.B"
    into = f"{target_end.tag}.B[{target_end.at}:{plus(target_end.at, str(size))}]"
    with rungs.writer.block(f"if {level}:"):
        number = "0" if first else keep(f"{level} - 1")
        left = keep(f"{queue_end.left} // {size}")
        if not first:
            arguments = f"{number}, {left}, {rungs.values.site}, {queue.text!r}"
            line(f"if {number} >= {left}: outside({arguments})")
        offset = keep(queue_end.at if first else f"{queue_end.at} + {number} * {size}")
        item = f"{row}[{offset}:{offset} + {size}]"
        line(f"{into} = {item}")
        if first:
            _write_move_down(rungs, queue, (row, offset, left), control, f"bytes({size})")
        else:
            line(f"{item} = bytes({size})")
    line(f"else: {into} = bytes({size})")


def _write_move_down(
    rungs: RungWriter, queue: Resolved, elements: tuple[str, str, str], control: ControlText, zero: str
) -> None:
    """Write the call that moves items down by one and puts `zero` after them.

    The elements are text for a list, the index of its first item, and the number of items from there.
    """
    assert isinstance(queue, (Place, Group))
    row, offset, left = elements
    arguments = f"{rungs.values.site}, {queue.text!r}, {row}, {offset}, {control['LEN']}, {left}, {zero}"
    rungs.writer.line(f"move_down(faults, {arguments})")


# --- BSL, BSR


def write_shift(left: bool) -> Callable[[RungWriter, str, Resolved, Group, Place], None]:
    """Return the writer of BSL or BSR."""

    def write(rungs: RungWriter, power: str, array: Resolved, group: Group, source: Place) -> None:
        """Write the instruction, which shifts LEN bits by one when the rung becomes true."""
        control, block = ControlText(rungs, group), rungs.writer.block
        if not has_elements(rungs, array):
            rungs.interpret(power)
            return

        def when_true() -> None:
            with block(f"if not {control['EN']}:"):
                control.set(EN=True)
                with block(f"if {control['LEN']} < 0:"):
                    control.set(ER=True)
                with block("else:"):
                    elements = ElementText(rungs, array)
                    with block(f"if {control['LEN']}:"):
                        _write_moved_bits(rungs, elements, control, source, left=left)
                    with block("else:"):
                        control.set(DN=True, POS=0)

        rungs.either(power, when_true, lambda: control.set(EN=False, DN=False, ER=False, POS=0))

    return write


def _write_moved_bits(
    rungs: RungWriter, elements: ElementText, control: ControlText, source: Place, *, left: bool
) -> None:
    """Write the shift of LEN bits: the source's bit enters, and the bit that leaves becomes UL."""
    values = rungs.values
    length = values.keep(control["LEN"])
    arguments = f"{elements.left}, {elements.left}, {values.site}, {elements.region.text!r}"
    rungs.writer.line(f"if {length} > {elements.left} * {DINT.bits}: outside({arguments})")
    unloaded = values.keep(
        f"shift_bits({elements.row}, {elements.at}, {length}, {values.read(source)}, {left})"
    )
    control.set(UL=unloaded, DN=True, POS=length)
