"""Cause chains for answers to pages, as links in JSON, each with its rung or line."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from scanrack.io_images.addresses import parse_address
from scanrack.jobs.why.bits import Bits
from scanrack.jobs.why.chain import RackChain
from scanrack.ladder.debug import CauseLink, Chains, linked
from scanrack.ladder.debug.causes import Causes
from scanrack.ladder.debug.links import link_text
from scanrack.runtime.loop.faults import Fault
from scanrack.traces.format.layout import SlotInfo, block_layout
from scanrack.traces.read.packed import PackedScans
from scanrack.traces.read.reader import TraceEvent
from scanrack.traces.replay import PackedTrace

from ..history.timeline import columns_of
from .monitor import BACK, Json, Monitor

MOST_LINKS = 60
"""Maximum number of links that a page gets, the closest first."""

DEEPEST = 40
"""Maximum depth of a chain, since each link takes as long as a scan."""

_TOPICS = {
    "rule": "/events",
    "move": "/events",
    "stimulus": "/stimuli",
    "order": "/orders",
    "faults": "/faults",
    "indicator": "/indicators",
}


def chain_of(monitor: Monitor, causes: Causes, tag: str, scan: int) -> CauseLink | None:
    """Return the chain of a ladder program's tag after a scan; None without a known cause."""
    return next(iter(_chains(monitor, causes, [tag], scan)), None)


def chain_of_fault(monitor: Monitor, causes: Causes, fault: Fault, tags: Sequence[str]) -> list[Json]:
    """Return the links of a major fault. Its causes are the tags that its rung read."""
    groups = [(chain,) for chain in _chains(monitor, causes, tags, fault.scan)]
    root = linked(
        groups,
        kind="fault",
        name="CPU fault",
        value=None,
        scan=fault.scan,
        now_ns=fault.now_ns,
        text=fault.text,
        site=fault.site,
    )
    return links_of(root) if groups else []


def _chains(monitor: Monitor, causes: Causes, tags: Sequence[str], scan: int) -> list[CauseLink]:
    """Return the known chains of tags and of image words and bits after a scan."""
    rows = monitor.subject.timeline.between(max(0, scan - BACK), scan)
    if not len(rows):
        return []
    words = monitor.subject.words
    slots = tuple(
        SlotInfo(slot.number, slot.module, words=words[slot.number])
        for slot in sorted(monitor.subject.spec.slot, key=lambda slot: slot.number)
    )
    known_events = monitor.states.up_to(scan, BACK)
    events = tuple(_event(event, monitor.states.forces_at(event["scan"])) for event in known_events)
    recording = PackedTrace(slots, PackedScans.of(block_layout(slots).words, [columns_of(rows)]), events)

    def chains(*, deep: bool, **hooks: Any) -> Chains:
        return Chains(causes.engine.lowered, causes, deep, most=DEEPEST, **hooks)

    rack, last = RackChain(recording, chains), len(rows) - 1
    tag_chains = []
    for tag in tags:
        try:
            bits = Bits.at(parse_address(tag, words))
        except ValueError:
            tag_chains.append(rack.of_tag(tag, last))
        else:
            tag_chains.append(rack.of_bits(bits, tag, last))
    return [chain for chain in tag_chains if chain is not None]


def _event(event: Mapping[str, Any], forces: Json) -> TraceEvent:
    """Return a page's event as an event of a recording; a force event gets the given forces."""
    fields: Json = {
        key: event[key] for key in ("slot", "kind", "name", "text", "module", "order") if key in event
    }
    if event["kind"] == "forces":
        fields = {"tags": forces}
    return TraceEvent(event["scan"], event["t"], _TOPICS.get(event["kind"], f"/{event['kind']}"), fields)


def links_of(chain: CauseLink) -> list[Json]:
    """Return the links of a chain for a page, each with the numbers of its causes in the list."""
    links = list(chain.walk())[:MOST_LINKS]
    numbers = {link: number for number, link in enumerate(links)}
    return [
        {
            "scan": link.scan,
            "t": link.now_ns,
            "kind": link.kind,
            "name": link.name,
            "text": link_text(link),
            "at": _place_of(link),
            "causes": [group for group in _cause_groups(link, numbers) if group],
        }
        for link in links
    ]


def _cause_groups(link: CauseLink, numbers: Mapping[CauseLink, int]) -> Iterator[list[int]]:
    """Yield the numbers of a link's causes, by group, without causes beyond `MOST_LINKS`."""
    for group in link.causes:
        yield [numbers[cause] for cause in group if cause in numbers]


def _place_of(link: CauseLink) -> str | None:
    """Return the rung or line of a link in a page's notation: `Main.3`, `line.py.12`."""
    site = link.site
    if site is None:
        return None
    if site.routine:
        return f"{site.routine}.{site.rung}"
    return f"{site.file}.{site.line}" if site.file else None
