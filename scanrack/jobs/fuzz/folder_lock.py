"""The folder of a campaign: only its files are in there, and one campaign at a time uses it."""

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
"""The file of the campaign's state."""

NAME = ".lock"
"""The locked file; it stays after the campaign and has no meaning then."""


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Lock a folder within the context, and make it if it is missing.

    The system releases the lock when the process dies.

    Raises:
        OwnedError: it has files in it that are not of a campaign.
        ValueError: another process holds it.
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
        OwnedError: it is one of `used`.
        OSError: it can't be written.
    """
    with new_file(path, OF_A_CAMPAIGN, used=used) as file:
        file.write(text)
    return path


def _of(owner: str) -> str:
    return f" (process {owner})" if owner.isdecimal() else ""
