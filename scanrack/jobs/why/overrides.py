"""Overrides of the program: a force, a fault or the mode of the CPU, or a lost link to a module.

They take precedence in this order. An override determines the value, regardless of the program.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

from scanrack.io_images.addresses import Address
from scanrack.io_images.dataclass import dataclass
from scanrack.io_images.times import seconds
from scanrack.runtime.loop.incidents import FaultKind
from scanrack.runtime.loop.scan import MODE_MASK, CpuMode, ScanFlag
from scanrack.traces.format.layout import SlotInfo
from scanrack.traces.read.reader import TraceEvent
from scanrack.traces.replay import PackedTrace

from ..record.edits_and_forces import forced_in, image_forces
from ..record.link_losses import link_changes
from .past import event_text

SETTLES = 3
"""Number of scans after a link returns that still show changes made while the link was lost."""

CAUSES_OF_LOSS = {
    FaultKind.LINK_LOST.value: "link lost",
    FaultKind.REMOVED.value: "module removed",
    FaultKind.FATAL_ERROR.value: "module failed",
    FaultKind.ASIC_LOST.value: "link lost, the module's bus interface failed",
}


@dataclass(frozen=True, slots=True)
class Override:
    """An override of the program that begins with a scan."""

    kind: str  # of its `CauseLink`: "force", "fault", "mode" or "incident"
    scan: int
    now_ns: int
    text: str


@dataclass(frozen=True, slots=True)
class Loss:
    """A period in which the link to a module was lost."""

    scan: int  # the first one without the link
    now_ns: int
    until: int | None  # the scan in which the link returned; None if it has not
    until_ns: int | None


def forced(events: tuple[TraceEvent, ...], scan: int, names: set[str]) -> Override | None:
    """Return the force on one of several addresses or tags in a scan; None if none of them is forced."""
    first_event: TraceEvent | None = None  # the event that began the force in effect
    forced_value: object = None
    for event in events:
        if event.topic != "/forces" or event.scan > scan:
            continue
        forced_values: Mapping[str, object] = {**image_forces(event), **forced_in(event)}
        value = next((forced_values[name] for name in forced_values if name in names), None)
        if value is None:
            first_event = None
        elif first_event is None or forced_value != value:
            first_event = event
        forced_value = value
    if first_event is None:
        return None
    shown_value = int(forced_value) if isinstance(forced_value, bool) else forced_value
    text = f"forced to {shown_value} since {seconds(first_event.now_ns)} s"
    return Override("force", first_event.scan, first_event.now_ns, text)


def spellings(place: Address) -> set[str]:
    """Return the addresses that can force a bit or word: the bit's address and the word's address."""
    return {str(place), str(replace(place, bit=None))}


def of_cpu(recording: PackedTrace, row: int) -> Override | None:
    """Return why the program is not running in a scan (a fault or program mode); None if it is running."""
    scan = recording.numbers[row]
    if recording.flags[row] & ScanFlag.FAULT:
        faults = [event for event in recording.events if event.topic == "/faults" and event.scan <= scan]
        text = event_text(faults[-1]) if faults else "the CPU faulted"
        return Override("fault", scan, recording.times[row], text)
    mode = CpuMode(recording.flags[row] & MODE_MASK)
    if mode is not CpuMode.PROGRAM:
        return None
    first = row
    while first and CpuMode(recording.flags[first - 1] & MODE_MASK) is mode:
        first -= 1
    now_ns = recording.times[first]
    since = f"the key is at program since {seconds(now_ns)} s"
    text = f"{since}: program mode, tags keep their values, outputs are off"
    return Override("mode", recording.numbers[first], now_ns, text)


def losses(events: Iterable[TraceEvent], slot: int) -> Iterator[Loss]:
    """Yield the periods in which the link to a module was lost, in order."""
    lost: tuple[int, int] | None = None
    for change in link_changes(events, slot):
        if not change.good and lost is None:
            lost = change.scan, change.now_ns
        elif change.good and lost is not None:
            yield Loss(*lost, change.scan, change.now_ns)
            lost = None
    if lost is not None:
        yield Loss(*lost, None, None)


def of_link(recording: PackedTrace, slot: SlotInfo, scan: int) -> Override | None:
    """Return the lost link that determines a module's words in a scan, if it is lost or has just returned."""
    for loss in losses(recording.events, slot.number):
        is_settled = loss.until is not None and scan >= loss.until + SETTLES
        if loss.scan > scan or is_settled:
            continue
        cause = _cause_of_loss(recording.events, slot.number, loss)
        is_removed = cause == CAUSES_OF_LOSS[FaultKind.REMOVED.value]
        head, begin = f"slot {slot.number}: {cause}", seconds(loss.now_ns)
        if loss.until is None or scan < loss.until:
            effect = "its input words are 0" if is_removed else "its inputs keep their last state"
            return Override("incident", loss.scan, loss.now_ns, f"{head} since {begin} s: {effect}")
        assert loss.until_ns is not None
        effect = "its input words were 0" if is_removed else "its inputs kept their last state"
        text = f"{head} from {begin} s to {seconds(loss.until_ns)} s: {effect}"
        rule = _first_rule(recording.events, slot.number, loss)
        return Override(
            "incident", scan, loss.until_ns, text if rule is None else f"{text}; {event_text(rule)}"
        )
    return None


def _cause_of_loss(events: tuple[TraceEvent, ...], slot: int, loss: Loss) -> str:
    """Return the cause of a lost link: the injected fault that was recorded before it."""
    causes = [
        str(event.fields.get("name"))
        for event in events
        if event.topic == "/stimuli"
        and event.fields.get("slot") == slot
        and event.fields.get("begins")
        and event.scan <= loss.scan
        and event.fields.get("name") in CAUSES_OF_LOSS
    ]
    return CAUSES_OF_LOSS[causes[-1]] if causes else "link lost"


def _first_rule(events: tuple[TraceEvent, ...], slot: int, loss: Loss) -> TraceEvent | None:
    """Return the first rule that fired in the module during a loss that is over; None if no rule fired."""
    assert loss.until is not None
    rules = (
        event
        for event in events
        if event.topic == "/events"
        and event.fields.get("slot") == slot
        and event.fields.get("kind") == "rule"
        and loss.scan <= event.scan <= loss.until
    )
    return next(rules, None)
