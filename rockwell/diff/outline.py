"""An export as items (programs, routines, tags, types, modules) with fields, steps and inner items.

    item       noun, name, line
      fields     label and text
      details    label and text: radixes, and the same values in another form; only shown if no field differs
      steps      rungs, lines of structured text, or elements of a chart, in order
      items      inner items, in order

Outlines may contain common content of both versions without reading it, see `CommonPart`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import TypeAlias

RUNG, LINE, ELEMENT = "rung", "line", "element"

Field: TypeAlias = tuple[str, str]
"""A label and its text."""


@dataclass(frozen=True, slots=True)
class Step:
    """A rung, a line of structured text, or an element of a chart or a diagram."""

    noun: str  # `rung`, `line` or `element`
    number: int  # rungs count from 0, lines from 1
    text: str
    key: str  # the text without blanks; steps with equal keys are the same
    comment: str
    line: int
    name: str = ""  # the name by which connections refer to an element
    layout: str = ""  # its place on a sheet, or its blanks, which do not count as differences

    def lines(self) -> Iterator[str]:
        """Yield the comment, each line after `//`, and the text."""
        yield from (f"// {line}" for line in self.comment.splitlines())
        yield from self.text.splitlines()


@dataclass(slots=True)
class Item:
    """A named part of an export."""

    noun: str  # "program", "routine", "tag", …
    name: str
    line: int
    fields: list[Field] = field(default_factory=list)
    details: list[Field] = field(default_factory=list)
    # dates, authors and options of the export, which do not count as differences
    dates: list[Field] = field(default_factory=list)
    steps: list[Step] = field(default_factory=list)
    items: list[Item | CommonPart] = field(default_factory=list)

    @property
    def key(self) -> tuple[str, str]:
        """Its noun, and its name in capitals; items with the same key in both versions correspond."""
        return self.noun, self.name.upper()

    def opened(self) -> Iterator[Item]:
        """Yield the inner items, including the ones in common parts."""
        for item in self.items:
            yield from item.open() if isinstance(item, CommonPart) else (item,)

    def lines(self, *, steps: bool = True) -> Iterator[str]:
        """Yield fields as lines, then steps if `steps` is set."""
        for label, text in self.fields:
            yield from f"{label} = {text}".splitlines()
        if steps:
            yield from (line for step in self.steps for line in step.lines())


@dataclass(frozen=True, slots=True)
class CommonPart:
    """Items that both versions have in the same order, byte for byte."""

    noun: str  # of the first item
    content: bytes
    line: int
    read: Callable[[bytes, int], list[Item]]  # reads items from the content and the line

    def open(self) -> list[Item]:
        """Read the items."""
        return self.read(self.content, self.line)


OWNERLESS = frozenset(("export", "controller"))
"""Items that are not in paths: `Main, Start` is a tag of program Main, `Start` a controller tag."""


def path_of(owner: str, item: Item) -> str:
    """Return the path of an item: its owner and its name; "" for the whole export."""
    if item.noun in OWNERLESS:
        return ""
    return ", ".join(filter(None, (owner, item.name)))


def canonical_lines(item: Item, owner: str = "", *, steps: bool = True) -> Iterator[str]:
    """Yield an outline as text for git, without order and dates, and with steps if `steps` is set."""
    path = path_of(owner, item)
    yield " ".join(filter(None, (item.noun, path)))
    yield from (f"  {line}" for line in item.lines(steps=steps))
    for inner in sorted(item.opened(), key=lambda inner: inner.key):
        yield from canonical_lines(inner, path, steps=steps)
