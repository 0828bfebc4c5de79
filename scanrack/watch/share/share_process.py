"""Makes a page to share in its own process: it takes seconds, and scans and frames can't wait."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Any

from .command import ShareOptions, shared


def answer(trace: str, scan: int, trust: bool, rack: str) -> dict[str, Any]:
    """Return the page of a recording in base64; a scan not yet written becomes the latest.

    Raises:
        ValueError: the recording can't be used or read, or the page would be too large.
    """
    path = Path(trace)
    try:
        data, page = shared(path, ShareOptions(scan, latest=True, trust=trust, rack=rack))
    except OSError as error:
        raise ValueError(str(error)) from error
    return {"name": f"{path.stem}.html", "scan": data["scan"], "page": base64.b64encode(page).decode()}
