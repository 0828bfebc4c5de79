"""Repetition of the run in a trace, and comparison of the two runs."""

from __future__ import annotations

import filecmp
import tempfile
from pathlib import Path

import typer
from scanrack.jobs.record.order_repeater import is_session, lost_edits, orders_of
from scanrack.jobs.record.program_versions import versions_of
from scanrack.jobs.replay.replaying import lost_notes
from scanrack.jobs.run.running import RunOptions
from scanrack.jobs.trust.attachments import job_of
from scanrack.jobs.trust.owned import check_recording
from scanrack.terminal.complaints import reported_mistakes
from scanrack.terminal.reading import itself, print_notes, reading
from scanrack.terminal.status import DONE, NO
from scanrack.terminal.terminal import say
from scanrack.traces.compare import compare
from scanrack.traces.read.arrays import extent
from scanrack.traces.read.reader import Trace, open_trace

from ..programs.run_job import run_job
from .compare_job import print_comparison
from .comparison_options import ReplayOptions

PARENT = ("parent", "parent_scan")
"""Metadata keys of a branch; see `watch.play`."""

RERUN = "rerun"
"""Name of the second recording in the report."""


def rerun_trace(options: ReplayOptions) -> None:
    """Repeat a recorded session with the same rack file, program and scan count, and check for differences.

    Raises:
        typer.Exit: with the status of the command, unless it is 0.
    """
    with reported_mistakes(), open_trace(options.path) as trace, tempfile.TemporaryDirectory() as folder:
        status = _rerun(trace, Path(folder), options)
    raise typer.Exit(status)


def _rerun(trace: Trace, folder: Path, options: ReplayOptions) -> int:
    """Repeat the run with its operator actions, compare the two, and return the exit status."""
    path, trust, quiet = options.path, options.trust, options.quiet
    rerun_path, keep = options.record or folder / "rerun.mcap", 0 if options.replace else None
    try:
        job = job_of(trace, folder / "files", trust=trust)
    except ValueError:
        print_notes(trace)
        raise
    check_recording(job, rerun_path, itself(path), keep)
    edge_scans = extent(trace).scan.tolist()
    if not edge_scans:
        raise ValueError(f"{path}: the trace has no scans to compare with")
    first_scan, last_scan = edge_scans
    print_notes(trace)
    recorded = orders_of(trace.events())
    orders = recorded if recorded or is_session(trace) else None
    editions = None if orders is None else versions_of(trace, orders, job, folder / "edits", trust=trust)
    for note in lost_notes(lost_edits(trace.events())):
        say(f"note: {note}", err=True)
    scans = last_scan + 1
    parent = {key: trace.head.metadata[key] for key in PARENT if key in trace.head.metadata}
    running = RunOptions(trace=rerun_path, orders=orders, editions=editions, metadata=parent, keep=keep)
    status = run_job(job, scans, running, quiet=quiet, summarized=False)
    if status not in (DONE, NO):
        return status
    if not options.as_json and filecmp.cmp(path, rerun_path, shallow=False):
        if not quiet:
            say(f"{path.name}: {last_scan - first_scan + 1:,} scans, identical byte for byte")
        return DONE
    with open_trace(rerun_path) as rerun:
        with reading(trace, quiet=quiet) as progress:
            comparison = compare(trace, rerun, progress=progress)
        return print_comparison(comparison, (path.name, RERUN), as_json=options.as_json)
