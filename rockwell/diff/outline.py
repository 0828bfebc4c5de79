"""An export as items: programs, routines, tags, types, modules, each with fields, steps and inner items.

    item       what, name, line
      fields     label and text: shown to a reader
      details    label and text: radixes, and the same values in another form; only shown if no field differs
      steps      rungs, lines of structured text, or elements of a chart, in order
      items      inner items, in order

Content that both versions have may be left out of both outlines, see `CommonPart`.
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

    what: str  # `rung`, `line` or `element`
    number: int  # rungs count from 0, lines from 1
    text: str
    key: str  # the text without blanks: two steps with equal keys are the same
    comment: str
    line: int
    name: str = ""  # the name by which connections refer to an element
    layout: str = ""  # its place on a sheet, or its blanks: these are no difference

    def lines(self) -> Iterator[str]:
        """Yield the comment, each line after `//`, and the text."""
        yield from (f"// {line}" for line in self.comment.splitlines())
        yield from self.text.splitlines()


@dataclass(slots=True)
class Item:
    """A named part of an export."""

    what: str  # "program", "routine", "tag", …
    name: str
    line: int
    fields: list[Field] = field(default_factory=list)
    details: list[Field] = field(default_factory=list)
    dates: list[Field] = field(
        default_factory=list
    )  # dates, authors and options of the export: these are no difference
    steps: list[Step] = field(default_factory=list)
    items: list[Item | CommonPart] = field(default_factory=list)

    @property
    def key(self) -> tuple[str, str]:
        """Kind and name: an item of the other version with the same key is its counterpart."""
        return self.what, self.name.upper()

    def opened(self) -> Iterator[Item]:
        """Yield the inner items, including shared ones."""
        for item in self.items:
            yield from item.open() if isinstance(item, CommonPart) else (item,)

    def lines(self, *, steps: bool = True) -> Iterator[str]:
        """Yield fields as lines, then steps unless left out."""
        for label, text in self.fields:
            yield from f"{label} = {text}".splitlines()
        if steps:
            yield from (line for step in self.steps for line in step.lines())


@dataclass(frozen=True, slots=True)
class CommonPart:
    """Items that both versions have in this order, byte for byte; their content is the key."""

    what: str  # of the first one
    content: bytes
    line: int
    read: Callable[[bytes, int], list[Item]]

    def open(self) -> list[Item]:
        """Read the items."""
        return self.read(self.content, self.line)


OWNERLESS = frozenset(("export", "controller"))
"""Items without a place: `Main, Start` is a tag of program Main, `Start` one of the controller."""


def place_of(owner: str, item: Item) -> str:
    """Return the place of an item: its owner and its name."""
    if item.what in OWNERLESS:
        return ""
    return ", ".join(filter(None, (owner, item.name)))


def canonical_lines(item: Item, owner: str = "", *, steps: bool = True) -> Iterator[str]:
    """Yield an outline as text for git, independent of order and dates; steps only if `steps` is set."""
    place = place_of(owner, item)
    yield " ".join(filter(None, (item.what, place)))
    yield from (f"  {line}" for line in item.lines(steps=steps))
    for part in sorted(item.opened(), key=lambda inner: inner.key):
        yield from canonical_lines(part, place, steps=steps)
