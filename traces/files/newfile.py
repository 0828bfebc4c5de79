"""The one writer of files that are replaced: completely, or not at all.

    lock     .NAME.lock
    open     .NAME.9f3a61c04d2e77b1.part     a random name, exclusively, no link followed
    write
    fsync
    rename   to NAME                         the old one until here, the new one from here on
    fsync    of the folder

Whatever fails, NAME is as it was. Whenever the process is killed, NAME is one of the two, whole. A link at
NAME stays, and the file that it leads to is replaced. What may be replaced is decided in `guard`.
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

Target = Path | str | IO[Any]
"""Where something is written: a file, or a stream that is open already."""


class Draft:
    """A file that is being written, beside the one whose place it will take.

    Args:
        file: it, open for writing.
        target: whose place it takes.

    Attributes:
        file: it, open for writing.
    """

    def __init__(self, file: IO[Any], place: Path, target: Path, kind: FileKind) -> None:
        self.file, self.place, self._target, self._kind = file, place, target, kind

    def sync(self) -> None:
        """Put what was written on the disk."""
        self.file.flush()
        os.fsync(self.file.fileno())

    def put(self) -> None:
        """Let it take the place of the target.

        Raises:
            OwnedError: there is something by now that may not be replaced.
            OSError: it can't be put on the disk; the target is as it was.
        """
        check_output(self._target, self._kind)
        self.sync()
        self.file.close()
        os.replace(self.place, self._target)
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
    """Open a file for writing, which takes the place of what is there when the block ends without an error.

    A stream is written and flushed; so is a device or a pipe.

    Args:
        path: the file, or an open stream.
        kind: what is written; a file of another kind is not replaced.
        mode: "w" for text, "wb" for bytes.
        used: files that are not replaced, see `check_output`.
        locked: the caller holds the file, see `held`.
        options: those of `open`.

    Raises:
        OwnedError: what is there may not be replaced.
        OSError: it can't be written; the error names `path`.
    """
    if not isinstance(path, str | Path):
        yield path
        path.flush()
    elif Path(path).exists() and not Path(path).is_file():
        with naming(path), Path(path).open(mode, **options) as file:
            yield file
    else:
        with replacing(path, kind, mode, used=used, locked=locked, **options) as draft:
            yield draft.file
            draft.put()


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
    """Open a file beside another one, whose place it takes with `Draft.put`; without, it is removed.

    Arguments and errors as `new_file`.
    """
    target = check_output(path, kind, used)
    place = beside(target, f"{secrets.token_hex(8)}.part")
    with naming(path, place, beside(target, "lock")), nullcontext() if locked else held(target):
        file = open(place, mode, opener=_exclusive, **options)  # noqa: SIM115 - what is not ours stays
        try:
            with file:
                if target.exists():
                    shutil.copymode(target, place)
                yield Draft(file, place, target, kind)
        finally:
            with suppress(OSError):
                place.unlink(missing_ok=True)


@contextmanager
def naming(path: Path | str, *places: Path) -> Iterator[None]:
    """Let an error about no file in particular, such as a full disk, or about one of `places` name `path`."""
    try:
        yield
    except OSError as error:
        if error.errno is None or error.filename not in (None, *map(str, places)):
            raise
        raise OSError(error.errno, error.strerror, str(path)) from error


def sync_folder(folder: Path) -> None:
    """Put the names in a folder on the disk; not every system does so when asked."""
    with suppress(OSError):
        number = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(number)
        finally:
            os.close(number)


def _exclusive(path: str, flags: int) -> int:
    return os.open(path, flags & ~os.O_TRUNC | os.O_CREAT | os.O_EXCL | NO_LINK, 0o666)
