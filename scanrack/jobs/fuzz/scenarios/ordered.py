"""Turns the orders of a session into parts of a scenario: injected faults, key turns, and card contacts.

The inputs of an axis are left out because the recorded stimuli have them. Forces and written tags are left
out, too.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from scanrack.runtime.config.rackspec import RackSpec, SlotSpec
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
    """Yield a fault for each period in which the key was at program."""
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
    """Yield each period in which a contact of a card was operated."""
    cards = {slot.number: slot for slot in spec.slot if "input" in slot.words.groups}
    levels: dict[tuple[int, str], list[tuple[int, bool]]] = defaultdict(list)
    for scan, order in given:
        if isinstance(order, Press) and order.slot in cards and order.on is not None:
            operated = order.on is not _is_on_at_rest(cards[order.slot], order.name)
            levels[order.slot, order.name].append((scan * spec.scan_ns, operated))
    for (slot, name), changes in levels.items():
        ends = [at_ns for at_ns, _operated in changes[1:]] + [end_ns]
        for (at_ns, operated), until_ns in zip(changes, ends, strict=True):
            if operated and until_ns > at_ns:
                yield ContactPress(slot, name, at_ns, until_ns - at_ns)


def _is_on_at_rest(card: SlotSpec, name: str) -> bool:
    """Return whether a contact of a card is normally closed."""
    closed = card.options.get("normally_closed", ())
    return isinstance(closed, list | tuple) and name in closed
