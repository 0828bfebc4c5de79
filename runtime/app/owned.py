"""The files of a job, which no output replaces, and where its recording goes."""

from __future__ import annotations

from pathlib import Path

from ...traces.guard import NOTHING, TRACE, Used, check_output
from .attachments import files_beside
from .loading import Job


def line_path(trace: Path) -> Path:
    """Return the file for the line beside a trace.

    >>> line_path(Path("out/run.mcap")).name
    'run.line.mcap'
    """
    return trace.with_name(f"{trace.stem}.line.mcap")


def in_use(job: Job) -> dict[Path, str]:
    """Return the files that a job was loaded from, with what they are."""
    beside = dict.fromkeys(files_beside(job).values(), "a file that the program needs")
    return {**beside, job.program: "the program", job.rack_file: "the rack file"}


def recording_of(job: Job, trace: Path) -> list[Path]:
    """Return the files of a job's recording: its trace, and what the units beside the rack say."""
    return [trace, line_path(trace)] if job.spec.unit else [trace]


def check_recording(job: Job, trace: Path, used: Used = NOTHING) -> None:
    """Refuse a recording that would replace what somebody owns.

    Args:
        job: what is to be recorded.
        trace: where to.
        used: files in use beside those of the job.

    Raises:
        OwnedError: see `check_output`.
    """
    for path in recording_of(job, trace):
        check_output(path, TRACE, {**in_use(job), **used})
