"""The files of a loaded rack, which no output may replace, and the paths of its recording."""

from __future__ import annotations

from pathlib import Path

from scanrack.traces.files.guard import NOTHING, Used
from scanrack.traces.files.keeping import RecordingKeeper, check_recordings

from ..load.loading import LoadedRack
from .attachments import files_beside


def line_path(trace: Path) -> Path:
    """Return the path of the serial line's recording beside a trace.

    >>> line_path(Path("out/run.mcap")).name
    'run.line.mcap'
    """
    return trace.with_name(f"{trace.stem}.line.mcap")


def in_use(job: LoadedRack) -> dict[Path, str]:
    """Return the files of a loaded rack, each with its role."""
    beside = dict.fromkeys(files_beside(job).values(), "a file that the program needs")
    return {**beside, job.program: "the program", job.rack_file: "the rack file"}


def recording_of(job: LoadedRack, trace: Path) -> list[Path]:
    """Return the files of a recording: the trace, and the recording of the serial line if there is one."""
    return [trace, line_path(trace)] if job.spec.unit else [trace]


def keeping_of(job: LoadedRack, trace: Path, keep: int | None = None) -> RecordingKeeper | None:
    """Return the keeper of earlier recordings; None if they are replaced.

    Args:
        keep: number of recordings to keep; None = as in the rack file.
    """
    most = job.spec.keep_traces if keep is None else keep
    return RecordingKeeper(trace, most, recording_of(job, trace)[1:]) if most else None


def check_recording(job: LoadedRack, trace: Path, used: Used = NOTHING, keep: int | None = None) -> None:
    """Check that a recording would not replace a file that is not a recording, or move a file in use.

    Args:
        used: files in use besides the files of the rack.
        keep: see `keeping_of`.

    Raises:
        OwnedError: see `check_output`.
    """
    check_recordings(recording_of(job, trace), keeping_of(job, trace, keep), {**in_use(job), **used})


def names_of(job: LoadedRack, trace: Path, keep: int | None = None) -> list[Path]:
    """Return the files of a recording and of the kept recordings; for arguments, see `check_recording`."""
    keeping = keeping_of(job, trace, keep)
    return recording_of(job, trace) + ([] if keeping is None else keeping.names())
