"""The file of a ladder program: what identifies it, and how edited rungs are written into it."""

from __future__ import annotations

import os
import shutil
from hashlib import sha256
from itertools import count
from pathlib import Path

from ...jobs.load.program import L5X_SUFFIXES
from ...ladder.files.rewriting import rewritten
from ...ladder.lowering.edited import NewTag, RungEdit
from ...traces.files.guard import FileKind
from ...traces.files.locking import NO_LINK
from ...traces.files.newfile import new_file, sync_folder

PROGRAM = FileKind("a program", lambda _content: True)  # the caller compares all of it


def rewrite(name: str, data: bytes, edits: list[RungEdit], tags: list[NewTag]) -> bytes:
    """Return the file of a program with edited rungs; ValueError if it has no such rung."""
    if Path(name).suffix.lower() in L5X_SUFFIXES:
        from ...rockwell.l5x.rewriting import rewritten_l5x

        return rewritten_l5x(data, edits, tags)
    return rewritten(data.decode(), edits, tags).encode()


def why_not(program: Path) -> str:
    """Return why the rungs of a program's file are not edited; "" if they are."""
    if program.suffix.lower() in (".rung", *L5X_SUFFIXES):
        return ""
    return f"the rungs of a {program.suffix} file are not edited in their picture"


def save(file: Path, data: bytes) -> Path:
    """Write a program's file; the old one is kept beside it under the returned name.

    A link stays, and its target is written.

    Raises:
        OSError: the file can't be copied or written; it is unchanged.
    """
    kept = _kept(file.resolve())
    write(file, data)
    return kept


def write(file: Path, data: bytes) -> None:
    """Write a program's file in place of the old one; OSError if it can't be written, and is unchanged."""
    with new_file(file.resolve(), PROGRAM, "wb") as out:
        out.write(data)


def _kept(file: Path) -> Path:
    """Copy a file under the first free of the names NAME.bak, NAME.bak2 and so on; return its path."""
    for number in count(1):
        kept = file.with_name(f"{file.name}.bak{number if number > 1 else ''}")
        try:
            copy = open(kept, "xb", opener=_private)  # noqa: SIM115 - a name that is taken is no error
        except FileExistsError:
            continue
        with copy, file.open("rb") as old:
            shutil.copyfileobj(old, copy)
            copy.flush()
            os.fsync(copy.fileno())
        shutil.copymode(file, kept)
        sync_folder(kept.parent)
        return kept
    raise AssertionError


def _private(path: str, flags: int) -> int:
    return os.open(path, flags | NO_LINK, 0o600)


def digest(data: bytes) -> str:
    """Return what identifies the contents of a program's file."""
    return sha256(data).hexdigest()
