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
    """Observes every bench that is opened while it is set in `OBSERVER`; this base class does nothing."""

    def loading(self) -> AbstractContextManager[object]:
        """Return a context in which programs are loaded."""
        return nullcontext()

    def listeners(self, job: LoadedRack, logic: ScanLogic) -> Iterable[ScanListener]:
        """Return further listeners of a bench."""
        return ()


OBSERVER: ContextVar[BenchObserver] = ContextVar("OBSERVER", default=BenchObserver())  # noqa: B039 - it has no state
"""The observer of all benches that are opened."""


def open_bench(rack: str | Path, record: str | Path | None = None, *, watched: bool = False) -> Bench:
    """Open a rack with its program on a bench, powered up but not yet scanned.

    A ladder program runs under a debugger: its values can be explained and forced, and it can be stopped. A
    Python program is loaded again, so that no state of an earlier bench remains.

    Args:
        rack: path of the rack file, TOML or Python.
        record: path of the recording, which `Bench.close` completes; None = no recording.
        watched: the rack's watchdog ends endless logic.

    Raises:
        ValueError: the rack or program is unusable; the message has file, line, key and allowed values.
        OSError: the recording can't be written.
    """
    with OBSERVER.get().loading():
        job = load_job(str(rack))
    return bench_of(
        job, None if record is None else Path(record), watched=watched, load=loading(job, str(rack))
    )


def loading(job: LoadedRack, rack: str) -> Load | None:
    """Return the loader of a job's Python program; None for a ladder program, which runs under a debugger.

    Args:
        rack: path of the rack, as for `load_job`.
    """
    if isinstance(job.logic, LadderLogic):
        return None
    return Load(job.program, lambda: load_job(rack).logic)


def with_edits(load: Load, editions: ProgramVersions) -> Load:
    """Return a loader for the first program of a bench and its edits, from their files at that time."""

    def logic() -> ScanLogic:
        return editions.again(0).logic if editions.edited else load.logic()

    return replace(load, logic=logic, edited=lambda number: editions.again(number).logic)


def bench_of(
    job: LoadedRack, record: Path | None = None, *, watched: bool = False, load: Load | None = None
) -> Bench:
    """Put a loaded job on a bench, see `open_bench`; `load` reloads its program for `why`."""
    recorders: list[ScanListener] = []
    editions = ProgramVersions(job.folder)

    def listeners(rack: Rack) -> Iterable[ScanListener]:
        if record is not None:
            recorders.append(watching(RecordsEdits(recorder_for(job, rack, record, logic), editions), logic))
        return [*recorders, *OBSERVER.get().listeners(job, logic)]

    if load is not None:
        editions.begin(version_of(job))
        load = with_edits(load, editions)
    logic = Debugger(job.logic) if isinstance(job.logic, LadderLogic) else job.logic
    bench = Bench(job.spec, logic, listeners=listeners, watched=watched, load=load, editions=editions)
    editions.follow(job)
    bench.recorder = next(iter(recorders), None)
    return bench
