"""Axes of a program on 3601s of the rack: one block per axis, run after every scan.

An axis `Feed` adds the tags `Feed_3601`, an AXIS_3601, and `Feed_Module`, the instance of `Amci3601` that
owns the module's words; the routine `Axes3601` calls all of them. Motion instructions use the block, see
`instructions.motion_3601`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from ...io_images.site import Site
from ..instructions.motion.axes import AxisSettings
from ..instructions.motion.motion_3601 import Axis, BoundAxis, show
from ..model.errors import LadderError, Problem
from ..model.expressions import parse_address
from ..model.operands import Group
from ..model.predefined.motion_types import is_axis
from ..model.tags import Tag
from ..model.tree import Routine, Rung
from ..model.types import Structure
from .addon import AddOn, specs_of
from .lowering import Lowering
from .text import parse_rung

BLOCK = "AMCI3601"
ROUTINE = "Axes3601"
"""The routine that calls the blocks."""


@dataclass(frozen=True, slots=True)
class Axes:
    """Axes of a program on 3601s of the rack."""

    settings: Mapping[str, AxisSettings]  # by tag
    state: Structure  # the type AXIS_3601
    block: AddOn  # the add-on instruction Amci3601


def names_of(axis: str) -> tuple[str, str]:
    """Return the names of the tags that an axis adds.

    >>> names_of("Feed")
    ('Feed_3601', 'Feed_Module')
    """
    plain = axis.replace("\\", "").replace(".", "_")
    return f"{plain}_3601", f"{plain}_Module"


def axis_tags(axes: Axes | None) -> Iterator[Tag]:
    """Yield the tags that axes add."""
    for name, settings in axes.settings.items() if axes else ():
        state, module = names_of(name)
        assert axes is not None
        yield Tag(state, axes.state, (), {"RoundTrip": settings.round_trip_ms})
        yield Tag(module, axes.block.structure)


def with_blocks(add_ons: Mapping[str, AddOn], axes: Axes | None) -> Mapping[str, AddOn]:
    """Return add-on instructions, with the 3601's block if there are axes."""
    return {**add_ons, BLOCK: axes.block} if axes else add_ons


def lower_axes(lowering: Lowering, axes: Axes | None) -> list[Problem]:
    """Lower the routine of the blocks and bind the axes; return the problems."""
    if axes is None:
        return []
    problems: list[Problem] = []
    bound: dict[str, BoundAxis] = {}
    rungs: list[Rung] = []
    lowering.enter("")
    for name, settings in axes.settings.items():
        state, module = names_of(name)
        try:
            tag = lowering.resolver.address(parse_address(name))
        except LadderError as error:
            problems.append(
                Problem(f"axis {name}", "", str(error), "name an axis of the program", Site(tag=name))
            )
            continue
        if not isinstance(tag, Group) or not is_axis(tag.type) or tag.indices:
            remedy = "name a tag of type AXIS_..."
            problems.append(Problem(f"axis {name}", "", f"{name} is not an axis", remedy, Site(tag=name)))
            continue
        found = lowering.resolver.address(parse_address(state))
        assert isinstance(found, Group)
        bound[tag.path.upper()] = BoundAxis(settings, tag, found)
        images = ",".join(f"Local:{settings.slot}:{way}.Data[0]" for way in "IO")
        text = f"MOV(Local:{settings.slot}:I.Fault,{module}.Fault)Amci3601({module},{state},{images});"
        rungs.append(parse_rung(text, specs=specs_of(with_blocks({}, axes))))
    lowering.lowered.axes = bound
    lowering.routine(Routine(ROUTINE, tuple(rungs), "the blocks of the axes"))
    return problems


def prescan_axes(engine: Any, first: bool) -> None:
    """Number the axes and prescan the blocks before the first scan."""
    if not first:
        return
    for number, each in enumerate(engine.lowered.axes.values(), 1):
        engine.interpreter.put(each.tag.member("~axis"), number)
    engine.interpreter.prescan(ROUTINE.upper())


def run_axes(engine: Any) -> None:
    """Run the blocks, and update the tags of the axes."""
    engine.call_routine(ROUTINE.upper(), ())
    machine = engine.interpreter
    machine.now_ns, machine.frame = engine.now_ns, {}
    for each in engine.lowered.axes.values():
        show(Axis(machine, each))
