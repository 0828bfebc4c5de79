"""Opens a rack file on a bench, for users' tests and for commands that inspect a running program."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import AbstractContextManager, nullcontext
from contextvars import ContextVar
from dataclasses import replace
from pathlib import Path

from scanrack.ladder import LadderLogic
from scanrack.ladder.debug import Debugger
from scanrack.runtime.loop.listeners import ScanListener
from scanrack.runtime.loop.rack import Rack
from scanrack.runtime.loop.scan import ScanLogic

from ..load.loading import LoadedRack, load_job
from ..record.program_versions import ProgramVersions, version_of
from ..record.recording import recorder_for
from ..record.sequence_watch import watching
from ..run.editing import RecordsEdits
from ..why.traced_run import Load
from .bench import Bench


class BenchObserver:
    """Observes every bench opened while `OBSERVER` contains it; this base class does nothing."""

    def loading(self) -> AbstractContextManager[object]:
        """Return the context for loading programs."""
        return nullcontext()

    def listeners(self, job: LoadedRack, logic: ScanLogic) -> Iterable[ScanListener]:
        """Return additional listeners for a bench."""
        return ()


OBSERVER: ContextVar[BenchObserver] = ContextVar("OBSERVER", default=BenchObserver())  # noqa: B039 - it has no state
"""The observer of all benches."""


def open_bench(rack: str | Path, record: str | Path | None = None, *, watched: bool = False) -> Bench:
    """Open a rack with its program on a bench, powered up but not yet scanned.

    A ladder program runs under a debugger, which explains and forces values and has breakpoints. A Python
    program is loaded again, so that no state of an earlier bench remains.

    Args:
        rack: path of the rack file, TOML or Python.
        record: path of the recording, which `Bench.close` completes; None = no recording.
        watched: whether the rack's watchdog ends endless logic.

    Raises:
        ValueError: the rack or program is unusable; the message has file, line, key and allowed values.
        OSError: the recording can't be written.
    """
    with OBSERVER.get().loading():
        job = load_job(str(rack))
    recording = None if record is None else Path(record)
    return bench_of(job, recording, watched=watched, load=loading(job, str(rack)))


def loading(job: LoadedRack, rack: str) -> Load | None:
    """Return the loader of a job's Python program; None for a ladder program, which runs under a debugger.

    Args:
        rack: path of the rack, as for `load_job`.
    """
    if isinstance(job.logic, LadderLogic):
        return None
    return Load(job.program, lambda: load_job(rack).logic)


def with_edits(load: Load, versions: ProgramVersions) -> Load:
    """Return a loader for the first program of a bench and its edits, from the stored files."""

    def load_first() -> ScanLogic:
        return versions.again(0).logic if versions.edited else load.logic()

    return replace(load, logic=load_first, edited=lambda number: versions.again(number).logic)


def bench_of(
    job: LoadedRack, record: Path | None = None, *, watched: bool = False, load: Load | None = None
) -> Bench:
    """Put a loaded job on a bench, see `open_bench`; `load` reloads its program for `why`."""
    recorders: list[ScanListener] = []  # the recorder, if there is a recording
    versions = ProgramVersions(job.folder)

    def listeners(rack: Rack) -> Iterable[ScanListener]:
        if record is not None:
            recorder = RecordsEdits(recorder_for(job, rack, record, logic), versions)
            recorders.append(watching(recorder, logic))
        return [*recorders, *OBSERVER.get().listeners(job, logic)]

    if load is not None:
        versions.begin(version_of(job))
        load = with_edits(load, versions)
    logic = Debugger(job.logic) if isinstance(job.logic, LadderLogic) else job.logic
    bench = Bench(job.spec, logic, listeners=listeners, watched=watched, load=load, versions=versions)
    versions.follow(job)
    bench.recorder = recorders[0] if recorders else None
    return bench
