"""Orders of a session as parts of a scenario: incidents, the key, and contacts of cards.

Inputs of an axis are among the recorded stimuli already. Forces and written tags are left
out: a scenario has none.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.live.actions import InjectFault, Mode, Press
from scanrack.runtime.loop.incidents import FaultKind, InjectedFault

from ...record.order_repeater import RecordedOrder
from .scenario import ContactPress, Scenario


def with_orders(scenario: Scenario, given: Sequence[RecordedOrder], spec: RackSpec, end_ns: int) -> Scenario:
    """Return a scenario with the orders of a session added."""
    incidents = [*scenario.incidents, *_incidents(given, spec), *_turns(given, spec, end_ns)]
    incidents.sort(key=lambda each: each.at_ns)
    pushes = (*scenario.pushes, *_pushes(given, spec, end_ns))
    return replace(scenario, incidents=tuple(incidents), pushes=pushes)


def _incidents(given: Iterable[RecordedOrder], spec: RackSpec) -> Iterator[InjectedFault]:
    for scan, order in given:
        if isinstance(order, InjectFault):
            for_ns = round(order.for_ms * 1_000_000)
            yield InjectedFault(
                scan * spec.scan_ns, FaultKind(order.kind), order.slot, for_ns, order.late_words, order.state
            )


def _turns(given: Iterable[RecordedOrder], spec: RackSpec, end_ns: int) -> Iterator[InjectedFault]:
    """Yield the periods in which the key was at program."""
    since: int | None = None
    for scan, order in given:
        if not isinstance(order, Mode):
            continue
        at_ns = scan * spec.scan_ns
        if order.mode == "program":
            since = at_ns if since is None else since
        elif since is not None:
            yield InjectedFault(since, FaultKind.PROGRAM_MODE, 0, at_ns - since)
            since = None
    if since is not None and since < end_ns:
        yield InjectedFault(since, FaultKind.PROGRAM_MODE, 0)


def _pushes(given: Iterable[RecordedOrder], spec: RackSpec, end_ns: int) -> Iterator[ContactPress]:
    """Yield the periods in which a contact of a card was operated."""
    cards = [slot for slot in spec.slot if "input" in slot.words.groups]
    closed = {slot.number: slot.options.get("normally_closed", ()) for slot in cards}
    levels: dict[tuple[int, str], list[tuple[int, bool]]] = defaultdict(list)
    for scan, order in given:
        if isinstance(order, Press) and order.slot in closed and order.on is not None:
            at_rest = closed[order.slot]
            rest = isinstance(at_rest, list | tuple) and order.name in at_rest
            levels[order.slot, order.name].append((scan * spec.scan_ns, order.on is not rest))
    for (slot, name), changes in levels.items():
        ends = [at_ns for at_ns, _operated in changes[1:]] + [end_ns]
        for (at_ns, operated), until_ns in zip(changes, ends, strict=True):
            if operated and until_ns > at_ns:
                yield ContactPress(slot, name, at_ns, until_ns - at_ns)
