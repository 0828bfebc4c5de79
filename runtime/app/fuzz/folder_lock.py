"""An advisory lock on a folder: one campaign at a time."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ....traces.output import could_lock

NAME = ".lock"
"""The file that is locked; it stays when the campaign is over, and means nothing then."""


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold a folder for as long as the context lasts; the system gives it up when the process dies.

    Raises:
        ValueError: another process holds it.
        OSError: the file can't be written.
    """
    with (folder / NAME).open("a+", encoding="utf-8") as file:
        if not could_lock(file.fileno()):
            file.seek(0)
            raise ValueError(
                f"{folder}: another campaign{_of(file.read())} is at work there: wait for its end, or give "
                "--out another folder"
            )
        file.truncate(0)
        file.write(str(os.getpid()))
        file.flush()
        yield


def _of(owner: str) -> str:
    return f" (process {owner})" if owner.isdecimal() else ""
