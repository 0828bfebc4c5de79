"""The file of a ladder program: its digest, and changes to its rungs."""

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

PROGRAM = FileKind("a program", lambda _content: True)  # callers compare the contents themselves


Specs = Mapping[str, Spec]


def rewrite(name: str, data: bytes, edits: list[RungEdit], tags: list[NewTag], specs: Specs) -> Rewritten:
    """Return a program's file with edited rungs; raise ValueError if the file lacks one of the rungs."""
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
    """Return an edit of a program's file. Rungs in an .SLC file may use RSLogix 500 addresses."""
    routine, number, texts = edit
    if Path(name).suffix in SLC_SUFFIXES:
        from scanrack.rockwell.slc.rewriting import program_text

        texts = tuple(program_text(text, specs) for text in texts)
    return RungEdit(routine, number, texts)


def declares_tags(program: Path) -> bool:
    """Return whether a program's file can declare new tags. The data files of an .SLC are fixed."""
    return program.suffix not in SLC_SUFFIXES


def why_not_editable(program: Path) -> str:
    """Return why the drawn rungs of a program's file can't be edited; "" if they can."""
    if program.suffix in (SUFFIX, *L5X_SUFFIXES, *SLC_SUFFIXES):
        return ""
    return f"the drawn rungs of a {program.suffix} file can't be edited{_REMEDIES.get(program.suffix, '')}"


_REMEDIES = {".py": "; edit the Python code", ".steps": "; edit the steps"}


def save(file: Path, data: bytes) -> Path:
    """Write a program's file; return the path of the backup of the old file.

    If the file is a link, its target is written.

    Raises:
        OSError: the file can't be copied or written, and is unchanged.
    """
    backup = _backed_up(file.resolve())
    write(file, data)
    return backup


def write(file: Path, data: bytes) -> None:
    """Replace a program's file; raise OSError if it can't be written and is unchanged."""
    with new_file(file.resolve(), PROGRAM, "wb") as output:
        output.write(data)


def _backed_up(file: Path) -> Path:
    """Copy a file to the first unused name of NAME.bak, NAME.bak2 and so on; return the copy's path."""
    for number in count(1):
        backup = file.with_name(f"{file.name}.bak{number if number > 1 else ''}")
        try:
            copy = open(backup, "xb", opener=_private)  # noqa: SIM115 - the next name follows if this one exists
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
