"""Writes a file completely or not at all: an incomplete file is removed."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any

Target = Path | str | IO[Any]
"""Where something is written: a file, or a stream that is open already."""


@contextmanager
def new_file(path: Target, mode: str = "w", **options: Any) -> Iterator[IO[Any]]:
    """Open a file for writing, replacing what is there; remove it if the block or its close fails.

    A device or pipe stays, and so does a file that can't be opened. A stream is written and flushed.

    Args:
        path: the file, or an open stream.
        mode: "w" for text, "wb" for bytes.
        options: those of `open`.

    Raises:
        OSError: it can't be opened or written.
    """
    if not isinstance(path, str | Path):
        yield path
        path.flush()
        return
    path = Path(path)
    file = path.open(mode, **options)
    try:
        with file:
            yield file
    except BaseException:
        if path.is_file():
            with suppress(OSError):
                path.resolve().unlink()
        raise
