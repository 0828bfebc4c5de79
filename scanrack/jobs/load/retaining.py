"""Loads the final tag values of an earlier run into a ladder program.

The trace contains the file of tags, so that a rerun also starts with them.
"""

from __future__ import annotations

from dataclasses import replace

from scanrack.ladder.model.errors import LadderError

from .loading import LoadedRack
from .rungs import is_rungs


def retaining(job: LoadedRack, data: bytes, name: str) -> tuple[LoadedRack, list[str]]:
    """Load retained tags into a job's ladder program; return the job, and a sentence for each ignored tag.

    Args:
        job: job whose program has not run a scan yet.

    Raises:
        ValueError: the data are not a file of retained tags, or the program is a Python function.
    """
    if not is_rungs(job.logic):
        raise ValueError(f"{name}: the program is a Python function; it has no tags to retain")
    from scanrack.ladder.run.edit import retain

    try:
        notes = retain(job.logic.engine, data.decode("utf-8"))
    except UnicodeDecodeError as error:
        raise ValueError(f"{name}: the retained tags can't be read: {error}") from None
    except LadderError as error:
        raise ValueError(f"{name}: {error}") from None
    return replace(job, retained=data), notes
