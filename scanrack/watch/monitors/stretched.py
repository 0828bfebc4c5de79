"""What other processes receive of a session: its programs, and stretches of scans."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from scanrack.io_images.memory_layout import MemoryLayout
from scanrack.ladder.debug.forces import Forces
from scanrack.runtime.live.ring import Rows

from ..history.watched_program import Inputs


class SessionProgram(NamedTuple):
    """A program of the session."""

    first: int
    place: str  # folder of a copy of its files
    rack: str  # the rack file in it, `path[:function]`
    program: str  # the program in it, `path[:function]`


class ReplayPackage(NamedTuple):
    """Scans that ran, and an edit."""

    first: int
    values: Mapping[str, Any]  # before the first scan, by identifier
    forces: Forces
    inputs: Sequence[Inputs]  # beside the images
    rows: Rows
    layout: MemoryLayout  # of the rows
    ran: SessionProgram
    rungs: Sequence[tuple[str, int, tuple[str, ...]]]
    tags: Sequence[tuple[str, str, str]]
