"""The process that finds the cause of a Python program's value by rerunning the program.

The trace may still be growing, so the question includes its latest scans.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from scanrack.jobs.bench.moment import Question, ScanChoice
from scanrack.jobs.bench.of_trace import why_of_trace
from scanrack.traces.read.columns import Columns
from scanrack.traces.read.reader import open_trace

from .chain_answer import links_of


def answer(path: str, tag: str, more: Columns) -> dict[str, Any]:
    """Return the cause of a tag's value in a scan of a trace.

    Args:
        more: the latest scans, which may not be in the trace yet; the question is about the last one.

    Raises:
        ValueError: the trace can't be used, or a name is unknown.
    """
    with open_trace(path) as trace, tempfile.TemporaryDirectory() as folder:
        choice = ScanChoice(at=str(more.scan[-1]))
        result = why_of_trace(trace, Path(folder), Question(tag, choice), trust=True, more=more)
    lines = [{"file": Path(line.file).name, "line": line.number} for line in result.lines if line.number]
    chain = [] if result.chain is None else links_of(result.chain)
    return {
        "text": "\n".join([result.text, *result.notes]),
        "scan": result.scan,
        "lines": lines,
        "chain": chain,
    }
