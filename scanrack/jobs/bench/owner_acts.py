"""Finds an owner's actions that would have set a tag to a different value in a recorded run.

The rack runs again up to the scan, with the recorded actions of the session. Then each action is tried on a
copy, see `why.acts`.
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
    """Yield up to `MOST_ANSWERS` sets of actions after a scan of a recording; see `every_act`.

    Args:
        folder: folder into which to unpack the files of the trace.
        orders: the recorded actions of the session.

    Raises:
        ValueError: the name is unknown, or the program was edited before that scan.
        UntrustedError: untrusted Python of the trace would run.
    """
    edits = [event.scan for event in trace.events() if is_edit(event) and event.scan <= scan]
    if edits:
        raise ValueError(f"the program was edited in scan {edits[0]:,}: choose an earlier scan")
    job = job_of(trace, folder, trust=trust)
    ladder = isinstance(job.logic, LadderLogic)
    load = None if ladder else Load(job.program, lambda: job_of(trace, folder, trust=trust).logic)
    bench = bench_of(job, None, watched=True, load=load)
    bench.check(tag)
    operator = OperatorActions(bench.cpu, bench.cpu.rack, settable_tags(bench.logic))
    for action_scan, action in sorted(orders, key=lambda applied: applied.scan):
        if action_scan <= scan:
            bench.scan(action_scan - bench.scans)
            operator.act(action, action_scan * bench.cpu.period_ns, action_scan)
    bench.scan(scan + 1 - bench.scans)
    yield from islice(every_act(bench, bench.chain(tag), tag, value), MOST_ANSWERS)
