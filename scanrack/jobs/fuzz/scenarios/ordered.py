"""Converts the orders of a session to parts of a scenario: injected faults, key turns, and card contacts.

Orders for the inputs of an axis are left out, since the recorded stimuli include them. Forces and written
tags are also left out.
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


def with_orders(scenario: Scenario, orders: Sequence[RecordedOrder], spec: RackSpec, end_ns: int) -> Scenario:
    """Return a scenario with the orders of a session."""
    incidents = [*scenario.incidents, *_incidents(orders, spec), *_key_turns(orders, spec, end_ns)]
    incidents.sort(key=lambda incident: incident.at_ns)
    pushes = (*scenario.pushes, *_pushes(orders, spec, end_ns))
    return replace(scenario, incidents=tuple(incidents), pushes=pushes)


def _incidents(orders: Iterable[RecordedOrder], spec: RackSpec) -> Iterator[InjectedFault]:
    """Yield the faults that the orders inject."""
    for scan, order in orders:
        if isinstance(order, InjectFault):
            yield InjectedFault(
                at_ns=scan * spec.scan_ns,
                what=FaultKind(order.kind),
                slot=order.slot,
                for_ns=round(order.for_ms * 1_000_000),
                late_words=order.late_words,
                state=order.state,
            )


def _key_turns(orders: Iterable[RecordedOrder], spec: RackSpec, end_ns: int) -> Iterator[InjectedFault]:
    """Yield a fault for each period in which the key is in the program position."""
    program_ns: int | None = None  # time of the turn to program
    for scan, order in orders:
        if not isinstance(order, Mode):
            continue
        at_ns = scan * spec.scan_ns
        if order.mode == "program":
            program_ns = at_ns if program_ns is None else program_ns
        elif program_ns is not None:
            yield InjectedFault(program_ns, FaultKind.PROGRAM_MODE, 0, at_ns - program_ns)
            program_ns = None
    if program_ns is not None and program_ns < end_ns:
        yield InjectedFault(program_ns, FaultKind.PROGRAM_MODE, 0)


def _pushes(orders: Iterable[RecordedOrder], spec: RackSpec, end_ns: int) -> Iterator[ContactPress]:
    """Yield each period in which a card contact was operated."""
    cards = {slot.number: slot for slot in spec.slot if "input" in slot.words.groups}
    changes_by_contact: dict[tuple[int, str], list[tuple[int, bool]]] = defaultdict(list)
    for scan, order in orders:
        if isinstance(order, Press) and order.slot in cards and order.on is not None:
            is_operated = order.on is not _is_normally_closed(cards[order.slot], order.name)
            changes_by_contact[order.slot, order.name].append((scan * spec.scan_ns, is_operated))
    for (slot, name), changes in changes_by_contact.items():
        end_times_ns = [at_ns for at_ns, _ in changes[1:]] + [end_ns]
        for (at_ns, is_operated), until_ns in zip(changes, end_times_ns, strict=True):
            if is_operated and until_ns > at_ns:
                yield ContactPress(slot, name, at_ns, until_ns - at_ns)


def _is_normally_closed(card: SlotSpec, name: str) -> bool:
    names = card.options.get("normally_closed", ())
    return isinstance(names, list | tuple) and name in names
