"""The process that creates a page to share, which takes seconds."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Any

from .command import ShareOptions, shared


def answer(trace: str, scan: int, trust: bool, rack: str) -> dict[str, Any]:
    """Return a trace's page in base64; a scan not yet in the trace is replaced by the latest scan.

    Raises:
        ValueError: the trace can't be used or read, or the page would be too large.
    """
    path = Path(trace)
    try:
        data, page = shared(path, ShareOptions(scan, latest=True, trust=trust, rack=rack))
    except OSError as error:
        raise ValueError(str(error)) from error
    return {"name": f"{path.stem}.html", "scan": data["scan"], "page": base64.b64encode(page).decode()}
