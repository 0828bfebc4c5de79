"""Handles the file of a ladder program: its digest, and writing edited rungs into it."""

from __future__ import annotations

import os
import shutil
from collections.abc import Mapping
from hashlib import sha256
from itertools import count
from pathlib import Path

from scanrack.jobs.load.program import L5X_SUFFIXES, SLC_SUFFIXES
from scanrack.ladder.files.rewriting import rewritten
from scanrack.ladder.files.suffixes import SUFFIX
from scanrack.ladder.lowering.edited import NewTag, Rewritten, RungEdit, changes_of
from scanrack.ladder.model.spec import Spec
from scanrack.traces.files.guard import FileKind
from scanrack.traces.files.locking import NO_LINK
from scanrack.traces.files.newfile import new_file, sync_folder

PROGRAM = FileKind("a program", lambda _content: True)  # the caller compares all of it


Specs = Mapping[str, Spec]


def rewrite(name: str, data: bytes, edits: list[RungEdit], tags: list[NewTag], specs: Specs) -> Rewritten:
    """Return the file of a program with edited rungs; raise ValueError if it lacks one of the rungs."""
    suffix = Path(name).suffix
    if suffix in L5X_SUFFIXES:
        from scanrack.rockwell.l5x.rewriting import rewritten_l5x

        return rewritten_l5x(data, edits, tags, name)
    if suffix in SLC_SUFFIXES:
        from scanrack.rockwell.slc.rewriting import rewritten_slc

        return rewritten_slc(data, edits, tags, specs)
    text = rewritten(data.decode(), edits, tags)
    return Rewritten(text.encode(), tuple(changes_of(edits, tags)))


def read_edit(name: str, edit: tuple[str, int, tuple[str, ...]], specs: Specs) -> RungEdit:
    """Return an edit of a program's file; in an .SLC, it may use addresses of RSLogix 500."""
    routine, number, texts = edit
    if Path(name).suffix in SLC_SUFFIXES:
        from scanrack.rockwell.slc.rewriting import program_text

        texts = tuple(program_text(text, specs) for text in texts)
    return RungEdit(routine, number, texts)


def declares_tags(program: Path) -> bool:
    """Return whether a program's file can declare new tags; an .SLC has data files from RSLogix 500."""
    return program.suffix not in SLC_SUFFIXES


def why_not(program: Path) -> str:
    """Return why drawn rungs of a program's file can't be edited; "" if they can."""
    if program.suffix in (SUFFIX, *L5X_SUFFIXES, *SLC_SUFFIXES):
        return ""
    instead = _INSTEAD.get(program.suffix, "")
    return f"the rungs of a {program.suffix} file are not edited in their picture{instead}"


_INSTEAD = {
    ".py": ", since Python makes them: edit that",
    ".steps": ", since steps make them: edit those",
}
"""Text about what to do instead, by suffix."""


def save(file: Path, data: bytes) -> Path:
    """Write a program's file; keep the old file beside it and return its new path.

    If the file is a link, its target is written and the link stays.

    Raises:
        OSError: the file can't be copied or written; it is unchanged.
    """
    backup = _kept(file.resolve())
    write(file, data)
    return backup


def write(file: Path, data: bytes) -> None:
    """Replace a program's file; raise OSError if it can't be written and is unchanged."""
    with new_file(file.resolve(), PROGRAM, "wb") as output:
        output.write(data)


def _kept(file: Path) -> Path:
    """Copy a file to the first free name of NAME.bak, NAME.bak2 and so on; return the copy's path."""
    for number in count(1):
        backup = file.with_name(f"{file.name}.bak{number if number > 1 else ''}")
        try:
            copy = open(backup, "xb", opener=_private)  # noqa: SIM115 - a name that is taken is no error
        except FileExistsError:
            continue
        with copy, file.open("rb") as source:
            shutil.copyfileobj(source, copy)
            copy.flush()
            os.fsync(copy.fileno())
        shutil.copymode(file, backup)
        sync_folder(backup.parent)
        return backup
    raise AssertionError


def _private(path: str, flags: int) -> int:
    return os.open(path, flags | NO_LINK, 0o600)


def digest(data: bytes) -> str:
    """Return a digest that identifies the contents of a program's file."""
    return sha256(data).hexdigest()
