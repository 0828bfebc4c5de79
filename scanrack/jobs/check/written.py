"""Writes to the output words of a 3601: their lines and their values."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple, Protocol

from scanrack.io_images.input_files import read_input
from scanrack.io_images.text_limits import LIMITS, TextKind

from .choices import Choices
from .logic import TRUE, Condition

Step = float | str
"""A step of a program: a number or a text."""


class FileLine(NamedTuple):
    """A line of a file, numbered from 1."""

    file: str
    line: int


class _Site(Protocol):
    @property
    def file(self) -> str: ...

    @property
    def line(self) -> int | None: ...


def place_at(site: _Site, file: str | Path) -> FileLine:
    """Return the file and line of a site; use `file` and line 1 for a missing file or line."""
    return FileLine(site.file or str(file), site.line or 1)


def declaration_lines(path: Path) -> Callable[[str], int]:
    """Return a function that finds the line that declares a tag; the line is 1 if there is no declaration."""
    lines: dict[str, int] = {}
    text = read_input(path, LIMITS[TextKind.EXPORT].size).decode("utf-8", "replace")
    for number, line in enumerate(text.splitlines(), 1):
        for word in re.findall(r"\w+", line.partition("//")[0]):
            lines.setdefault(word.upper(), number)
    return lambda name: lines.get(name.rpartition(".")[2].upper(), 1)


@dataclass(frozen=True, slots=True)
class WordWrite:
    """A write to an output word of a 3601.

    Attributes:
        word: 0 to 7.
        value: the value of a whole word, signed; None for bits.
        sets: bits that it sets when it happens.
        clears: bits that it may clear.
        when: the condition under which it happens.
        steps: by machine, the steps in which it may happen (None for all), and whether it happens in each
            scan of those steps.
        text: the instruction or statement as text.
    """

    place: FileLine
    slot: int
    word: int
    value: Choices | None = None
    sets: int = 0
    clears: int = 0
    when: Condition = TRUE
    steps: Mapping[str, tuple[frozenset[Step] | None, bool]] = field(default_factory=dict)
    text: str = ""

    @property
    def options(self) -> tuple[int, ...]:
        """The possible values of the word; for bits, the bits that are set."""
        return (self.sets,) if self.value is None else self.value.options

    def acts_in(self, machine: str, step: Step) -> tuple[bool, bool]:
        """Return whether it may happen in a step, and whether it happens in each scan of that step."""
        steps, sure = self.steps.get(machine, (None, self.when == TRUE))
        return steps is None or step in steps, sure
