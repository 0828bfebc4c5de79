"""The page of a failed test's recording."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from scanrack.io_images.text_limits import shortened

MOST_SCANS = 20_000
"""A longer recording gets no page unasked: it would take more than three seconds."""

MOST_RUN_S = 2.0
"""A run of more processor time gets none either: its page takes a bit longer than the run did."""

WITH_ANSWERS = 8_000
"""A longer one has no answers of why in its page: the report has them."""

SHOWN = 4_000
"""Scans in the page, up to the failure."""


class FailedTest(NamedTuple):
    """A test that has failed."""

    name: str  # as pytest shows it
    message: str
    passed: Path | None = None  # the trace of its last run that passed


def page_line(trace: Path, shown: str, scan: int, tags: Sequence[str], run_s: float, test: FailedTest) -> str:
    """Write the page of a recording beside it; return the line of the report.

    Args:
        shown: what the report calls the trace.
        scan: the scan of the failure.
        tags: whose why the page answers.
        run_s: processor time since the bench was opened, s.
        test: the page opens on what it says.
    """
    if scan >= MOST_SCANS or run_s > MOST_RUN_S:
        return f"scanrack share {shlex.quote(shown)}   # the page takes some seconds"
    from scanrack.watch.share.command import ShareOptions, share  # imported late: half a second
    from scanrack.watch.share.failure import Failure

    page = trace.with_suffix(".html")
    answered = tags if scan < WITH_ANSWERS else ()
    failure = Failure(test.name, test.message, next(iter(answered), None), test.passed)
    wish = ShareOptions(scan, before=SHOWN, most=SHOWN, others=0, trust=True, tags=answered, failure=failure)
    try:
        share(trace, page, wish)
    except Exception as error:  # a report is no place for a second failure
        return f"no page: {shortened(str(error))}"
    return page.resolve().as_uri()
