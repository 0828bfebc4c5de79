"""Keeps earlier recordings under numbered names when a new one begins; the most recent has number 1.

    run.mcap  run.1.mcap  run.2.mcap  run.3.mcap             before, with 3 kept at most
       `---------, `---------, `---------, `----------,
    (new)     run.1.mcap  run.2.mcap  run.3.mcap  run.4.mcap      while it is recorded
    run.mcap  run.1.mcap  run.2.mcap  run.3.mcap                  at its end: the oldest is removed

If the new recording equals the previous one, byte for byte, all files get their previous names back. A killed
process leaves one file more than the limit, which is removed at the end of the next recording.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from itertools import count, takewhile
from os.path import realpath
from pathlib import Path

from .guard import NOTHING, TRACE, Used, check_output
from .patience import patiently

_COMPARED_BYTES = 1 << 20


def numbered(path: Path, number: int, stem: str | None = None) -> Path:
    """Return the name of an earlier recording.

    >>> numbered(Path("out/run.mcap"), 2).name, numbered(Path("run.line.mcap"), 2, "run").name
    ('run.2.mcap', 'run.2.line.mcap')

    Args:
        number: 1 for the previous recording; 0 is the recording itself.
        stem: the part before the number; None = the file name without its suffix.
    """
    stem = path.stem if stem is None else stem
    return path.with_name(f"{stem}.{number}{path.name.removeprefix(stem)}") if number else path


class RecordingKeeper:
    """Keeps the existing files when a new recording begins.

    Args:
        most: number of earlier recordings to keep, 1 or more.
        beside: files that belong to the recording and are kept with it; their names have the same stem.
    """

    def __init__(self, path: Path, most: int, beside: Sequence[Path] = ()) -> None:
        self._stem = Path(realpath(path)).stem
        self._paths = [Path(realpath(file_path)) for file_path in (path, *beside)]
        self._most = most
        self._moved: list[int] = []  # numbers before the move, in the order of the moves

    def names(self) -> list[Path]:
        """Return all names that may be moved, including the name of the new recording."""
        return [self._name(path, number) for number in range(self._most + 2) for path in self._paths]

    def begin(self) -> None:
        """Move the existing files up by one number.

        Raises:
            OSError: a file can't be moved; nothing has changed.
        """
        if not any(path.is_file() and path.stat().st_size for path in self._paths):
            return
        try:
            for number in reversed([0, *takewhile(self._is_taken, count(1))]):
                self._moved.append(number)
                self._move(number, number + 1)
        except OSError:
            self.undo()
            raise

    def undo(self) -> None:
        """Move all files back, because there is no new recording."""
        while self._moved:
            number = self._moved.pop()
            self._move(number + 1, number)

    def end(self) -> None:
        """Remove the oldest files beyond the limit; undo all moves if the new recording equals the last one.

        Raises:
            OSError: a file can't be removed or moved.
        """
        if not self._moved:
            return
        if all(_are_equal(path, self._name(path, 1)) for path in self._paths):
            for path in self._paths:
                self._name(path, 1).unlink(missing_ok=True)
            self._moved.pop()
            self.undo()
        else:
            for number in takewhile(self._is_taken, count(self._most + 1)):
                for path in self._paths:
                    self._name(path, number).unlink(missing_ok=True)
        self._moved.clear()

    def _name(self, path: Path, number: int) -> Path:
        has_own_name = path.name.startswith(f"{self._stem}.")  # the target of a link may have another name
        return numbered(path, number, self._stem if has_own_name else None)

    def _is_taken(self, number: int) -> bool:
        return any(self._name(path, number).exists() for path in self._paths)

    def _move(self, number: int, new_number: int) -> None:
        for path in self._paths:
            with suppress(FileNotFoundError):
                patiently(Path.rename, self._name(path, number), self._name(path, new_number))


def check_recordings(paths: Sequence[Path], keeping: RecordingKeeper | None, used: Used = NOTHING) -> None:
    """Raise an error if recordings would replace a file that is not a recording, or move a file in use.

    Args:
        keeping: the keeper of the existing files; None if the files are replaced.

    Raises:
        OwnedError: see `check_output`.
        OSError: a file can't be inspected.
    """
    for path in (*paths, *(keeping.names() if keeping else ())):
        check_output(path, TRACE, used)


def _are_equal(path_a: Path, path_b: Path) -> bool:
    """Return whether two files have the same content, or neither exists."""
    size_a, size_b = (path.stat().st_size if path.is_file() else None for path in (path_a, path_b))
    return size_a == size_b and (size_a is None or begin_alike(path_a, path_b, size_a))


def begin_alike(path_a: Path, path_b: Path, size: int) -> bool:
    """Return whether the first `size` bytes of two files are the same."""
    with path_a.open("rb") as file_a, path_b.open("rb") as file_b:
        for start in range(0, size, _COMPARED_BYTES):
            length = min(_COMPARED_BYTES, size - start)
            if file_a.read(length) != file_b.read(length):
                return False
    return True
