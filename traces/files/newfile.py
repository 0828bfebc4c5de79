"""Replaces files completely or not at all. Every output that replaces a file is written by this module.

    lock     .NAME.lock
    open     .NAME.9f3a61c04d2e77b1.part     a random name, exclusive, no links followed
    write
    fsync
    rename   to NAME                         NAME is the old file before this step, and the new file after it
    fsync    of the folder

After a failure NAME is unchanged. After a kill NAME is the complete old or the complete new file. A link
at NAME is kept, and its target is replaced. `guard` decides which files may be replaced.
"""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from typing import IO, Any

from .guard import NOTHING, FileKind, Used, check_output
from .locking import NO_LINK, beside, held
from .patience import patiently

Target = Path | str | IO[Any]
"""Where an output is written, either a file or an open stream."""

TEXT: dict[str, Any] = {"encoding": "utf-8", "newline": "\n"}
"""Options for text files, which produce the same bytes on every system."""


class Draft:
    """A file that is being written next to the target that it will replace.

    Attributes:
        file: the draft, open for writing.
        path: the draft's path.
    """

    def __init__(self, file: IO[Any], path: Path, target: Path, kind: FileKind) -> None:
        self.file, self.path, self._target, self._kind = file, path, target, kind

    def replace_target(self) -> None:
        """Flush the data to the disk, and replace the target.

        Raises:
            OwnedError: the target may no longer be replaced.
            OSError: the data can't be flushed; the target is unchanged.
        """
        check_output(self._target, self._kind)
        self.file.flush()
        os.fsync(self.file.fileno())
        self.file.close()
        patiently(os.replace, self.path, self._target)
        sync_folder(self._target.parent)


@contextmanager
def new_file(
    path: Target,
    kind: FileKind,
    mode: str = "w",
    *,
    used: Used = NOTHING,
    locked: bool = False,
    **options: Any,
) -> Iterator[IO[Any]]:
    """Open a new file for writing; it replaces the existing one when the block ends without an error.

    A stream, a device or a pipe is written directly, and flushed.

    Args:
        path: the file, or an open stream.
        kind: kind of the output; a file of another kind is not replaced.
        mode: "w" for text, see `TEXT`; "wb" for bytes.
        used: files that are not replaced, see `check_output`.
        locked: the caller holds the file, see `held`.
        options: options of `open`, in place of `TEXT`.

    Raises:
        OwnedError: the existing file may not be replaced.
        OSError: the file can't be written; the error names `path`.
    """
    if not isinstance(path, str | Path):
        yield path
        path.flush()
    elif Path(path).exists() and not Path(path).is_file():
        with naming(path), Path(path).open(mode, **_with_text(mode, options)) as file:
            yield file
    else:
        with replacing(path, kind, mode, used=used, locked=locked, **options) as draft:
            yield draft.file
            draft.replace_target()


@contextmanager
def replacing(
    path: Path | str,
    kind: FileKind,
    mode: str = "wb",
    *,
    used: Used = NOTHING,
    locked: bool = False,
    **options: Any,
) -> Iterator[Draft]:
    """Open a draft next to a file; it is removed unless `Draft.replace_target` replaces the file with it.

    Arguments and errors are the same as in `new_file`.
    """
    target = check_output(path, kind, used)
    draft = beside(target, f"{secrets.token_hex(8)}.part")
    with naming(path, draft, beside(target, "lock")), nullcontext() if locked else held(target):
        file = open(draft, mode, opener=_exclusive, **_with_text(mode, options))  # noqa: SIM115 - outside the try: a file that another process created is not removed
        try:
            with file:
                if target.exists():
                    shutil.copymode(target, draft)
                yield Draft(file, draft, target, kind)
        finally:
            with suppress(OSError):
                draft.unlink(missing_ok=True)


@contextmanager
def naming(path: Path | str, *helper_files: Path) -> Iterator[None]:
    """Add `path` to an OSError that names no file (as for a full disk) or one of `helper_files`."""
    try:
        yield
    except OSError as error:
        if error.errno is None or error.filename not in (None, *map(str, helper_files)):
            raise
        raise OSError(error.errno, error.strerror, str(path)) from error


def sync_folder(folder: Path) -> None:
    """Flush the names in a folder to the disk, if the system supports that."""
    with suppress(OSError):
        number = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(number)
        finally:
            os.close(number)


def _with_text(mode: str, options: dict[str, Any]) -> dict[str, Any]:
    return options if "b" in mode else TEXT | options


def _exclusive(path: str, flags: int) -> int:
    return os.open(path, flags & ~os.O_TRUNC | os.O_CREAT | os.O_EXCL | NO_LINK, 0o666)
