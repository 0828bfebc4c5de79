"""Tags of a ladder program from run to run: read before the first scan, written after the last.

The file that a run begins with travels with its trace, so that a rerun begins with it, too.
"""

from __future__ import annotations

import os
from dataclasses import replace
from os.path import realpath
from pathlib import Path

from ...ladder import LadderError, LadderLogic
from ...ladder.edit import retain, retained_text
from .loading import Job


class Retained:
    """The retentive memory of a job.

    Attributes:
        path: its file.
        job: the job with its program's tags as the file has them; a recording brings the file.

    Args:
        job: runs a ladder program.
        path: its file.
        trace: the recording, None without one.

    Raises:
        ValueError: the job's program has no tags, the file is one that is in use for something else, or it
            is not a file of retained tags.
    """

    def __init__(self, job: Job, path: Path, trace: Path | None = None) -> None:
        if not isinstance(job.logic, LadderLogic):
            raise ValueError(f"--retain {path}: the program is a Python function; it has no tags to retain")
        used = [job.rack_file, job.program, *([trace] if trace else [])]
        if realpath(path) in map(realpath, used):
            raise ValueError(f"--retain would replace {path}: give the tags a file of their own")
        self.path, self._program = path, job.logic
        self.job, self._said = self._load(job)

    def _load(self, job: Job) -> tuple[Job, list[str]]:
        try:
            data = self.path.read_bytes()
        except FileNotFoundError:
            return job, []
        except OSError as error:
            raise ValueError(f"{self.path}: the retained tags can't be read: {error}") from None
        return retaining(job, data, str(self.path))

    def begin(self) -> list[str]:
        """Return what was not taken over, a sentence each."""
        return [f"{self.path}: {each}" for each in self._said]

    def end(self) -> None:
        """Write the present tags.

        Raises:
            OSError: the file can't be written; an earlier one is still whole.
        """
        part = self.path.with_name(f"{self.path.name}.part")
        part.write_text(retained_text(self._program.engine), encoding="utf-8")
        os.replace(part, self.path)


def retaining(job: Job, data: bytes, name: str) -> tuple[Job, list[str]]:
    """Let a job's ladder program begin with retained tags.

    Args:
        job: its program has done no scan yet.
        data: contents of the file of tags.
        name: what the file is called in messages.

    Returns:
        The job with the file, and what was not taken over, a sentence each.

    Raises:
        ValueError: it is not a file of retained tags, or the program is a Python function.
    """
    if not isinstance(job.logic, LadderLogic):
        raise ValueError(f"{name}: the program is a Python function; it has no tags to retain")
    try:
        said = retain(job.logic.engine, data.decode("utf-8"))
    except UnicodeDecodeError as error:
        raise ValueError(f"{name}: the retained tags can't be read: {error}") from None
    except LadderError as error:
        raise ValueError(f"{name}: {error}") from None
    return replace(job, retained=data), said
