"""Programs that are loaded while another program runs, either from disk or with an edited file."""

from __future__ import annotations

from dataclasses import replace
from os.path import realpath
from pathlib import Path

from scanrack.jobs.load.loading import LoadedRack, load_job
from scanrack.jobs.record.program_versions import ProgramVersion, ProgramVersions, folders_of, forget
from scanrack.jobs.run.running import JobRun
from scanrack.jobs.trust.attachments import load_files, program_name
from scanrack.ladder import LadderLogic
from scanrack.ladder.python.sequences import Logic
from scanrack.runtime.live.actions import ALL, names_in

from .history.program_file import digest, save, write
from .panels.kept_panel import stamp_of
from .preview import Json, findings_of


class EditedPrograms:
    """The program file of a session, and the versions of the program.

    Args:
        job: the first program.
        rack: path of the rack file.

    Attributes:
        versions: the versions that have run.
        seen: digest of the file when this session last loaded or wrote it; "" if it was missing.
    """

    def __init__(self, job: LoadedRack, rack: str, run: JobRun, versions: ProgramVersions) -> None:
        self.file, self.name = job.program, program_name(job)
        self._rack, self._run, self.versions = rack, run, versions
        self._has_recorded_tags = bool(job.spec.tags)
        self._folders: set[Path] = set()  # folders of loaded copies
        self._reloaded: tuple[int, LoadedRack, list[Json]] | None = None  # number of edits, program, findings
        self._note(self.on_disk)

    @property
    def running(self) -> ProgramVersion:
        """The running version."""
        return self.versions[self._run.program.edits]

    @property
    def rungs(self) -> LadderLogic | None:
        """The running program; None if it is not a ladder program."""
        debugger = self._run.program.debugger
        return None if debugger is None else debugger.program

    # --- the file

    @property
    def on_disk(self) -> bytes | None:
        """The contents of the file; None if it can't be read."""
        try:
            return self.file.read_bytes()
        except OSError:
            return None

    def saved_text(self) -> str:
        """Return the text of the file; raise OSError if it can't be read, ValueError if it is not UTF-8."""
        with self.file.open(encoding="utf-8", newline="") as file:
            return file.read()

    @property
    def running_text(self) -> str:
        """The text of the running program."""
        return self.running.files[self.name].decode(errors="replace")

    def _note(self, data: bytes | None) -> None:
        """Note that this session has loaded or written the file."""
        self.look()
        self.seen = "" if data is None else digest(data)

    def look(self) -> None:
        """Note the state of the file, so that `is_rewritten` is false until it is written again."""
        self._stamp = stamp_of(self.file)

    def is_rewritten(self) -> bool:
        """Return whether the file was written since the last `look`; False if it is missing or empty."""
        stamp = stamp_of(self.file)
        return stamp is not None and stamp[1] > 0 and stamp != self._stamp

    def write(self, data: bytes) -> None:
        """Replace the file; raise OSError if it can't be written."""
        write(self.file, data)
        self._note(data)

    def save_running(self) -> str:
        """Save the running program to the file; return a message about the old file.

        Raises:
            ValueError: another program has written the file.
            OSError: the file can't be written and is unchanged.
        """
        data, old_data = self.running.files[self.name], self.on_disk
        if old_data is None:
            self.write(data)
            return f"Saved in {self.file.name}, which was missing."
        if digest(old_data) != self.seen:
            raise ValueError(f"{self.file.name} was changed by another program; reload it first")
        if data == old_data:
            return f"{self.file.name} already has these rungs."
        backup = save(self.file, data)
        self._note(data)
        return f"Saved in {self.file.name}; the old file is {backup.name}."

    # --- versions

    def from_disk(self) -> LoadedRack:
        """Load the program from disk; raise ValueError if it can't be used."""
        self._forget()
        job = load_job(self._rack)
        if realpath(job.program) != realpath(self.file):
            raise ValueError(f"{job.program}: a different program file needs a new session")
        return job

    def with_file(self, data: bytes) -> tuple[ProgramVersion, LoadedRack]:
        """Load the running version with new contents for its file; return the version and program."""
        files = {**self.running.files, self.name: data}
        copy = self.versions.with_copy(replace(self.running, files=files, retained=None))
        return copy, self.load(copy)

    def load(self, copy: ProgramVersion) -> LoadedRack:
        """Load a version from its copy on disk; raise ValueError if it can't be used."""
        assert copy.place is not None
        self._forget()
        job = load_files(copy.place, copy.rack, copy.program)
        self._folders |= folders_of(job)
        return job

    def _forget(self) -> None:
        """Unload the Python modules of the program and its copies: the next load reads their files."""
        forget([self.file.parent.resolve(), *self._folders])

    def usable(self, job: LoadedRack, restart: str = "") -> LoadedRack:
        """Compile and return a program; raise ValueError if it can't replace the running one."""
        if isinstance(job.logic, LadderLogic) is (self.rungs is None):
            raise ValueError(f"{job.program}: a different kind of program needs a new session")
        if isinstance(job.logic, LadderLogic):
            job.logic.build()
            _ = job.logic.scanner  # compile it now, not between two scans
        elif self._has_recorded_tags and (ALL in names_in(restart) or not isinstance(job.logic, Logic)):
            raise ValueError(f"{job.program}: recorded values (tags) would restart; start a new session")
        return job

    def reloaded(self) -> tuple[LoadedRack, list[Json]]:
        """Load another copy of the running program; return it with its findings."""
        number = self._run.program.edits
        if self._reloaded is None or self._reloaded[0] != number:
            job = self.with_file(self.running.files[self.name])[1]
            self._reloaded = number, job, findings_of(job)
        return self._reloaded[1:]
