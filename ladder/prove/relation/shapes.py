"""Comparable forms of program parts. Two parts with equal forms are equal, regardless of their location.

A part of an unknown kind equals only itself.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

from ...model.operands import Constant, Group, Place
from ...model.spec import Spec
from ...model.tags import Leaf
from ...state.lowered import LoweredLine, LoweredProgram, LoweredRoutine, LoweredStep


def shape_of(part: Any) -> Hashable:
    """Return the form of a part as nested tuples; a hashable part of an unknown kind is its own form."""
    if part is None or isinstance(part, (str, int, float)):
        return type(part), repr(part)
    if isinstance(part, (tuple, list)):
        return tuple(map(shape_of, part))
    if isinstance(part, Mapping):
        return tuple(sorted((repr(name), shape_of(value)) for name, value in part.items()))
    names = _OWN.get(type(part))
    if names is not None:
        return type(part), *[shape_of(getattr(part, name)) for name in names]
    if is_dataclass(part) and not isinstance(part, (type, Spec)):
        return type(part), *[shape_of(getattr(part, field.name)) for field in fields(part) if field.compare]
    return part if isinstance(part, Hashable) else object()


_OWN: Mapping[type, tuple[str, ...]] = {
    Constant: ("type", "value"),
    Place: ("leaf", "indices", "bit", "array"),
    Group: ("type", "path", "indices", "dims", "array"),
    Leaf: ("path", "type", "dims", "slot", "output", "root", "outer"),
    LoweredStep: ("spec", "operands"),
    LoweredLine: ("nodes",),
}
"""Attributes that are compared; text positions and layout are not among them."""


def form_of(lowered: LoweredProgram) -> Hashable:
    """Return the form of everything that a program executes, not including tags."""
    routines = tuple(sorted((name, _routine(routine)) for name, routine in lowered.routines.items()))
    frames = shape_of(
        {name: (frame.presets, frame.written, frame.bits) for name, frame in lowered.frames.items()}
    )
    return (
        routines,
        frames,
        lowered.main,
        lowered.monitors,
        lowered.flags,
        lowered.override,
        world_of(lowered),
    )


def _routine(routine: LoweredRoutine) -> Hashable:
    inside = routine.lines if routine.body is None else routine.body
    return shape_of((routine.labels, routine.parameters, routine.frame, inside))


def world_of(lowered: LoweredProgram) -> Hashable:
    """Return the form of a program's environment: its name, tasks, stubs and connections."""
    schedule = lowered.schedule
    tasks = () if schedule is None else tuple(_task(scheduled.task) for scheduled in schedule.tasks)
    return lowered.name, tasks, shape_of((lowered.stubs, lowered.connections, lowered.replies))


def _task(task: Any) -> Hashable:
    return task.name, task.kind, task.programs, task.rate_ns, task.priority, task.preempt
