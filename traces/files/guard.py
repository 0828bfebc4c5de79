"""Decides which existing files an output may replace.

    missing or empty                 written
    a device or a pipe               written
    in use: read, imported, named    refused, whatever its kind
    of the kind of the output        replaced
    any other file                   refused
    being recorded                   refused

The target of a link is checked and replaced; the link is kept.
"""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Callable, Mapping
from os.path import realpath, samestat
from pathlib import Path
from types import MappingProxyType

from scanrack.io_images.dataclass import dataclass

from ..format.records import MAGIC
from .locking import is_being_recorded

Used = Mapping[Path, str]
"""Files in use, and their roles: "the program", "the trace itself"."""

NOTHING: Used = MappingProxyType({})

LOOK_BYTES = 1024
"""Number of bytes at the beginning of a file that determine its kind."""


class OwnedError(ValueError):
    """The existing file must not be replaced; the message names the file and the remedy."""


@dataclass(frozen=True, slots=True)
class FileKind:
    """A kind of file that commands write."""

    name: str
    recognizes: Callable[[bytes], bool]  # whether a file with this beginning is of the kind


def beginning(name: str, *begins: bytes) -> FileKind:
    """Return a kind of file that is recognized by its beginning, ignoring case and leading blanks."""
    starts = tuple(prefix.lower() for prefix in begins)
    return FileKind(name, lambda content: content.lstrip().lower().startswith(starts))


_EXPORT = re.compile(
    rb"<RSLogix5000Content|^\s*+(?:START\b|PROJECT\b|SLOT\s|LAD(?:DER)?\s|SOR\s)", re.MULTILINE
)
"""Beginnings of an L5X file, and of RSLogix 500 lines."""

TRACE = FileKind("an MCAP recording", lambda content: content.startswith(MAGIC))
PAGE = beginning("an HTML page", b"<!doctype html", b"<html")
PNG = beginning("a PNG picture", b"\x89PNG")
SVG = FileKind("an SVG picture", lambda content: b"<svg" in content)
SCHEMA = FileKind("a schema of rack files", lambda content: b'"title": "scanrack rack file"' in content)
EXPORT = FileKind(
    "an export of a controller", lambda content: bool(_EXPORT.search(content.replace(b"\0", b"")))
)
TAGS = beginning("a file of retained tags", b'{"format": "scanrack tags')
MEMORY = beginning("the memory of a controller", b'{"format": "scanrack memory')


def check_output(path: Path | str, kind: FileKind, used: Used = NOTHING) -> Path:
    """Return the path to write, with links resolved; raise an error if the file may not be replaced.

    Args:
        used: files that were read, imported or named.

    Raises:
        OwnedError: the file is one of `used`, of another kind, or being recorded.
        OSError: the file can't be inspected.
    """
    target = Path(realpath(path))
    status = _status(target)
    for used_file, role in used.items():
        if _is_same(target, status, used_file):
            raise OwnedError(f"{path} is {role}: choose another file to write to")
    if status is not None and stat.S_ISREG(status.st_mode):
        _check_kind(path, target, kind)
    return target


def _check_kind(path: Path | str, target: Path, kind: FileKind) -> None:
    """Raise an OwnedError if a file is of another kind, or is being recorded."""
    with target.open("rb") as file:
        content = file.read(LOOK_BYTES)
    if content and not kind.recognizes(content):
        raise OwnedError(
            f"{path} is not {kind.name}, and would be lost: choose another file to write to, or move it away"
        )
    if is_being_recorded(target):
        raise OwnedError(f"{path} is being recorded: choose another file to write to, or wait for its end")


def _status(path: Path) -> os.stat_result | None:
    """Return the status of a file; None if it does not exist."""
    try:
        return path.stat()
    except FileNotFoundError:
        return None


def _is_same(target: Path, target_status: os.stat_result | None, used_file: Path) -> bool:
    """Return whether two paths refer to the same file, by name or as hard links."""
    if target == Path(realpath(used_file)):
        return True
    used_status = _status(used_file)
    return target_status is not None and used_status is not None and samestat(target_status, used_status)
