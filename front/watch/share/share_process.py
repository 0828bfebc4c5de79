"""A page to share, made in a process of its own: it takes seconds, which scans and frames have not.

`main` prints one line of JSON: `{"name", "scan", "page"}`, the page in base64, or `{"refused"}`.
"""

from __future__ import annotations

import base64
import json
import os
import sys
from pathlib import Path
from typing import Any

from ...jobs.trust.trust import UntrustedError
from ...traces.format.records import TraceError
from .command import ShareOptions, shared

MODESTY = 10
"""Its lower priority than the monitor's, see nice(2)."""


def answer(path: Path, scan: int, *, trust: bool, rack: str = "") -> dict[str, Any]:
    """Return the page of a recording, or a refusal; of one that grows, its latest written scan if need be."""
    try:
        data, page = shared(path, ShareOptions(scan, latest=True), trust=trust, rack=rack)
    except (OSError, ValueError, TraceError, UntrustedError) as error:
        return {"refused": str(error)}
    return {"name": f"{path.stem}.html", "scan": data["scan"], "page": base64.b64encode(page).decode()}


def main(path: str, scan: str, trust: str, rack: str = "") -> None:
    """Make a page: the main function of the process, see `question_process`."""
    if hasattr(os, "nice"):
        os.nice(MODESTY)
    sys.stdout.write(json.dumps(answer(Path(path), int(scan), trust=bool(trust), rack=rack)))
