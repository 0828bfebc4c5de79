"""The times of a program: presets of its timers, texts such as "50 ms", numbers that it compares.

They are used as waiting times of operators. Numbers that a program compares (`if age > 20`) count as scans.
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
"""Largest number of times of a program; the shortest are kept."""

MS = 1_000_000

SHORTEST_SCANS = 3
"""Shorter times, in scans, are left out: random draws hit them anyway."""


def times_of(logic: ScanLogic, scan_ns: int, scans: int) -> tuple[int, ...]:
    """Return the program's times that fit into a run, and times between two of them; sorted, ns."""
    program = unwrapped(logic)
    times = set(_presets(program)) if isinstance(program, Engine) else set(_written(program, scan_ns))
    fitting = sorted(time_ns for time_ns in times if SHORTEST_SCANS * scan_ns < time_ns < scans * scan_ns)[
        :MOST_TIMES
    ]
    between = {(earlier + later) // 2 // scan_ns * scan_ns for earlier, later in pairwise(fitting)}
    return tuple(sorted({*fitting, *between}))


def _presets(engine: Engine) -> Iterator[int]:
    """Yield the current presets of all timers, ns."""
    leaves = engine.lowered.layout.leaves
    for path, leaf in leaves.items():
        if path.endswith(".PRE") and f"{path[:-4]}.TT" in leaves and leaf.ident in engine.memory.cells:
            content: Any = engine.memory.cells[leaf.ident].cell_contents
            values = content if leaf.dims and content is not None else (content,)
            yield from (value * MS for value in values if value.__class__ is int)
    for presets in engine.lowered.defaults.values():
        yield from (int(value) * MS for (path, _), value in presets.items() if path.upper().endswith(".PRE"))


def _written(logic: ScanLogic, scan_ns: int) -> Iterator[int]:
    """Yield the times in the text of a Python program."""
    file = namespace_of(logic).get("__file__")
    if isinstance(file, str):
        for scans, ns in _read(file):
            yield scans * scan_ns + ns


@lru_cache(maxsize=4)
def _read(file: str) -> tuple[tuple[int, int], ...]:
    """Return the times in a file: first those in scans, then those in ns."""
    try:
        tree = ast.parse(Path(file).read_text(encoding="utf-8"))
    except (OSError, ValueError, SyntaxError):
        return ()
    return tuple(dict.fromkeys(time for node in ast.walk(tree) for time in _times_at(node)))


def _times_at(node: ast.AST) -> Iterator[tuple[int, int]]:
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
