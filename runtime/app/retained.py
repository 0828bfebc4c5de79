"""The file of a ladder program's tags from run to run: read before the first scan, written after the last."""

from __future__ import annotations

from pathlib import Path

from ...ladder import LadderLogic
from ...ladder.edit import retained_text
from ...traces.guard import TAGS, check_output
from ...traces.newfile import new_file
from .loading import Job
from .owned import in_use, recording_of
from .retaining import retaining


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
        self.path, self._program = path, job.logic
        recorded = [] if trace is None else recording_of(job, trace)
        self._used = {**in_use(job), **dict.fromkeys(recorded, "the recording")}
        check_output(path, TAGS, self._used)
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
        with new_file(self.path, TAGS, used=self._used, encoding="utf-8") as file:
            file.write(retained_text(self._program.engine))
