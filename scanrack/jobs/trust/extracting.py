"""Writes the files in a trace into a folder, and nowhere else."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from scanrack.traces.files.portable import DEVICE

if TYPE_CHECKING:  # a run does not read recordings
    from scanrack.traces.read.reader import Trace

_BAD_PARTS = {
    "": "has an empty part",
    ".": "has a part '.'",
    "..": "leads out of its folder",
}
_BAD_NAMES = (
    (re.compile(r"/"), "leads out of its folder: it is absolute"),
    (re.compile(r".*\\"), "leads out of its folder on a system where \\ separates folders"),
    (re.compile(r".*:"), "has a colon, which is a drive or a stream on Windows"),
    (re.compile(r".*[. ](/|$)"), "has a part that ends in a dot or a space, which Windows drops"),
    (
        re.compile(f"(.*/)?{DEVICE}", re.IGNORECASE),
        "is a device on Windows",
    ),
)
"""Forbidden name patterns, with reasons. They apply on all systems, so a trace is valid on all or none."""


def checked_name(name: str) -> str:
    """Return the name of a file in a trace, if the file stays in the target folder.

    Args:
        name: path relative to the target folder, with parts separated by `/`.

    Raises:
        ValueError: the name could lead elsewhere, or is not the name of a file.
    """
    reason = next(_objections(name), None)
    if reason is not None:
        raise ValueError(f"{name!r} is not allowed as a file name: it {reason}")
    return name


def _objections(name: str) -> Iterator[str]:
    """Yield the reasons why a name is not allowed, the clearest first."""
    if not name.isprintable():
        yield "has characters that can't be printed"
    yield from (reason for pattern, reason in _BAD_NAMES[:2] if pattern.match(name))
    yield from (_BAD_PARTS[part] for part in name.split("/") if part in _BAD_PARTS)
    yield from (reason for pattern, reason in _BAD_NAMES[2:] if pattern.match(name))


def check_names(names: Iterable[str]) -> None:
    """Check that files with these names can be written to one folder.

    Raises:
        ValueError: a name leads elsewhere, or two names are the same on a system that ignores case.
    """
    names_by_key: dict[str, str] = {}
    for name in names:
        key = unicodedata.normalize("NFKC", checked_name(name)).casefold()
        if key in names_by_key:
            raise ValueError(f"the trace has {names_by_key[key]!r} and {name!r}, which may be the same file")
        names_by_key[key] = name


def attached_files(trace: Trace) -> dict[str, bytes]:
    """Return the files in a trace, by name."""
    return {attachment.name: attachment.data for attachment in trace.attachments()}


def extract(files: Mapping[str, bytes], folder: Path) -> list[Path]:
    """Write files into a folder, creating it if it is missing; return their paths.

    Symbolic links inside the folder are not followed.

    Raises:
        ValueError: a name leads out of the folder, or another file already exists.
        OSError: a file can't be written.
    """
    check_names(files)
    targets = {folder / name: data for name, data in files.items()}
    for target, data in targets.items():
        _check_free(target, data, folder)
    for target, data in targets.items():
        target.parent.mkdir(parents=True, exist_ok=True)
        if not target.exists():
            with target.open("xb") as file:  # unlike "wb", this never follows a link
                file.write(data)
    return list(targets)


def _check_free(target: Path, data: bytes, folder: Path) -> None:
    """Raise ValueError if writing would overwrite another file or follow a symbolic link."""
    for path in (target, *target.parents):
        if path == folder:
            break
        if path.is_symlink():
            raise ValueError(f"{path} is a symbolic link: choose another folder")
    if target.exists() and (not target.is_file() or target.read_bytes() != data):
        raise ValueError(f"{target} already exists with other contents: choose another folder")
