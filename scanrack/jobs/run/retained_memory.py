"""Reads the retained tags of a ladder program before the first scan, and writes them after a run."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import Self

from scanrack.io_images.input_files import read_input
from scanrack.io_images.text_limits import LIMITS, TextKind
from scanrack.traces.files.guard import TAGS, check_output
from scanrack.traces.files.locking import beside, held
from scanrack.traces.files.newfile import naming, new_file

from ..load.loading import LoadedRack
from ..load.retaining import retaining
from ..load.rungs import is_rungs
from ..trust.owned import in_use, names_of


class RetainedMemory:
    """The retentive memory of a job; its file is locked until the context exits.

    Args:
        job: job with a ladder program.
        trace: path of the recording; None without a recording.
        keep: number of earlier recordings to keep, see `keeping_of`.

    Attributes:
        job: the job with the retained tags.

    Raises:
        ValueError: the program has no tags, or the file has another use or is not a file of retained tags.
        OSError: another run has locked the file, or its folder can't be written.
    """

    def __init__(
        self, job: LoadedRack, path: Path, trace: Path | None = None, keep: int | None = None
    ) -> None:
        if not is_rungs(job.logic):
            raise ValueError(f"--retain {path}: the program is a Python function; it has no tags to retain")
        self.path, self._program = path, job.logic
        recorded = [] if trace is None else names_of(job, trace, keep)
        self._used_files = {**in_use(job), **dict.fromkeys(recorded, "the recording")}
        target = check_output(path, TAGS, self._used_files)
        with ExitStack() as lock, naming(path, beside(target, "lock")):
            lock.enter_context(held(target))
            self.job, self._ignored = self._load(job)
            self._lock = lock.pop_all()  # held until the end, unless loading has failed

    def _load(self, job: LoadedRack) -> tuple[LoadedRack, list[str]]:
        """Return the job with the tags in the file, if it exists, and a sentence for each ignored tag."""
        try:
            data = read_input(self.path, LIMITS[TextKind.RETAINED].size)
        except FileNotFoundError:
            return job, []
        except OSError as error:
            raise ValueError(f"{self.path}: the retained tags can't be read: {error.strerror}") from None
        return retaining(job, data, str(self.path))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._lock.close()

    def begin(self) -> list[str]:
        """Load the retained tags; return a sentence for each tag that was ignored."""
        return [f"{self.path}: {sentence}" for sentence in self._ignored]

    def end(self) -> None:
        """Write the current tags.

        Raises:
            OwnedError: the file may no longer be replaced.
            OSError: the file can't be written; an earlier one is unchanged.
        """
        from scanrack.ladder.run.edit import retained_text

        with new_file(self.path, TAGS, used=self._used_files, locked=True) as file:
            file.write(retained_text(self._program.engine))
