"""A file that is whole, or not there: what writing it leaves half-done is removed."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any


@contextmanager
def new_file(path: Path, mode: str = "w", **options: Any) -> Iterator[IO[Any]]:
    """Open a file for writing, replacing what is there; remove it if the block or its close fails.

    A device or pipe stays, and so does a file that can't be opened.

    Args:
        path: the file.
        mode: "w" for text, "wb" for bytes.
        options: those of `open`.

    Raises:
        OSError: it can't be opened or written.
    """
    file = path.open(mode, **options)
    try:
        with file:
            yield file
    except BaseException:
        if path.is_file():
            with suppress(OSError):
                path.resolve().unlink()
        raise
