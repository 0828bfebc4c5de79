"""The file of a ladder program: what identifies it, and how edited rungs are written into it."""

from __future__ import annotations

from hashlib import sha256
from pathlib import Path
from shutil import copyfile

from ...jobs.load.program import L5X_SUFFIXES
from ...ladder.files.rewriting import rewritten
from ...ladder.lowering.edited import NewTag, RungEdit


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
    """Write a program's file; the old one is kept beside it under the returned name."""
    number, kept = 2, file.with_name(f"{file.name}.bak")
    while kept.exists():
        number, kept = number + 1, file.with_name(f"{file.name}.bak{number}")
    copyfile(file, kept)
    new = file.with_name(f"{file.name}.new")
    new.write_bytes(data)
    new.replace(file)
    return kept


def digest(data: bytes) -> str:
    """Return what identifies the contents of a program's file."""
    return sha256(data).hexdigest()
