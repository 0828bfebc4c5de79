"""Instructions on stretches of memory: COP, CPS, FLL."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..interpreter import width_of
from ..operands import Constant, Resolved
from ..regions import Region, plain, region_of
from ..types import LINT

if TYPE_CHECKING:
    from .steps import RungWriter


def cop(rungs: RungWriter, source: Resolved, target: Resolved, length: Resolved) -> None:
    """COP, CPS: bytes from one place to another."""
    layout = rungs.writer.lowered.layout
    regions = region_of(source, layout), region_of(target, layout)
    if isinstance(length, Constant) and _slices(rungs, *regions, int(length.value)):
        return
    firsts = [_first(rungs, each) for each in regions]
    count = rungs.values.term(length, LINT.bits).text
    site = rungs.values.site
    rungs.writer.line(f"copy(region[{site}, 0], {firsts[0]}, region[{site}, 1], {firsts[1]}, {count})")


def _first(rungs: RungWriter, region: Region) -> str:
    flat = rungs.values.flat(region.indices, region.dims, region.text)
    return f"({flat}) * {region.rest}" if region.rest != 1 else flat


def _slices(rungs: RungWriter, source: Region, target: Region, length: int) -> bool:
    """Write a copy between lists of one type as slices; return whether it could be."""
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


def fll(rungs: RungWriter, source: Resolved, target: Resolved, length: Resolved) -> None:
    """FLL: one value into elements of an array."""
    region = region_of(target, rungs.writer.lowered.layout)
    first = _first(rungs, region)
    count = rungs.values.term(length, LINT.bits).text
    value = rungs.values.term(source, width_of(source)).text
    rungs.writer.line(f"fill(region[{rungs.values.site}, 1], {first}, {count}, {value})")
