"""Axes of a program. An axis on a 3601 has a block that runs after every scan; other axes are ideal.

An axis `Feed` adds the tags `Feed_3601`, an AXIS_3601, and `Feed_Module`, the instance of `Amci3601` that
owns the module's words; the routine `Axes3601` calls all instances. Motion instructions use the block; see
`instructions.motion_3601`. For ideal axes see `instructions.ideal_axis`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.site import Site

from ..instructions.motion.axes import AxisSettings, MotionData
from ..instructions.motion.axis_3601 import Axis, BoundAxis, update_tag
from ..instructions.motion.ideal_axis import IdealAxis, update_axes
from ..instructions.motion.ideal_systems import SIZE, update_systems
from ..instructions.motion.spots import Ideal, MotionPart
from ..model.errors import LadderError, Problem
from ..model.expressions import parse_address
from ..model.operands import Group
from ..model.predefined.motion_types import COORDINATE_SYSTEM, is_axis
from ..model.routine import Routine
from ..model.spec import Use
from ..model.tags import Tag
from ..model.tree import Rung
from ..model.types import Structure, count_of
from ..state.lowered import LoweredProgram
from .addon import AddOn, specs_of
from .rungs import Lowering
from .text import parse_rung

BLOCK = "AMCI3601"
ROUTINE = "Axes3601"
"""The routine that calls the blocks."""


@dataclass(frozen=True, slots=True)
class Axes:
    """Axes of a program that are named in a rack file."""

    settings: Mapping[str, AxisSettings]  # axes on 3601s, by tag
    ideal: Mapping[str, AxisSettings]  # ideal axes, by tag
    state: Structure  # the type AXIS_3601
    block: AddOn  # the add-on instruction Amci3601


def added_names(axis: str) -> tuple[str, str]:
    """Return the names of the tags that an axis adds.

    >>> added_names("Feed")
    ('Feed_3601', 'Feed_Module')
    """
    stem = axis.replace("\\", "").replace(".", "_")
    return f"{stem}_3601", f"{stem}_Module"


def axis_tags(axes: Axes | None) -> Iterator[Tag]:
    """Yield the tags that axes add."""
    for name, settings in axes.settings.items() if axes else ():
        state, module = added_names(name)
        assert axes is not None
        yield Tag(state, axes.state, (), {"RoundTrip": settings.round_trip_ms})
        yield Tag(module, axes.block.structure)


def with_blocks(add_ons: Mapping[str, AddOn], axes: Axes | None) -> Mapping[str, AddOn]:
    """Return add-on instructions, including the 3601's block if the rack names axes."""
    return {**add_ons, BLOCK: axes.block} if axes else add_ons


def lower_axes(lowering: Lowering, axes: Axes | None, data: MotionData) -> list[Problem]:
    """Lower the routine of the blocks and number all axes; return the problems."""
    problems: list[Problem] = []
    settings: dict[str, AxisSettings] = {}
    lowering.enter("")
    if axes is not None:
        problems += _lower_blocks(lowering, axes)
        for name, axis_settings in axes.ideal.items():
            tag = _resolved_axis(lowering, name, problems)
            if tag is not None:
                settings[tag.path.upper()] = axis_settings
    _number_axes(lowering.lowered, settings, data)
    return problems


def _resolved_axis(lowering: Lowering, name: str, problems: list[Problem]) -> Group | None:
    """Return the tag of an axis; add a problem and return None if it is not an axis."""
    remedy = "name an axis of the program"
    try:
        tag = lowering.resolver.address(parse_address(name))
        if isinstance(tag, Group) and is_axis(tag.type) and not tag.indices:
            return tag
        text, remedy = f"{name} is not an axis", "name a tag of type AXIS_..."
    except LadderError as error:
        text = str(error)
    problems.append(Problem(f"axis {name}", "", text, remedy, Site(tag=name)))
    return None


def _lower_blocks(lowering: Lowering, axes: Axes) -> list[Problem]:
    """Lower the routine that calls the blocks, and record the axes on 3601s; return the problems."""
    problems: list[Problem] = []
    bound: dict[str, BoundAxis] = {}
    rungs: list[Rung] = []
    for name, settings in axes.settings.items():
        state, module = added_names(name)
        tag = _resolved_axis(lowering, name, problems)
        if tag is None:
            continue
        group = lowering.resolver.address(parse_address(state))
        assert isinstance(group, Group)
        bound[tag.path.upper()] = BoundAxis(settings, tag, group)
        images = ",".join(f"Local:{settings.slot}:{letter}.Data[0]" for letter in "IO")
        text = f"MOV(Local:{settings.slot}:I.Fault,{module}.Fault)Amci3601({module},{state},{images});"
        rungs.append(parse_rung(text, specs=specs_of(with_blocks({}, axes))))
    lowering.lowered.axes = bound
    lowering.routine(Routine(ROUTINE, tuple(rungs), "the blocks of the axes"))
    return problems


def _elements_of(tag: Tag) -> Iterator[MotionPart]:
    """Yield the elements of a tag."""
    for index in range(count_of(tag.dims)):
        yield MotionPart(tag.name, index, f"{tag.name}[{index}]" if tag.dims else tag.name, tag.type.name)


def _controls(lowered: LoweredProgram) -> Iterator[MotionPart]:
    """Yield the motion instructions of a program, including those in add-on instructions."""
    for leaf in lowered.layout.leaves_ending_in("~ticket"):
        path = leaf.path.rpartition(".")[0]
        for index in range(leaf.size):
            yield MotionPart(path, index, path)


def _number_axes(lowered: LoweredProgram, settings: Mapping[str, AxisSettings], data: MotionData) -> None:
    """Number the axes, coordinate systems and controls of a program with motion instructions.

    The numbers are initial values of hidden members: above 0 for axes on 3601s, below 0 for ideal axes.
    """
    numbers = {path: number for number, path in enumerate(lowered.axes, 1)}
    lowered.presets |= {(f"{path}.~axis", 0): number for path, number in numbers.items()}
    if not _has_motion(lowered):
        return
    elements = [(tag, element) for tag in lowered.layout.tags().values() for element in _elements_of(tag)]
    axes = [element for tag, element in elements if is_axis(tag.type) and element.path.upper() not in numbers]
    systems = [element for tag, element in elements if tag.type == COORDINATE_SYSTEM]
    controls = list(_controls(lowered))
    for number, element in enumerate(axes, 1):
        lowered.presets[f"{element.path}.~axis", element.index] = -number
        numbers.setdefault(element.path.upper(), -number)
    lowered.presets |= _presets(systems) | _presets(controls)
    lowered.ideal = Ideal(
        tuple((axis, _settings(axis.path.upper(), settings, data)) for axis in axes),
        tuple((system, _axes_of(system.path.upper(), numbers, data)) for system in systems),
        tuple(controls),
    )


def _has_motion(lowered: LoweredProgram) -> bool:
    return any(Use.MOTION in step.uses for step in lowered.all_steps)


def _presets(parts: Sequence[MotionPart]) -> dict[tuple[str, int], int]:
    """Return the numbers of coordinate systems or controls by path and index."""
    return {(f"{part.path}.~number", part.index): number for number, part in enumerate(parts, 1)}


def _settings(path: str, settings: Mapping[str, AxisSettings], data: MotionData) -> AxisSettings:
    return settings.get(path) or AxisSettings(unwind=data.unwinds.get(path, 0.0))


def _axes_of(path: str, numbers: Mapping[str, int], data: MotionData) -> tuple[int, ...]:
    return tuple(numbers.get(axis.upper(), 0) for axis in data.systems.get(path, ())[:SIZE])


def prescan_axes(engine: Any, first: bool) -> None:
    """Prescan the blocks before the first scan; ideal axes are at rest."""
    if not first:
        return
    engine.interpreter.prescan(ROUTINE.upper())
    ideal = engine.lowered.ideal
    for number in range(1, len(ideal.axes) + 1 if ideal else 1):
        IdealAxis(engine.memory, ideal, -number).stop_at_once(engine.now_ns)


def run_axes(engine: Any) -> None:
    """Run the blocks, move the ideal axes, and update the tags of all axes."""
    machine, lowered = engine.interpreter, engine.lowered
    bound = [Axis(machine, lowered_axis) for lowered_axis in lowered.axes.values()]
    if bound:
        engine.call_routine(ROUTINE.upper(), ())
        machine.now_ns, machine.frame = engine.now_ns, {}
        for axis in bound:
            update_tag(axis)
    if lowered.ideal is not None:
        update_systems(engine.memory, lowered.ideal, engine.now_ns)
        masters = {
            number: (float(bound_axis.tag["~position"]), float(bound_axis.tag["ActualVelocity"]))
            for number, bound_axis in enumerate(bound, 1)
        }
        update_axes(engine.memory, lowered.ideal, engine.now_ns, masters)
