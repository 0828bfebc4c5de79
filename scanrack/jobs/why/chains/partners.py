"""The chain of causes of a consumed tag, in the rack that produces it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from scanrack.ladder import LadderLogic
from scanrack.ladder.debug import CauseLink, Debugger
from scanrack.ladder.model.stubs import Partner
from scanrack.runtime.loop.faults import CpuFault
from scanrack.traces.replay import PackedTrace

from ...load.building import build_cpu, build_rack
from ...load.linked_racks import FromRack
from ...load.loading import LoadedRack, load_job
from ..journal import Journal

MOST_SCANS = 500_000
"""Maximum number of scans of the other rack, which is rerun from power-up."""

Explain = Callable[[PackedTrace, LoadedRack, Debugger, str], CauseLink | None]
"""Returns the chain of a rack's tag after the last scan of its recording."""


def chain_of_partner(
    program: LadderLogic, path: str, rpi_ns: int, now_ns: int, explain: Explain
) -> CauseLink | None:
    """Return the chain of a consumed tag in the rack that produces it; each link names that rack.

    Args:
        path: the consumed tag, or a member of it.
        rpi_ns: the requested packet interval of the tag, ns.
        now_ns: time of the scan that received the value, ns.

    Returns:
        None if no other rack produces the tag, or if that rack has run for more than `MOST_SCANS`.
    """
    consumed, _, member = path.partition(".")
    partner = program.stubs.get(consumed.upper())
    source = partner.source if isinstance(partner, Partner) else None
    if not isinstance(source, FromRack) or not source.tag:
        return None
    job = load_job(str(source.rack.path))
    until_ns = now_ns // rpi_ns * rpi_ns
    if not isinstance(job.logic, LadderLogic) or until_ns // job.spec.scan_ns > MOST_SCANS:
        return None
    debugger = Debugger(job.logic)
    recording = _recorded(job, debugger, until_ns)
    if recording is None:
        return None
    tag = f"{source.tag}.{member}" if member else source.tag
    link = explain(recording, job, debugger, tag)
    return None if link is None else _with_rack_name(link, source.rack.path.name)


def _recorded(job: LoadedRack, debugger: Debugger, until_ns: int) -> PackedTrace | None:
    """Run and record the scans of a rack that begin before a time; None if there are none."""
    rack = build_rack(job.spec)
    journal = Journal(rack)
    cpu = build_cpu(job.spec, debugger, rack, listeners=[journal])
    with cpu:
        try:
            while cpu.now_ns < until_ns:
                cpu.run(1)
        except CpuFault:
            pass  # the sample is from the previous scan
    return journal.recording() if cpu.scan else None


def _with_rack_name(link: CauseLink, rack: str) -> CauseLink:
    """Return a chain with the name of its rack in each link."""
    named: dict[CauseLink, CauseLink] = {}
    stack = [link]  # a chain may be longer than Python's recursion limit
    while stack:
        current = stack[-1]
        missing = [cause for group in current.causes for cause in group if cause not in named]
        if missing:
            stack += missing
            continue
        stack.pop()
        causes = tuple(tuple(named[cause] for cause in group) for group in current.causes)
        named.setdefault(current, replace(current, name=f"{rack}: {current.name}", causes=causes))
    return named[link]
