"""Locks the folder of a campaign: it has only the campaign's files, and one campaign at a time uses it."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from scanrack.traces.files.guard import NOTHING, FileKind, OwnedError, Used
from scanrack.traces.files.locking import could_lock
from scanrack.traces.files.newfile import naming, new_file

OF_A_CAMPAIGN = FileKind("a file of a campaign", lambda _content: True)
"""Any file in a folder that `locked` has accepted."""

STATE_NAME = "state.json"
"""Name of the campaign's state file."""

NAME = ".lock"
"""Name of the lock file; it stays after the campaign and then has no meaning."""


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Create a folder if it is missing, and lock it within the context.

    The operating system releases the lock when the process dies.

    Raises:
        OwnedError: the folder has files that are not of a campaign.
        ValueError: another process holds the lock.
        OSError: the folder or its file can't be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    if any(folder.iterdir()) and not any((folder / name).exists() for name in (NAME, STATE_NAME)):
        raise OwnedError(f"{folder} has files in it that are not of a campaign: give --out another folder")
    with (folder / NAME).open("a+b", buffering=0) as file:
        if not could_lock(file.fileno()):
            file.seek(0)
            raise ValueError(
                f"{folder}: another campaign{_of(file.read().decode('ascii', 'replace'))} is at work there: "
                "wait for its end, or give --out another folder"
            )
        with naming(folder / NAME):  # a full disk
            file.truncate(0)
            os.write(file.fileno(), str(os.getpid()).encode())
        yield


def write_text(path: Path, text: str, used: Used = NOTHING) -> Path:
    """Write a file of a campaign; return its path.

    Args:
        used: files that must not be replaced.

    Raises:
        OwnedError: the file is one of `used`.
        OSError: the file can't be written.
    """
    with new_file(path, OF_A_CAMPAIGN, used=used) as file:
        file.write(text)
    return path


def _of(owner: str) -> str:
    return f" (process {owner})" if owner.isdecimal() else ""
