"""Finds what an owner could have done in a recorded run to give a tag another value, by trying it on copies.

The rack runs again up to the scan in question, with the orders of the session, see `why.acts`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import islice
from pathlib import Path

from scanrack.ladder import LadderLogic
from scanrack.runtime.live.operator_actions import AppliedAction, OperatorActions
from scanrack.traces.read.reader import Trace

from ..record.edits_and_forces import is_edit
from ..record.settable_tags import settable_tags
from ..trust.attachments import job_of
from ..why.acts import Acts, every_act
from ..why.traced_run import Load
from .opening import bench_of

MOST_ANSWERS = 6


def acts_in_trace(
    trace: Trace,
    folder: Path,
    tag: str,
    value: object,
    scan: int,
    orders: Iterable[AppliedAction],
    *,
    trust: bool,
) -> Iterator[Acts]:
    """Yield up to `MOST_ANSWERS` actions of an owner after a scan of a recording; see `every_act`.

    Args:
        folder: folder into which to unpack the files of the trace.
        orders: orders of the session up to that scan.

    Raises:
        ValueError: the name is unknown, or the program was edited before that scan.
        UntrustedError: untrusted Python of the trace would run.
    """
    edits = [event.scan for event in trace.events() if is_edit(event) and event.scan <= scan]
    if edits:
        raise ValueError(f"the program was edited before scan {edits[0]:,}: ask before that scan")
    job = job_of(trace, folder, trust=trust)
    ladder = isinstance(job.logic, LadderLogic)
    load = None if ladder else Load(job.program, lambda: job_of(trace, folder, trust=trust).logic)
    bench = bench_of(job, None, watched=True, load=load)
    bench.check(tag)
    hands = OperatorActions(bench.cpu, bench.cpu.rack, settable_tags(bench.logic))
    for number, order in sorted(orders, key=lambda each: each.scan):
        if number <= scan:
            bench.scan(number - bench.scans)
            hands.act(order, number * bench.cpu.period_ns, number)
    bench.scan(scan + 1 - bench.scans)
    yield from islice(every_act(bench, bench.chain(tag), tag, value), MOST_ANSWERS)
