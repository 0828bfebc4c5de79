"""The cause of a Python program's value, in a process of its own, since the program runs again.

`main` prints one line of JSON: `{"text", "scan", "lines"}` or `{"refused"}`. The recording may still
grow: its latest scans come on the standard input, as pickled columns.
"""

from __future__ import annotations

import json
import os
import pickle
import sys
import tempfile
from pathlib import Path
from typing import Any

from ...jobs.bench import NotReachedError
from ...jobs.bench.moment import ScanChoice
from ...jobs.bench.of_trace import why_of_trace
from ...jobs.trust.trust import UntrustedError
from ...traces.format.records import TraceError
from ...traces.read.columns import Columns
from ...traces.read.reader import open_trace
from .chain_answer import links_of

MODESTY = 10
"""Its lower priority than the monitor's, see nice(2)."""


def answer(path: str, what: str, scan: str, more: Columns) -> dict[str, Any]:
    """Return the answer to a question about a scan of a recording, or its refusal.

    Args:
        more: the latest scans, which may not be written yet.
    """
    try:
        with open_trace(path) as trace, tempfile.TemporaryDirectory() as folder:
            asked = why_of_trace(trace, Path(folder), what, ScanChoice(at=scan), trust=True, more=more)
    except (ValueError, TraceError, NotReachedError, UntrustedError) as error:
        return {"refused": str(error)}
    lines = [{"file": Path(each.file).name, "line": each.number} for each in asked.lines if each.number]
    chain = [] if asked.chain is None else links_of(asked.chain)
    return {"text": "\n".join([asked.text, *asked.notes]), "scan": asked.scan, "lines": lines, "chain": chain}


def main(path: str, what: str, scan: str) -> None:
    """Answer a question: the main function of the process, see `question_process`."""
    if hasattr(os, "nice"):
        os.nice(MODESTY)  # scans and frames have priority
    sys.stdout.write(json.dumps(answer(path, what, scan, pickle.load(sys.stdin.buffer))))
