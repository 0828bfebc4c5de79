"""Comments that suppress findings.

    self.count / 0  # scanrack: ignore[division-by-zero]     Python: this line
    # scanrack: ignore[never-read, latch-never-cleared]      Python: the next line
    // check: ignore repeated-coil                           rungs: the comment of the rung
    (* check: ignore preset-zero *)                          structured text: this line, or the next one
    // check: ignore unused-tag                              a declaration: this line, or the next one

`all` stands for every rule.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from scanrack.io_images.input_files import read_input
from scanrack.io_images.text_limits import LIMITS, TextKind
from scanrack.ladder import LadderLogic

from ..load.loading import LoadedRack
from .facts import FileLine
from .written import place_at

_PYTHON = re.compile(r"#\s*scanrack:\s*ignore\[([\w\s,-]+)\]", re.IGNORECASE)
_RUNGS = re.compile(r"check:\s*ignore\s+([\w-]+(?:\s*,\s*[\w-]+)*+)", re.IGNORECASE)
_MARKS = ("//", "(*", "/*", "#")
_ALL = "all"


class Suppressions:
    """The suppressions in the files of a program."""

    def __init__(self, job: LoadedRack) -> None:
        self._comments = dict(_comments(job))
        self._files: dict[str, dict[int, frozenset[str]]] = {}

    def ignores(self, rule: str, place: FileLine) -> bool:
        """Whether a comment suppresses a rule at a place."""
        if place.file not in self._files:
            self._files[place.file] = _in_file(place.file)
        suppressed = {*self._files[place.file].get(place.line, ()), *self._comments.get(place, ())}
        return rule in suppressed or _ALL in suppressed


def _comments(job: LoadedRack) -> Iterator[tuple[FileLine, frozenset[str]]]:
    """Yield each rung's line with the rules that its comment suppresses.

    In an export, the comment is not on the same line as the rung.
    """
    if not isinstance(job.logic, LadderLogic):
        return
    for routine in job.logic.routines:
        for rung in routine.rungs:
            names = _names(_RUNGS, rung.comment)
            if names:
                yield place_at(rung.origin, job.program), names


def _in_file(file: str) -> dict[int, frozenset[str]]:
    """Return the suppressed rules by line number in a file."""
    try:
        lines = read_input(Path(file), LIMITS[TextKind.EXPORT].size).decode("utf-8", "replace").splitlines()
    except OSError:
        return {}
    names_by_line: dict[int, frozenset[str]] = {}
    for_next_line: frozenset[str] = frozenset()
    for number, line in enumerate(lines, 1):
        names = for_next_line
        if any(mark in line for mark in _MARKS):
            names |= _names(_PYTHON if file.endswith(".py") else _RUNGS, line)
        if names:
            names_by_line[number] = names
        is_comment = line.strip().startswith(_MARKS)
        for_next_line = names if is_comment else frozenset()
    return names_by_line


def _names(pattern: re.Pattern[str], text: str) -> frozenset[str]:
    rule_names = (name.strip().lower() for listing in pattern.findall(text) for name in listing.split(","))
    return frozenset(filter(None, rule_names))
