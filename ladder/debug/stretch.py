"""Scans to repeat: what came in from outside of the program, and the scans between two snapshots."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from ..model.tags import Leaf
from ..state.memory import Value
from .forces import Forces

Write = tuple[Leaf, int, Value]
"""A value set from outside of the program."""


class ScanInputs(NamedTuple):
    """The external inputs of a scan."""

    now_ns: int
    first: bool  # whether it begins with prescan
    images: Sequence[bytes] | None  # in layout order; None = the program does not run
    writes: tuple[Write, ...] = ()
    forces: Forces | None = None  # None = as before, without external writes

    @property
    def is_plain(self) -> bool:
        """Whether nothing came in but images."""
        return not (self.first or self.writes or self.forces)


class PlainInputs(NamedTuple):
    """The inputs of successive scans whose only inputs are images, as arrays with a row per scan."""

    times: Any  # ns
    images: Sequence[Any]  # words by scan, of each image in layout order


class ReplayStretch(NamedTuple):
    """Scans from a snapshot to the next one."""

    first: int
    last: int
    values: Mapping[str, Any]  # before the first scan, by identifier
    inputs: PlainInputs | None  # None if something came from outside, or if they are not known
    after: Mapping[str, Any]  # the values after the last one
