"""Lines of Python as they are written, with what they use."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from ..model.errors import TooLongError
from ..model.stretches import Spot
from ..model.tags import BASE, FRAME, OWN, FrameLayout, Layout, Leaf
from ..state.lowered import LoweredProgram

INDENT = "    "

MOST_LINES = 120_000
"""Lines of a function: Python takes up to 3 KiB for each while it compiles them."""


class Writer:
    """Collects the lines of one function.

    Attributes:
        lowered: the program.
        layout: where the operands of the routine are: the program's, or that of an add-on instruction.
        called: routines of add-on instructions that are called, each with whether its instance begins
            somewhere in its list.
        lines: text and line of origin.
        written: identifiers that are assigned to.
        inputs: input images that are read.
        origin: line of the present rung in its file.
        flags: whether the status flags are kept.

    Args:
        lowered: see there.
        frame: the add-on instruction in whose instance the operands are, "" for those of the program.
        based: whether the instance begins somewhere in its list.
        routine: the routine, for messages.
    """

    def __init__(
        self, lowered: LoweredProgram, frame: str = "", *, based: bool = False, routine: str = ""
    ) -> None:
        self.lowered = lowered
        self._routine = routine
        self.layout: Layout = lowered.frames[frame].layout if frame else lowered.layout
        self._bits = lowered.frames[frame].bits if frame else set[str]()
        self.called: set[tuple[str, bool]] = set()
        self._based = based
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
        """Let the temporaries of the rung before be free again.

        Raises:
            TooLongError: the function has too many lines.
        """
        self._temporaries = 0
        if len(self.lines) > MOST_LINES:
            text = f"routine {self._routine} compiles to more than {MOST_LINES:,} lines of Python: divide it"
            raise TooLongError(text, self._routine)

    def name(self, leaf: Leaf) -> str:
        """Return the variable of a leaf, or of the list in which it lies."""
        spot = self.layout.spot(leaf)
        if spot is not None:
            return spot.ident
        if leaf.is_image and not self.is_live(leaf):
            self.inputs.add(leaf.ident)
            return f"{leaf.ident}_"
        return leaf.ident

    def is_live(self, leaf: Leaf) -> bool:
        """Whether a leaf is an image that is used itself; inputs that are only read are used as a list."""
        return leaf.is_image and (leaf.output or leaf.ident in self.lowered.written_inputs)

    def assigned(self, leaf: Leaf) -> None:
        """Note that a leaf's variable is assigned to; elements of lists are not."""
        if not leaf.dims and self.layout.spot(leaf) is None:
            self.written.add(leaf.ident)

    def handed(self, root: str) -> list[str]:
        """Return the variables of an instance or of an InOut, by `Leaf.root`."""
        if root == OWN:
            return [FRAME, BASE] if self._based else [FRAME]
        assert isinstance(self.layout, FrameLayout)
        name = self.layout.inouts[root]
        bit = [f"{name}_bit"] if root in self._bits else []
        return [name, f"{name}_at", f"{name}_left", *bit]

    def base(self, leaf: Leaf, spot: Spot) -> str:
        """Return the variable of the offset at which the stretch of a leaf begins, "" for 0."""
        return "" if leaf.root == OWN and not self._based else spot.base

    def mask(self, leaf: Leaf) -> str:
        """Return the variable that says which bit of an integer an InOut is, "" if it is never one."""
        if leaf.root not in self._bits:
            return ""
        return self.handed(leaf.root)[3]

    def left(self, leaf: Leaf) -> str:
        """Return the variable that says how many elements of an InOut are left, "" if it is not an array."""
        if leaf.outer != 1:
            return ""
        return self.handed(leaf.root)[2]


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
