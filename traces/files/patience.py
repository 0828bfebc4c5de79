"""Renames and replaces files; waits while another program has a file open.

Windows can't rename or replace an open file. Virus scanners and indexers briefly open each new file.
On other systems, the same error means that a permission is missing.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from time import sleep

TRIES = 10
BETWEEN_S = 0.1
"""Pause between attempts, s."""


def patiently(change: Callable[[Path, Path], object], source: Path, target: Path) -> None:
    """Call `change(source, target)`; repeat it for about a second while another program has the file open.

    Raises:
        OSError: `change` raised it; a PermissionError only after `TRIES` attempts.
    """
    for _ in range(TRIES - 1):
        try:
            change(source, target)
        except PermissionError:
            sleep(BETWEEN_S)
        else:
            return
    change(source, target)
