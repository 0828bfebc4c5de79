"""An advisory lock on a folder: one campaign at a time."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ....traces.output import could_lock

NAME = ".lock"
"""The file that is locked; it stays after the campaign, without meaning."""


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold a folder within the context; the system releases it when the process dies.

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
