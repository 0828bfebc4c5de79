"""The process that finds actions that lead to a value: it reruns the session and tries them on copies.

The question includes the latest actions, since they may not be in the trace yet.
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
    """Return the actions after a scan of a trace that lead to a value of a tag.

    Args:
        value: the intended value of the tag.
        latest: actions up to the scan, each with the scan before which it takes effect, and its text.

    Raises:
        ValueError: the trace can't be used, a name is unknown, or the controller faults before the scan.
    """
    try:
        with open_trace(path) as trace, tempfile.TemporaryDirectory() as folder:
            recorded = orders_of(trace.events())
            known = [
                RecordedOrder(before_scan, action_of(parsed(text), RECORDED)) for before_scan, text in latest
            ]
            recorded += [action for action in known if action not in recorded]
            results = list(acts_in_trace(trace, Path(folder), tag, value, scan, recorded, trust=True))
    except CpuFault as error:
        raise ValueError(f"the controller has faulted in {error}: ask before that scan") from error
    return {"scan": scan, "answers": list(map(_described, results))}


def _described(acts: Acts) -> dict[str, Any]:
    """Return a result for a page: its sentence, its acts, and the actions that carry them out."""
    texts = None if acts.acts is None else [act.text for act in acts.acts]
    return {
        "text": str(acts),
        "acts": texts,
        "after_ns": acts.after_ns,
        "orders": None if texts is None else acts.orders(),
    }
