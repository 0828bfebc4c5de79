"""Locks the folder of a campaign, so that only one campaign at a time writes to it."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from scanrack.traces.files.guard import NOTHING, FileKind, OwnedError, Used
from scanrack.traces.files.locking import could_lock
from scanrack.traces.files.newfile import naming, new_file

OF_A_CAMPAIGN = FileKind("a file of a campaign", lambda _content: True)
"""Any file in a campaign's folder."""

STATE_NAME = "state.json"
"""Name of the campaign's state file."""

NAME = ".lock"
"""Name of the lock file. It remains, unlocked, after the campaign."""


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Create a folder if it is missing, and lock it within the context.

    The operating system releases the lock when the process dies.

    Raises:
        OwnedError: the folder has files but is not the folder of a campaign.
        ValueError: another process has locked the folder.
        OSError: the folder or its file can't be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    if any(folder.iterdir()) and not any((folder / name).exists() for name in (NAME, STATE_NAME)):
        raise OwnedError(f"{folder} has files of another kind: use another folder with --out")
    with (folder / NAME).open("a+b", buffering=0) as file:
        if not could_lock(file.fileno()):
            file.seek(0)
            process = file.read().decode("ascii", "replace")
            owner = f" (process {process})" if process.isdecimal() else ""
            raise ValueError(
                f"{folder}: another campaign{owner} uses this folder: wait until it ends, or use another "
                "folder with --out"
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
