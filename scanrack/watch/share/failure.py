"""A failed test for a page, with its message and the first difference from the last passed run."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from scanrack.io_images.memory_layout import MemoryLayout

from ..history.catalog import Json
from ..monitors.trace_monitor import TraceMonitor
from .changes import ChangeLists
from .collecting import SharedStretch, gathered

COMPARED = ("words", "power", "tags", "mode", "forced")
"""Parts of a frame that are compared with the run that passed."""

MOST_NAMES = 8
"""Maximum numbers of tags, rungs and images in the difference."""


@dataclass(frozen=True, slots=True)
class Failure:
    """A failed test.

    Attributes:
        test: name of the test, as in pytest.
        message: message of the failure.
        tag: the tag whose causes the page opens; None = no tag.
        passed: trace of the last run that passed; None without one.
    """

    test: str
    message: str
    tag: str | None = None
    passed: Path | None = None

    def described(self, stretch: SharedStretch, passed: TraceMonitor | None, lists: ChangeLists) -> Json:
        """Return the page's data about the failure.

        Args:
            stretch: the scans of the page.
            passed: monitor of the run that passed, or None.
            lists: values of the run that failed.
        """
        row = {"test": self.test, "message": self.message, "tag": self.tag, "scan": stretch.scan}
        extent = None if passed is None else passed.subject.timeline.extent
        if passed is None or extent is None or extent[1] < stretch.first:
            return row
        last = min(stretch.last, extent[1])
        passed_lists = gathered(passed, SharedStretch(stretch.first, last, last)).lists
        difference = lists.first_difference(passed_lists, COMPARED, range(stretch.first, last + 1))
        if difference is None:
            return row | {"against": {"equal_to": last}}
        may_be_earlier = difference.scan == stretch.first > extent[0]  # the page lacks the scans before
        names = _names_by_kind(difference.keys, passed.subject.spec.layout)
        return row | {"against": {"scan": difference.scan, "before": may_be_earlier, **names}}


def _names_by_kind(keys: Iterable[str], layout: MemoryLayout) -> Json:
    """Return the names of lists by kind: tags, rungs, and images or states of the rack."""
    tags, rungs, others = [], [], []
    for key in keys:
        part, *fields = key.split("\n")
        if part == "tags":
            tags.append(fields[-1])
        elif part == "power":
            rungs.append(fields[-1])
        elif part == "words":
            inputs = layout.places[int(fields[0])].columns("I")
            image = "inputs" if int(fields[1]) < inputs.stop - inputs.start else "outputs"
            others.append(f"slot {fields[0]} {image}")
        else:
            others.append({"mode": "mode", "forced": "forces"}[part])
    lists = {"tags": tags, "rungs": rungs, "others": others}
    return {kind: [*dict.fromkeys(names)][:MOST_NAMES] for kind, names in lists.items()}
