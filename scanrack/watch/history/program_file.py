"""The file of a ladder program: what identifies it, and how edited rungs are written into it."""

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
    """Return the file of a program with edited rungs; ValueError if it has no such rung."""
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
    """Return an edit of a program's file; the addresses in an .SLC may be those of RSLogix 500."""
    routine, number, texts = edit
    if Path(name).suffix in SLC_SUFFIXES:
        from scanrack.rockwell.slc.rewriting import program_text

        texts = tuple(program_text(each, specs) for each in texts)
    return RungEdit(routine, number, texts)


def declares_tags(program: Path) -> bool:
    """Whether a program's file can declare a new tag; an .SLC has data files, made in RSLogix 500."""
    return program.suffix not in SLC_SUFFIXES


def why_not(program: Path) -> str:
    """Return why the rungs of a program's file are not edited in their picture; "" if they are."""
    if program.suffix in (SUFFIX, *L5X_SUFFIXES, *SLC_SUFFIXES):
        return ""
    instead = _INSTEAD.get(program.suffix, "")
    return f"the rungs of a {program.suffix} file are not edited in their picture{instead}"


_INSTEAD = {
    ".py": ", since Python makes them: edit that",
    ".steps": ", since steps make them: edit those",
}
"""What to do instead, by suffix."""


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
