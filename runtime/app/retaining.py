"""Tags of a ladder program from run to run: read before the first scan, written after the last."""

from __future__ import annotations

from os import replace
from os.path import realpath
from pathlib import Path

from ...ladder import LadderError, LadderLogic
from ...ladder.edit import retain, retained_text
from .loading import Job


class Retained:
    """The retentive memory of a job.

    Attributes:
        path: its file.

    Args:
        job: runs a ladder program.
        path: its file.
        trace: the recording, None without one.

    Raises:
        ValueError: the job's program has no tags, the file is one that is in use for something else, or it
            is no file of retained tags.
    """

    def __init__(self, job: Job, path: Path, trace: Path | None = None) -> None:
        if not isinstance(job.logic, LadderLogic):
            raise ValueError(f"--retain {path}: the program is a Python function; it has no tags to retain")
        used = [job.rack_file, job.program, *([trace] if trace else [])]
        if realpath(path) in map(realpath, used):
            raise ValueError(f"--retain would replace {path}: give the tags a file of their own")
        self.path, self._program = path, job.logic
        self._said = self._load()

    def _load(self) -> list[str]:
        try:
            text = self.path.read_text(encoding="utf-8")
        except FileNotFoundError:
            return []
        except (OSError, UnicodeDecodeError) as error:
            raise ValueError(f"{self.path}: the retained tags can't be read: {error}") from None
        try:
            return retain(self._program.engine, text)
        except LadderError as error:
            raise ValueError(f"{self.path}: {error}") from None

    def begin(self) -> list[str]:
        """Return what was not taken over, a sentence each."""
        return [f"{self.path}: {each}" for each in self._said]

    def end(self) -> None:
        """Write the tags as they stand.

        Raises:
            OSError: the file can't be written; an earlier one is still whole.
        """
        part = self.path.with_name(f"{self.path.name}.part")
        part.write_text(retained_text(self._program.engine), encoding="utf-8")
        replace(part, self.path)
