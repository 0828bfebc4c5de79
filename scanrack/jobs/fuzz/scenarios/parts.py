"""Divides scenarios into parts, and combines parts into scenarios."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields, replace
from typing import Any

from scanrack.runtime.loop.incidents import InjectedFault

from .scenario import ContactPress, OperatorAction, Press, Scenario, Signal, TornUpdate, Turn

Part = tuple[str, Any]
"""The name of a scenario's field, and a part in it."""

FIELDS = tuple(field.name for field in fields(Scenario))

TIMED = {
    Press: "presses",
    ContactPress: "pushes",
    Signal: "signals",
    Turn: "turns",
    InjectedFault: "incidents",
    TornUpdate: "tears",
    OperatorAction: "orders",
}
"""Scenario field of each kind of part with an instant."""

Lasting = Press | ContactPress | Signal | Turn | InjectedFault
"""A part with an instant and a duration."""

Timed = Lasting | TornUpdate | OperatorAction
"""A part with an instant."""


def parts_of(scenario: Scenario) -> list[Part]:
    """Return the parts of a scenario; the inverse of `scenario_of`."""
    return [(name, part) for name in FIELDS for part in getattr(scenario, name)]


def scenario_of(parts: Iterable[Part]) -> Scenario:
    """Return the scenario that consists of the given parts."""
    pairs = list(parts)
    return Scenario(**{name: tuple(part for field, part in pairs if field == name) for name in FIELDS})


def timed_parts(scenario: Scenario) -> list[Timed]:
    """Return the parts of a scenario that have an instant."""
    return [part for field in TIMED.values() for part in getattr(scenario, field)]


def end_ns(part: Timed) -> int:
    """Return the instant at which a part ends. A part without a duration ends when it begins."""
    return part.at_ns + getattr(part, "for_ns", 0)


def with_part(scenario: Scenario, part: Timed) -> Scenario:
    """Return a scenario with one more part."""
    field = TIMED[type(part)]
    return replace(scenario, **{field: (*getattr(scenario, field), part)})
