"""Changes names in a folder, and waits while another program has a file open.

On Windows a file that is open can't be renamed or replaced, and virus scanners and indexers open each new
file for a moment. On other systems the same error means that the folder may not be changed.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from time import sleep

TRIES = 10
BETWEEN_S = 0.1


def patiently(change: Callable[[Path, Path], object], source: Path, target: Path) -> None:
    """Change the name of a file; wait up to a second while another program has it open.

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
