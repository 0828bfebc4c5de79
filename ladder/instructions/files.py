"""File instructions: copies between regions of memory."""

from __future__ import annotations

from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from math import isfinite

from ..compiler.files import ByteEnd, byte_end, plus
from ..compiler.rungs import RungWriter
from ..interpreter import Interpreter
from ..model.arithmetic import real
from ..model.operands import SINGLE, Constant, Place, Resolved, subscripts_of, width_moved
from ..model.spec import Use, action
from ..model.tags import Leaf
from ..model.types import DINT, LINT
from ..state.regions import ArrayRegion, FieldSlice, converted, copied_singly, plain, region_of

# --- COP, CPS: copy bytes from one place to another


def _cop(machine: Interpreter, source: Resolved, target: Resolved, length: Resolved) -> None:
    origin, goal = machine.end(source), machine.end(target)
    machine.copy(origin, goal, machine.integer(length))


def _write_cop(rungs: RungWriter, source: Resolved, target: Resolved, length: Resolved) -> None:
    """Write code for COP: slices or assignments if possible, otherwise a call of `copy`."""
    source_end, target_end = byte_end(rungs, source), byte_end(rungs, target)
    if source_end is not None and target_end is not None:
        _write_bytes(rungs, source_end, target_end, length)
        return
    regions = region_of(source), region_of(target)
    if isinstance(length, Constant) and _write_slices(rungs, *regions, int(length.value)):
        return
    if copied_singly((source, target, length)):
        _write_singly(rungs, *regions)
        return
    firsts = [_write_first(rungs, region) for region in regions]
    count = rungs.values.term(length, LINT.bits).text
    site = rungs.values.site
    stores = [rungs.values.store_of(region.parts[0].leaf) for region in regions]
    arguments = [f"region[{site}, 0]", firsts[0], f"region[{site}, 1]", firsts[1], count]
    if stores != ["None", "None"]:
        arguments += stores
    rungs.writer.line(f"copy({', '.join(arguments)})")


def _write_bytes(rungs: RungWriter, source: ByteEnd, target: ByteEnd, length: Resolved) -> None:
    """Write code that copies between bytes as a slice."""
    count = _byte_count(rungs, length, target, source)
    if count != "0":
        with _if_any(rungs, count):
            slices = (f"{end.tag}.B[{end.at}:{plus(end.at, count)}]" for end in (target, source))
            rungs.writer.line(" = ".join(slices))


def _byte_count(rungs: RungWriter, length: Resolved, target: ByteEnd, *source: ByteEnd) -> str:
    """Return code for the number of bytes to write: a number, or a variable that can be 0 or negative.

    It is the minimum of the length operand's size and the number of bytes from each operand to the end of its
    array.
    """
    ends = (target, *source)
    if isinstance(length, Constant):
        size = int(length.value) * target.size
        limits = [str(size), *(end.left for end in ends if size > end.surely)]
    else:
        text = f"{rungs.values.term(length, LINT.bits).text} * {target.size}"
        limits = [text, *(end.left for end in ends)]
    if all(item.lstrip("-").isdigit() for item in limits):
        return str(max(0, min(map(int, limits))))
    return rungs.values.keep(f"min({', '.join(dict.fromkeys(limits))})")


def _if_any(rungs: RungWriter, count: str) -> AbstractContextManager[None]:
    """Return a context for lines that need a count above 0: an `if`, or no code if the count is a literal."""
    return nullcontext() if count.isdigit() else rungs.writer.block(f"if {count} > 0:")


def _write_singly(rungs: RungWriter, source: ArrayRegion, target: ArrayRegion) -> None:
    """Write code that copies a small structure with assignments."""
    for origin, goal in zip(source.parts, target.parts, strict=True):
        rungs.values.assign(_value_in(target, goal), rungs.values.read(_value_in(source, origin)))


def _value_in(region: ArrayRegion, field_slice: FieldSlice) -> Place:
    """Return the place of a value in the first element of a region with fixed subscripts."""
    first = region.fixed_first
    assert first is not None
    flat = first * field_slice.per_element + field_slice.field.index
    return Place(field_slice.leaf, subscripts_of(field_slice.leaf.dims, flat), None, region.text)


def _write_first(rungs: RungWriter, region: ArrayRegion) -> str:
    """Return code for the index of the region's first element."""
    flat = rungs.values.flat(region.parts[0].leaf, region.indices, region.text)
    return f"({flat}) * {region.rest}" if region.rest != 1 and region.indices else flat


def _write_slices(rungs: RungWriter, source: ArrayRegion, target: ArrayRegion, length: int) -> bool:
    """Write code that copies between lists of one type as slices; return whether that was possible."""
    source_first, target_first = source.fixed_first, target.fixed_first
    if source_first is None or target_first is None:
        return False
    if plain(source) is None or plain(source) != plain(target):
        return False
    if source.whole or target.whole:
        return _write_row(rungs, (source, source_first), (target, target_first), length)
    count = min(length, target.fixed_left(target_first), source.fixed_left(source_first))
    if count < 1:
        return True
    origin, goal = source.parts[0].leaf, target.parts[0].leaf
    text = _write_slice(rungs, origin, source_first, count)
    from_view, to_view = _is_view(rungs, origin), _is_view(rungs, goal)
    if from_view != to_view:
        text = f"{text}.tolist()" if from_view else f'array("{goal.type.code}", {text})'
    rungs.writer.line(f"{_write_slice(rungs, goal, target_first, count)} = {text}")
    return True


def _is_view(rungs: RungWriter, leaf: Leaf) -> bool:
    """Return whether a leaf's elements are in a typed view of bytes, and not in a list."""
    spot = rungs.writer.layout.spot(leaf)
    return rungs.writer.is_live(leaf) or (spot is not None and bool(spot.view))


def _write_row(
    rungs: RungWriter, source: tuple[ArrayRegion, int], target: tuple[ArrayRegion, int], length: int
) -> bool:
    """Write code that copies from or to a whole InOut, whose array length is known only in the call.

    Return whether that was possible.
    """
    kind = plain(source[0])
    if kind is None or kind.is_bool:  # an InOut may be a bit of an integer
        return False
    ends = [str(length)]
    arguments = []
    for region, first in (target, source):
        leaf = region.parts[0].leaf
        arguments += [rungs.writer.name(leaf), rungs.values.row(leaf, first)]
        if region.whole:
            _, _, remaining, *_ = rungs.writer.handed(leaf.root)
            ends.append(f"{remaining} - {first}" if first else remaining)
        else:
            ends.append(str(region.fixed_left(first)))
    rungs.writer.line(f"copy_row({', '.join(arguments)}, min({', '.join(ends)}))")
    return True


def _write_slice(rungs: RungWriter, leaf: Leaf, first: int, count: int) -> str:
    """Return code for consecutive elements."""
    begin = rungs.values.row(leaf, first)
    end = f"{int(begin) + count}" if begin.isdigit() else f"{begin} + {count}"
    return f"{rungs.writer.name(leaf)}[{begin}:{end}]"


# --- FLL: fill elements of an array with a value, without flags and faults


def _fll(machine: Interpreter, source: Resolved, target: Resolved, length: Resolved) -> None:
    _, region, _ = end = machine.end(target)
    machine.fill(end, machine.integer(length), machine.number(source, _width_filled(source, region)))


def _write_fll(rungs: RungWriter, source: Resolved, target: Resolved, length: Resolved) -> None:
    """Write code for FLL: zeros in bytes or a list if possible, otherwise a call of `fill`."""
    region = region_of(target)
    if source == Constant(0, DINT) and (end := byte_end(rungs, target)) is not None:
        size = _byte_count(rungs, length, end)
        with _if_any(rungs, size):
            rungs.writer.line(f"{end.tag}.B[{end.at}:{plus(end.at, size)}] = bytes({size})")
        return
    if _write_list_filled(rungs, source, region, length):
        return
    first = _write_first(rungs, region)
    count = rungs.values.term(length, LINT.bits).text
    value = rungs.values.term(source, _width_filled(source, region)).text
    store = rungs.values.store_of(region.parts[0].leaf)
    goal = f", {store}" if store != "None" else ""
    rungs.writer.line(f"fill(region[{rungs.values.site}, 1], {first}, {count}, {value}{goal})")


def _write_list_filled(rungs: RungWriter, source: Resolved, region: ArrayRegion, length: Resolved) -> bool:
    """Write code that fills elements of a list with a constant; return whether that was possible."""
    kind, first, leaf = plain(region), region.fixed_first, region.parts[0].leaf
    if kind is None or first is None or region.whole or rungs.writer.is_live(leaf):
        return False
    if not isinstance(source, Constant) or not isinstance(length, Constant):
        return False
    count = min(int(length.value), region.fixed_left(first))
    if count < 1:
        return True
    single = isinstance(source.value, float) and _width_filled(source, region) == SINGLE
    value = converted(kind, real(source.value) if single else source.value)
    if not isfinite(value):
        return False
    row = f"[{value!r}] * {count}"
    if _is_view(rungs, leaf):
        row = f'array("{kind.code}", {row})'
    rungs.writer.line(f"{_write_slice(rungs, leaf, first, count)} = {row}")
    return True


def _width_filled(source: Resolved, region: ArrayRegion) -> int:
    return width_moved(source, *(part.leaf.type for part in region.parts))


# --- the rows

_COPIED = ("Source", "Dest", "Length")

COP = action("COP", Use.SOURCE, Use.DESTINATION, Use.INTEGER, run=_cop, write=_write_cop, captions=_COPIED)
CPS = replace(COP, name="CPS")
FLL = action(
    "FLL",
    Use.NUMBER,
    Use.DESTINATION,
    Use.INTEGER,
    run=_fll,
    write=_write_fll,
    captions=_COPIED,
    instead="write a FOR loop",
)
