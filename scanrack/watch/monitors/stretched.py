"""Data of a session for other processes: its programs, and stretches of scans."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from scanrack.io_images.memory_layout import MemoryLayout
from scanrack.ladder.debug.forces import Forces
from scanrack.runtime.live.ring import Rows

from ..history.watched_program import Inputs


class SessionProgram(NamedTuple):
    """A program of a session, as a copy on disk."""

    first: int
    place: str  # folder with a copy of its files
    rack: str  # the rack file in the folder, `path[:function]`
    program: str  # the program in the folder, `path[:function]`


class ReplayPackage(NamedTuple):
    """Recorded scans, and an edit to try on them."""

    first: int
    values: Mapping[str, Any]  # values before the first scan, by variable identifier
    forces: Forces
    inputs: Sequence[Inputs]  # inputs in addition to the images
    rows: Rows
    layout: MemoryLayout  # layout of the rows
    ran: SessionProgram  # the program that ran
    rungs: Sequence[tuple[str, int, tuple[str, ...]]]  # edited rungs, see `actions.Online`
    tags: Sequence[tuple[str, str, str]]  # new tags, see `actions.Online`
