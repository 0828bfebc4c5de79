"""File instructions: copies between regions of memory."""

from __future__ import annotations

from ..compiler.rungs import RungWriter
from ..interpreter import Interpreter
from ..model.operands import Constant, Resolved, width_moved
from ..model.spec import Use, action
from ..model.tags import Leaf
from ..model.types import LINT
from ..state.regions import ArrayRegion, copy, fill, plain, region_of

# --- COP, CPS: bytes from one place to another


def _cop(machine: Interpreter, source: Resolved, target: Resolved, length: Resolved) -> None:
    origin, goal = machine.end(source), machine.end(target)
    copy(origin, goal, machine.integer(length))


def _write_cop(rungs: RungWriter, source: Resolved, target: Resolved, length: Resolved) -> None:
    regions = region_of(source), region_of(target)
    if isinstance(length, Constant) and _write_slices(rungs, *regions, int(length.value)):
        return
    firsts = [_write_first(rungs, each) for each in regions]
    count = rungs.values.term(length, LINT.bits).text
    site = rungs.values.site
    stores = [rungs.values.store_of(each.parts[0].leaf) for each in regions]
    parts = [f"region[{site}, 0]", firsts[0], f"region[{site}, 1]", firsts[1], count]
    rungs.writer.line(f"copy({', '.join(parts + (stores if stores != ['None', 'None'] else []))})")


def _write_first(rungs: RungWriter, region: ArrayRegion) -> str:
    flat = rungs.values.flat(region.parts[0].leaf, region.indices, region.text)
    return f"({flat}) * {region.rest}" if region.rest != 1 and region.indices else flat


def _write_slices(rungs: RungWriter, source: ArrayRegion, target: ArrayRegion, length: int) -> bool:
    """Write a copy between lists of one type as slices; return whether that is possible."""
    first, at = source.fixed_first, target.fixed_first
    if plain(source) is None or plain(source) != plain(target) or first is None or at is None:
        return False
    if source.whole or target.whole:
        return _write_row(rungs, (source, first), (target, at), length)
    count = min(length, target.fixed_left(at), source.fixed_left(first))
    if count < 1:
        return True
    origin, goal = source.parts[0].leaf, target.parts[0].leaf
    text = _write_slice(rungs, origin, first, count)
    if rungs.writer.is_live(origin):
        text += ".tolist()"
    if rungs.writer.is_live(goal):
        text = f'array("h", {text})'
    rungs.writer.line(f"{_write_slice(rungs, goal, at, count)} = {text}")
    return True


def _write_row(
    rungs: RungWriter, source: tuple[ArrayRegion, int], target: tuple[ArrayRegion, int], length: int
) -> bool:
    """Write a copy from or to an InOut as a whole: the length of its array is known in the call only."""
    kind = plain(source[0])
    if kind is None or kind.is_bool:  # an InOut may be a bit of an integer
        return False
    ends = [str(length)]
    places = []
    for region, first in (target, source):
        leaf = region.parts[0].leaf
        places += [rungs.writer.name(leaf), rungs.values.row(leaf, first)]
        left = rungs.writer.handed(leaf.root)[2] if region.whole else str(region.fixed_left(first))
        ends.append(f"{left} - {first}" if region.whole and first else left)
    rungs.writer.line(f"copy_row({', '.join(places)}, min({', '.join(ends)}))")
    return True


def _write_slice(rungs: RungWriter, leaf: Leaf, first: int, count: int) -> str:
    """Return text for consecutive elements."""
    begin = rungs.values.row(leaf, first)
    end = f"{int(begin) + count}" if begin.isdigit() else f"{begin} + {count}"
    return f"{rungs.writer.name(leaf)}[{begin}:{end}]"


# --- FLL: one value into elements of an array, without flags and faults


def _fll(machine: Interpreter, source: Resolved, target: Resolved, length: Resolved) -> None:
    end = machine.end(target)
    fill(end, machine.integer(length), machine.number(source, _width_filled(source, end[1])))


def _write_fll(rungs: RungWriter, source: Resolved, target: Resolved, length: Resolved) -> None:
    region = region_of(target)
    first = _write_first(rungs, region)
    count = rungs.values.term(length, LINT.bits).text
    value = rungs.values.term(source, _width_filled(source, region)).text
    store = rungs.values.store_of(region.parts[0].leaf)
    goal = f", {store}" if store != "None" else ""
    rungs.writer.line(f"fill(region[{rungs.values.site}, 1], {first}, {count}, {value}{goal})")


def _width_filled(source: Resolved, region: ArrayRegion) -> int:
    return width_moved(source, *(part.leaf.type for part in region.parts))


# --- the rows

_COPIED = ("Source", "Dest", "Length")

COP = action("COP", Use.SOURCE, Use.DESTINATION, Use.INTEGER, run=_cop, write=_write_cop, captions=_COPIED)
CPS = action("CPS", Use.SOURCE, Use.DESTINATION, Use.INTEGER, run=_cop, write=_write_cop, captions=_COPIED)
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
