"""The chain of causes in an answer to a page: its links as JSON, each with its rung or line."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from ...jobs.why.chain import RackChain
from ...ladder.debug import CauseLink, Chains
from ...ladder.debug.causes import Causes
from ...ladder.debug.links import said
from ...traces.format.layout import SlotInfo
from ...traces.read.packed import PackedScans
from ...traces.read.reader import TraceEvent
from ...traces.replay import Recording
from ..history.shadow import Shadow
from ..history.timeline import columns_of
from .monitor import Json, Monitor

BACK = 16_384
"""Scans of images that are looked at."""

MOST_LINKS = 60
"""Most links that a page receives, the shortest ways first."""

_TOPICS = {
    "rule": "/events",
    "move": "/events",
    "stimulus": "/stimuli",
    "order": "/orders",
    "faults": "/faults",
}


def chain_of(monitor: Monitor, shadow: Shadow, tag: str, scan: int) -> list[Json]:
    """Return the chain of a tag of a ladder program after a scan; empty if nothing is known of it."""
    rows = monitor.subject.timeline.between(max(0, scan - BACK), scan)
    words = monitor.subject.words
    slots = tuple(
        SlotInfo(each.number, each.module, words=words[each.number])
        for each in sorted(monitor.subject.spec.slot, key=lambda each: each.number)
    )
    events = tuple(map(_event, monitor.states.up_to(scan, BACK)))
    recording = Recording(slots, PackedScans.of(len(slots), [columns_of(rows)]), events)

    def chains(*, deep: bool, outside: Callable[..., CauseLink | None]) -> Chains:
        return Chains(shadow.engine.lowered, Causes(shadow), deep, outside)

    if not len(rows):
        return []
    found = RackChain(recording, chains).of_tag(tag, len(rows) - 1)
    return [] if found is None else links_of(found)


def _event(event: Mapping[str, Any]) -> TraceEvent:
    fields = {key: event[key] for key in ("slot", "kind", "name", "text")}
    return TraceEvent(event["scan"], event["t"], _TOPICS.get(event["kind"], f"/{event['kind']}"), fields)


def links_of(chain: CauseLink) -> list[Json]:
    """Return the links of a chain for a page: scan, time, text, the rung or line, causes by number."""
    links = list(chain.walk())[:MOST_LINKS]
    numbers = {link: number for number, link in enumerate(links)}
    return [
        {
            "scan": link.scan,
            "t": link.now_ns,
            "kind": link.kind,
            "text": said(link),
            "at": _at(link),
            "causes": [
                [numbers[each] for each in group if each in numbers]
                for group in link.causes
                if any(each in numbers for each in group)
            ],
        }
        for link in links
    ]


def _at(link: CauseLink) -> str | None:
    """Return the rung or line as a page names it: `Main.3`, `line.py.12`."""
    site = link.site
    if site is None:
        return None
    return (
        f"{site.routine}.{site.rung}" if site.routine else f"{site.file}.{site.line}" if site.file else None
    )
