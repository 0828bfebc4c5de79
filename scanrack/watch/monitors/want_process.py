"""Finds what it would take to get a value, in its own process: reruns the session and tries copies of it.

The latest orders come with the question, since they may not be recorded yet.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from scanrack.jobs.bench.owner_acts import acts_in_trace
from scanrack.jobs.record.order_repeater import RecordedOrder, orders_of
from scanrack.jobs.why.acts import Acts
from scanrack.runtime.live.actions import RECORDED, action_of, parsed
from scanrack.runtime.loop.faults import CpuFault
from scanrack.traces.read.reader import open_trace


def answer(
    path: str, tag: str, value: object, scan: int, latest: Sequence[tuple[int, str]]
) -> dict[str, Any]:
    """Return the answers for a scan of a recording.

    Args:
        value: the value that the tag should get.
        latest: orders of the session up to the scan, each with the scan before which it acts and its text.

    Raises:
        ValueError: the trace can't be used, a name is unknown, or the controller faults before the scan.
    """
    try:
        with open_trace(path) as trace, tempfile.TemporaryDirectory() as folder:
            orders = orders_of(trace.events())
            recorded_orders = [
                RecordedOrder(order_scan, action_of(parsed(text), RECORDED)) for order_scan, text in latest
            ]
            orders += [order for order in recorded_orders if order not in orders]
            answers = list(acts_in_trace(trace, Path(folder), tag, value, scan, orders, trust=True))
    except CpuFault as error:
        raise ValueError(f"the controller has faulted in {error}: ask before that scan") from error
    return {"scan": scan, "answers": [_described(row) for row in answers]}


def _described(found: Acts) -> dict[str, Any]:
    acts = None if found.acts is None else [act.text for act in found.acts]
    return {
        "text": str(found),
        "acts": acts,
        "after_ns": found.after_ns,
        "orders": None if acts is None else found.orders(),
    }
