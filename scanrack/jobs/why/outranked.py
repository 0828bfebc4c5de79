"""What overrides every rung and line: a force, the CPU's mode or fault, a lost link, a module without power.

They take precedence in this order. One that is in effect determines the value, whatever the program writes.
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
"""Number of scans after a link returns in which a module's words still show what changed meanwhile."""

CAUSES_OF_LOSS = {
    FaultKind.LINK_LOST.value: "link lost",
    FaultKind.REMOVED.value: "module removed",
    FaultKind.FATAL_ERROR.value: "module failed",
    FaultKind.ASIC_LOST.value: "link lost, the module's bus interface failed",
}


@dataclass(frozen=True, slots=True)
class Outranking:
    """An override of the program that begins with a scan."""

    kind: str  # the kind of its link
    scan: int
    now_ns: int
    text: str


@dataclass(frozen=True, slots=True)
class Loss:
    """A time in which the link to a module was lost; `until` is None while it still is."""

    scan: int
    now_ns: int
    until: int | None
    until_ns: int | None


def forced(events: tuple[TraceEvent, ...], scan: int, names: set[str]) -> Outranking | None:
    """Return the force on one of the given addresses or tags in a scan; None if none of them is forced."""
    since: tuple[TraceEvent, object] | None = None
    for force_event in events:
        if force_event.topic != "/forces" or force_event.scan > scan:
            continue
        forced_values: Mapping[str, object] = {**image_forces(force_event), **forced_in(force_event)}
        value = next((forced_values[name] for name in forced_values if name in names), None)
        if value is None:
            since = None
        elif since is None or since[1] != value:
            since = force_event, value
    if since is None:
        return None
    event, value = since
    text = f"forced to {int(value) if isinstance(value, bool) else value} since {seconds(event.now_ns)} s"
    return Outranking("force", event.scan, event.now_ns, text)


def spellings(place: Address) -> set[str]:
    """Return the addresses under which a bit or word may be forced: its own, and that of its word."""
    return {str(place), str(replace(place, bit=None))}


def of_cpu(recording: PackedTrace, row: int) -> Outranking | None:
    """Return what keeps the program from running in a scan: a fault, or the key; None if it runs."""
    scan = recording.numbers[row]
    if recording.flags[row] & ScanFlag.FAULT:
        known = [event for event in recording.events if event.topic == "/faults" and event.scan <= scan]
        text = event_text(known[-1]) if known else "the CPU faulted"
        return Outranking("fault", scan, recording.times[row], text)
    mode = CpuMode(recording.flags[row] & MODE_MASK)
    if mode is not CpuMode.PROGRAM:
        return None
    first = row
    while first and CpuMode(recording.flags[first - 1] & MODE_MASK) is mode:
        first -= 1
    now_ns = recording.times[first]
    since = f"the key is at program since {seconds(now_ns)} s"
    text = f"{since}: program mode, tags keep their values, outputs are off"
    return Outranking("mode", recording.numbers[first], now_ns, text)


def losses(events: Iterable[TraceEvent], slot: int) -> Iterator[Loss]:
    """Yield the times in which the link to a module was lost, in order."""
    lost: tuple[int, int] | None = None
    for change in link_changes(events, slot):
        if not change.good and lost is None:
            lost = change.scan, change.now_ns
        elif change.good and lost is not None:
            yield Loss(*lost, change.scan, change.now_ns)
            lost = None
    if lost is not None:
        yield Loss(*lost, None, None)


def of_link(recording: PackedTrace, slot: SlotInfo, scan: int) -> Outranking | None:
    """Return the lost link that determines a module's words in a scan, if it is lost or has just returned."""
    for loss in losses(recording.events, slot.number):
        if loss.scan > scan or (loss.until is not None and scan >= loss.until + SETTLES):
            continue
        why = _reason(recording.events, slot.number, loss)
        begun = seconds(loss.now_ns)
        if loss.until is None or scan < loss.until:
            text = f"slot {slot.number}: {why} since {begun} s: {_shows(why, is_over=False)}"
            return Outranking("incident", loss.scan, loss.now_ns, text)
        assert loss.until_ns is not None
        rules = "".join(f"; {text}" for text in _rules(recording.events, slot.number, loss))
        text = (
            f"slot {slot.number}: {why} from {begun} s to {seconds(loss.until_ns)} s: "
            f"{_shows(why, is_over=True)}"
        )
        return Outranking("incident", scan, loss.until_ns, f"{text}{rules}")
    return None


def _shows(why: str, *, is_over: bool) -> str:
    """Return what the PLC reads meanwhile: no words of a removed module, the last words over a lost link."""
    if why == CAUSES_OF_LOSS[FaultKind.REMOVED.value]:
        return "its input words were 0" if is_over else "its input words are 0"
    return "its inputs stood still" if is_over else "its inputs stand still"


def _reason(events: tuple[TraceEvent, ...], slot: int, loss: Loss) -> str:
    """Return the cause of a lost link: the recorded incident before it."""
    known = [
        str(event.fields.get("name"))
        for event in events
        if event.topic == "/stimuli"
        and event.fields.get("slot") == slot
        and event.fields.get("begins")
        and event.scan <= loss.scan
        and event.fields.get("name") in CAUSES_OF_LOSS
    ]
    return CAUSES_OF_LOSS[known[-1]] if known else "link lost"


def _rules(events: tuple[TraceEvent, ...], slot: int, loss: Loss) -> Iterator[str]:
    """Yield the first rule that fired in the module while it was out of reach."""
    assert loss.until is not None
    for event in events:
        own = (
            event.topic == "/events"
            and event.fields.get("slot") == slot
            and event.fields.get("kind") == "rule"
        )
        if own and loss.scan <= event.scan <= loss.until:
            yield event_text(event)
            return
