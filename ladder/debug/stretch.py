"""Records of scans to repeat: external inputs, and stretches between two snapshots."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from ..model.tags import Leaf
from ..state.memory import Value
from .forces import Forces

Write = tuple[Leaf, int, Value]
"""A value that was set from outside the program."""


class ScanInputs(NamedTuple):
    """The external inputs of a scan."""

    now_ns: int
    first: bool  # whether the scan begins with prescan
    images: Sequence[bytes] | None  # images in layout order; None if the program does not run
    writes: tuple[Write, ...] = ()
    forces: Forces | None = None  # None: unchanged forces and no external writes

    @property
    def is_plain(self) -> bool:
        """Whether images were the only inputs."""
        return not (self.first or self.writes or self.forces)


class PlainInputs(NamedTuple):
    """The inputs of consecutive scans that have only images, as arrays with a row per scan."""

    times: Any  # ns
    images: Sequence[Any]  # for each image in layout order, its words by scan


class ReplayStretch(NamedTuple):
    """The scans from one snapshot to the next."""

    first: int
    last: int
    values: Mapping[str, Any]  # the values before the first scan, by identifier
    inputs: PlainInputs | None  # None if there were other inputs than images, or if they are not known
    after: Mapping[str, Any]  # the values after the last scan
