"""Lines of Python as they are written, with what they use."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from ..lowered import Lowered
from ..tags import Leaf

INDENT = "    "


class Writer:
    """Collects the lines of one function.

    Attributes:
        lowered: the program.
        lines: text and line of origin.
        written: identifiers that are assigned to.
        inputs: input images that are read.
        origin: line of the present rung in its file.
        flags: whether the status flags are kept.
    """

    def __init__(self, lowered: Lowered) -> None:
        self.lowered = lowered
        self.lines: list[tuple[str, int]] = []
        self.written: set[str] = set()
        self.inputs: set[str] = set()
        self.origin = 1
        self.flags = lowered.flags
        self._depth = 1
        self._temporaries = 0
        self._lasting = 0

    def line(self, text: str) -> None:
        """Write a line."""
        self.lines.append((INDENT * self._depth + text, self.origin))

    def comment(self, text: str) -> None:
        """Write a comment."""
        for each in text.splitlines():
            self.line(f"# {each}")

    @contextmanager
    def block(self, head: str) -> Iterator[None]:
        """Write a head and indent what is written inside; an empty block passes."""
        self.line(head)
        self._depth += 1
        start = len(self.lines)
        yield
        self.fill(start)
        self._depth -= 1

    def fill(self, start: int = 0) -> None:
        """Pass, if nothing but comments has been written since."""
        if all(text.lstrip().startswith("#") for text, _ in self.lines[start:]):
            self.line("pass")

    def temporary(self) -> str:
        """Return a name that nothing else has."""
        self._temporaries += 1
        return f"__{self._temporaries}"

    def lasting(self) -> str:
        """Return a name that nothing else has, in this rung or another."""
        self._lasting += 1
        return f"__kept_{self._lasting}"

    def next_rung(self) -> None:
        """Temporaries of the rung before are free again."""
        self._temporaries = 0

    def name(self, leaf: Leaf) -> str:
        """Return the variable of a leaf."""
        if leaf.is_image and not leaf.output:
            self.inputs.add(leaf.ident)
            return f"{leaf.ident}_"
        return leaf.ident

    def assigned(self, leaf: Leaf) -> None:
        """Note that a leaf's variable is assigned to; elements of arrays are not."""
        if not leaf.dims:
            self.written.add(leaf.ident)


def both(a: str, b: str) -> str:
    """Return the text of a condition that holds when both do."""
    if a == "True" or b == "False":
        return b
    return a if b == "True" or a == "False" else f"{a} and {b}"


def either_of(texts: list[str]) -> str:
    """Return the text of a condition that holds when one of them does."""
    if "True" in texts:
        return "True"
    live = [each for each in texts if each != "False"]
    if not live:
        return "False"
    return live[0] if len(live) == 1 else f"({' or '.join(live)})"
