"""The times of a program: timer presets, texts such as "50 ms", and compared numbers.

A search uses them as durations of events and as distances between events. Whole numbers in comparisons
(`if age > 20`) count as scans.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Any

from scanrack.io_images.times import parse_duration
from scanrack.ladder.run.engine import Engine
from scanrack.runtime.loop.scan import ScanLogic

from ...record.logic_wrapper import unwrapped
from .python_state import namespace_of

MOST_TIMES = 40
"""Maximum number of times from a program. The shortest times are used."""

MS = 1_000_000

SHORTEST_SCANS = 3
"""Times of at most this many scans are omitted, because random draws hit them anyway."""


def times_of(logic: ScanLogic, scan_ns: int, scans: int) -> tuple[int, ...]:
    """Return the program's times that fit into a run, and the means of neighbors, sorted, in ns."""
    program = unwrapped(logic)
    times_ns = _presets(program) if isinstance(program, Engine) else _times_in_source(program, scan_ns)
    shortest_ns, longest_ns = SHORTEST_SCANS * scan_ns, scans * scan_ns
    fitting_ns = sorted({time_ns for time_ns in times_ns if shortest_ns < time_ns < longest_ns})[:MOST_TIMES]
    between_ns = {(earlier + later) // 2 // scan_ns * scan_ns for earlier, later in pairwise(fitting_ns)}
    return tuple(sorted({*fitting_ns, *between_ns}))


def _presets(engine: Engine) -> Iterator[int]:
    """Yield the current presets of all timers, ns."""
    leaves = engine.lowered.layout.leaves
    for path, leaf in leaves.items():
        if path.endswith(".PRE") and f"{path[:-4]}.TT" in leaves and leaf.ident in engine.memory.cells:
            cell_content: Any = engine.memory.cells[leaf.ident].cell_contents
            values = cell_content if leaf.dims and cell_content is not None else (cell_content,)
            yield from (value * MS for value in values if value.__class__ is int)
    for presets in engine.lowered.defaults.values():
        yield from (int(value) * MS for (path, _), value in presets.items() if path.upper().endswith(".PRE"))


def _times_in_source(logic: ScanLogic, scan_ns: int) -> Iterator[int]:
    """Yield the times in the source code of a Python program, ns."""
    file = namespace_of(logic).get("__file__")
    if isinstance(file, str):
        for scans, time_ns in _times_in_file(file):
            yield scans * scan_ns + time_ns


@lru_cache(maxsize=4)
def _times_in_file(file: str) -> tuple[tuple[int, int], ...]:
    """Return the times in a file as pairs (scans, ns); one of the two is 0."""
    try:
        tree = ast.parse(Path(file).read_text(encoding="utf-8"))
    except (OSError, ValueError, SyntaxError):
        return ()
    return tuple(dict.fromkeys(time for node in ast.walk(tree) for time in _times_at(node)))


def _times_at(node: ast.AST) -> Iterator[tuple[int, int]]:
    """Yield the times in a text or comparison as pairs (scans, ns)."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        try:
            yield 0, parse_duration(node.value)
        except ValueError:
            return
    elif isinstance(node, ast.Compare):
        for comparator in node.comparators:
            value = comparator.value if isinstance(comparator, ast.Constant) else None
            if value.__class__ is int:
                yield int(value), 0
            elif value.__class__ is float:
                yield 0, int(value * 1e9)
