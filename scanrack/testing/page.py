"""The page with the recording of a failed test."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from scanrack.io_images.text_limits import shortened

MOST_SCANS = 20_000
"""A recording with more scans gets no page by default, since the page would take more than 3 s."""

MOST_RUN_S = 2.0
"""A run with more processor time (s) gets no page by default, since creating the page takes slightly longer
than the run."""

MOST_EXPLAINED_SCANS = 8_000
"""For a recording with more scans, the page does not explain tags; the report still does."""

SHOWN = 4_000
"""Maximum number of scans in the page, up to the failure."""


class FailedTest(NamedTuple):
    """A failed test."""

    name: str  # as pytest shows it
    message: str
    passed: Path | None = None  # the trace of its last run that passed


def page_line(trace: Path, shown: str, scan: int, tags: Sequence[str], run_s: float, test: FailedTest) -> str:
    """Write a recording's page next to it; return the line for the report.

    Args:
        shown: name of the trace in the report.
        scan: the scan of the failure.
        tags: the tags whose values the page explains.
        run_s: processor time since the bench was opened, s.
        test: the test; the page shows its failure first.
    """
    if scan >= MOST_SCANS or run_s > MOST_RUN_S:
        return f"scanrack share {shlex.quote(shown)}   # the page takes some seconds"
    from scanrack.watch.share.command import ShareOptions, share  # imported late: half a second
    from scanrack.watch.share.failure import Failure

    page = trace.with_suffix(".html")
    explained = tags if scan < MOST_EXPLAINED_SCANS else ()
    failure = Failure(test.name, test.message, next(iter(explained), None), test.passed)
    options = ShareOptions(
        scan, before=SHOWN, most=SHOWN, latest_answers=0, trust=True, tags=explained, failure=failure
    )
    try:
        share(trace, page, options)
    except Exception as error:  # a report must not fail itself
        return f"no page: {shortened(str(error))}"
    return page.resolve().as_uri()
