"""The programs of a session as files: the first program and the result of each edit.

    scan     0 ............ 4,010 ............ 9,200 ....
    number   0              1                  2
    trace    feeder.rung    edit-1/feeder.rung edit-2/feeder.rung     attachments, with the files beside them
    orders                  edit 1             edit 2                 on /orders

Each program can be reloaded for a rerun, for a branch, or by a monitor that shows past scans.
"""

from __future__ import annotations

import atexit
import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import field, replace
from pathlib import Path

from scanrack.io_images.dataclass import dataclass
from scanrack.runtime.live.actions import Edit
from scanrack.runtime.live.operator_actions import AppliedAction
from scanrack.traces.format.topics import ORDERS
from scanrack.traces.read.reader import Trace
from scanrack.traces.write.recorder import Attachment

from ..load.loading import LoadedRack, load_job
from ..load.retaining import retaining
from ..trust.attachments import (
    RETAINED,
    attachment,
    edit_number,
    files_of,
    folder_of_edit,
    forget_imported,
    load_files,
    made_by,
    own_program,
)
from ..trust.extracting import attached_files, extract
from ..trust.trust import RunFiles, address_name, admitted
from .order_repeater import orders_of


@dataclass(frozen=True, slots=True)
class ProgramVersion:
    """A program of a session, and its files."""

    rack: str  # the rack file in `files`, `path[:function]`
    program: str  # the program in `files`, `path[:function]`
    files: Mapping[str, bytes]  # contents by name in a trace
    paths: Mapping[str, Path] = field(default_factory=dict)  # paths on disk; empty for files from a trace
    retained: bytes | None = None  # content of the file of its initial tags; None without one
    place: Path | None = None  # folder with a copy of `files`, for other processes; None without a copy

    @property
    def is_on_disk(self) -> bool:
        """Whether the files on disk are unchanged."""
        return bool(self.paths) and all(
            path.is_file() and path.read_bytes() == self.files[name] for name, path in self.paths.items()
        )


def version_of(job: LoadedRack) -> ProgramVersion:
    """Return the version for a job just loaded from disk; raise OSError if a file can't be read."""
    facts, paths = made_by(job), files_of(job)
    files = {name: path.read_bytes() for name, path in paths.items()}
    return ProgramVersion(facts["rack_file"], facts["program_file"], files, paths, job.retained)


class ProgramVersions:
    """The programs of a session, by number; 0 is the first.

    Args:
        folder: folder for copies of files that have changed on disk.
        rack: address of the rack file on disk; None if all files come from a trace.
        versions: the programs so far, by number.
    """

    def __init__(
        self, folder: Path, rack: str | None = None, versions: Mapping[int, ProgramVersion] | None = None
    ) -> None:
        self._folder, self._rack = folder, rack
        self._versions: dict[int, ProgramVersion] = dict(versions or {})
        self._loaded: dict[int, LoadedRack] = {}  # programs that were loaded and have not run
        self._used: set[Path] = set()  # folders in which loaded programs find modules
        self._copies: Path | None = None  # folder of `again`

    def __getitem__(self, number: int) -> ProgramVersion:
        return self._versions[number]

    def keep(self, number: int, version: ProgramVersion, job: LoadedRack) -> None:
        """Add a loaded program; replace a program with the same number."""
        self._versions[number], self._loaded[number] = version, job
        self.follow(job)

    def begin(self, version: ProgramVersion) -> None:
        """Add the first program. An edit can change its files."""
        self._versions[0] = version

    @property
    def edited(self) -> bool:
        """Whether there are programs after the first."""
        return any(self._versions)

    def again(self, number: int) -> LoadedRack:
        """Return a program in its initial state, loaded from copies of its files in a temporary folder.

        Raises:
            ValueError: its files are missing, or it can't be loaded.
        """
        if self._copies is None:
            holder = tempfile.TemporaryDirectory(prefix="scanrack-")
            atexit.register(holder.cleanup)
            self._copies = Path(holder.name)
        return ProgramVersions(self._copies, None, self._versions).job(number)

    def follow(self, job: LoadedRack) -> None:
        """Register a loaded program, so that its modules are dropped when another program is loaded."""
        self._used |= folders_of(job)

    def forget(self) -> None:
        """Drop the modules of all programs so far, so that their files are read again."""
        forget(self._used)

    def up_to(self, number: int) -> ProgramVersions:
        """Return the programs up to a number for a branch; none of them is loaded yet."""
        versions = {
            version_number: version
            for version_number, version in self._versions.items()
            if version_number <= number
        }
        branch = ProgramVersions(self._folder, self._rack, versions)
        branch._used = set(self._used)
        return branch

    def job(self, number: int) -> LoadedRack:
        """Return a program in its initial state, either the kept one or a newly loaded one.

        Raises:
            ValueError: the number is unknown, or the program can't be loaded.
            OSError: its files can't be written.
        """
        loaded = self._loaded.pop(number, None)
        if loaded is not None:
            return loaded
        if number not in self._versions:
            raise ValueError(f"the files of edit {number} are missing")
        job = self._load(self._versions[number])
        self.follow(job)
        return job

    def _load(self, version: ProgramVersion) -> LoadedRack:
        """Load a program from its unchanged files on disk, or else from copies of its files."""
        self.forget()
        if self._rack is not None and version.is_on_disk:
            job = load_job(self._rack)
            if version.is_on_disk:  # no file has changed while it was loaded
                return job
        job = load_files(self._copy_files(version), version.rack, version.program)
        return job if version.retained is None else retaining(job, version.retained, RETAINED)[0]

    def of_a_session(self, begins: ProgramVersion) -> ProgramVersions:
        """Return the programs of a new session, with a copy of each; raise OSError if that fails."""
        versions = {0: begins, **self._versions}
        copies = {number: self.with_copy(version) for number, version in versions.items()}
        session = ProgramVersions(self._folder, self._rack, copies)
        session._used = set(self._used)
        return session

    def with_copy(self, version: ProgramVersion) -> ProgramVersion:
        """Return a program with a copy of its files; raise OSError if the copy can't be written."""
        return replace(version, place=self._copy_files(version))

    def _copy_files(self, version: ProgramVersion) -> Path:
        """Copy the files of a program to a new folder; return the folder."""
        self._folder.mkdir(parents=True, exist_ok=True)
        number = sum(1 for _ in self._folder.glob("program-*"))
        folder = self._folder / f"program-{number}"
        extract(version.files, folder)
        return folder.resolve()

    def attachments(self, number: int) -> list[Attachment]:
        """Return the files of an edit as attachments for a trace, sorted by name."""
        files, folder = self._versions[number].files, folder_of_edit(number)
        return [attachment(f"{folder}{name}", files[name]) for name in sorted(files)]


def edits_of(trace: Trace) -> list[AppliedAction]:
    """Return the recorded edits in order, reading only the chunks after their files."""
    starts: dict[int, int] = {}
    for span, name in trace.attachment_names():
        if number := edit_number(name):
            starts.setdefault(number, span.offset)
    edits = [_edit_after(trace, number, offset) for number, offset in sorted(starts.items())]
    return [edit for edit in edits if edit is not None]


def _edit_after(trace: Trace, number: int, offset: int) -> AppliedAction | None:
    """Return an edit from the chunks after its files; None if it was not applied."""
    topics = {ORDERS.name, "/events"}
    for section in trace.sections:
        if section.span.offset > offset and trace.may_contain(section, topics):
            for order in orders_of(trace.events_in(section, topics)):
                if isinstance(order.order, Edit) and order.order.number == number:
                    return order
    return None


def versions_of(
    trace: Trace, edits: Iterable[AppliedAction], job: LoadedRack, folder: Path, *, trust: bool
) -> ProgramVersions:
    """Return the programs of a recorded session, as far as their use is allowed.

    Args:
        edits: operator actions of the session.
        job: first program of the session.
        trust: whether to run Python of the trace, see `trust`.

    Raises:
        UntrustedError: untrusted Python of the trace would be run.
        ValueError: files of an edit are missing, or can't be used.
    """
    files = attached_files(trace)
    rack = trace.head.metadata.get("rack_file", "")
    versions = {}
    for edit in edits:
        if isinstance(edit.order, Edit):
            number, program = edit.order.number, edit.order.program
            versions[number] = _recorded_version(files, number, rack, program, trust=trust)
    session = ProgramVersions(folder, None, versions)
    session.follow(job)
    return session


def _recorded_version(
    files: Mapping[str, bytes], number: int, rack: str, program: str, *, trust: bool
) -> ProgramVersion:
    """Return the program of an edit, with its files from a trace; raise ValueError if they are missing."""
    folder = folder_of_edit(number)
    edit_files = {name.removeprefix(folder): data for name, data in files.items() if name.startswith(folder)}
    if not edit_files:
        raise ValueError(f"the trace lacks the files of edit {number}, which its run needs")
    run_files = RunFiles(address_name(rack), own_program(rack, program) and address_name(program))
    return ProgramVersion(rack, program, admitted(edit_files, run_files, trust=trust))


def forget(folders: Iterable[Path]) -> None:
    """Drop the modules of earlier programs.

    Args:
        folders: absolute paths without symbolic links.
    """
    for folder in folders:
        forget_imported(folder)


def folders_of(job: LoadedRack) -> set[Path]:
    """Return the folders in which a job's Python finds modules."""
    stubs = {(job.folder / stub_file).parent.resolve() for stub_file in job.stub_files}
    return {job.rack_file.parent.resolve(), job.program.parent.resolve(), *stubs}
