"""Proofs about programs: terms that express a scan, and a solver for claims about any number of scans."""

from __future__ import annotations

TYPE_CHECKING = False  # type checkers assume that it is true

if TYPE_CHECKING:  # type checkers import these lines, `__getattr__` reads them
    from .system import ProgramSystem, ScanBounds


def __getattr__(name: str) -> object:
    from scanrack.io_images.front_door import listed_in

    return listed_in(__spec__, name)
