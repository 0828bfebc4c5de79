"""Loads a rack and adds a test routine to its program, see `ladder.files.testfile`."""

from __future__ import annotations

from dataclasses import replace

from scanrack.ladder.files.testfile import TestFile, with_test
from scanrack.ladder.model.errors import LadderError

from .loading import LoadedRack, load_rack
from .rungs import is_rungs


def load_test(file: TestFile, routine: str) -> tuple[LoadedRack, str]:
    """Return the job of a test routine, and the routine's full name.

    Raises:
        ValueError: the rack, program or test can't be used, or the program is in Python.
    """
    job = load_rack(file.rack)
    if not is_rungs(job.logic):
        raise LadderError(f"{job.program}: the program is in Python: a test routine needs rungs")
    program, name = with_test(job.logic, file, routine)
    return replace(load_rack(file.rack, program), tested=job), name
