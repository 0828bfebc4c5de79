"""The writer of Python lines, and of the names in them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from scanrack.io_images.site import Site

from ..model.errors import TooLongError
from ..model.stretches import Spot
from ..model.tags import BASE, FRAME, OWN, FrameLayout, Layout, Leaf
from ..state.lowered import LoweredLine, LoweredProgram

INDENT = "    "

MOST_LINES = 120_000
"""Maximum lines of a function; Python needs up to 3 KiB per line during compilation."""


class Writer:
    """Collects the lines of one function of a routine.

    Args:
        based: whether the instance has an offset.
    """

    def __init__(
        self, lowered: LoweredProgram, frame: str = "", *, based: bool = False, routine: str = ""
    ) -> None:
        self.lowered = lowered
        self._routine = routine
        self.layout: Layout = lowered.frames[frame].layout if frame else lowered.layout  # of the operands
        self._bits = lowered.frames[frame].bits if frame else set[str]()
        self.called: set[tuple[str, bool]] = set()  # add-on routines; True: with an offset
        self._based = based
        self.lines: list[tuple[str, int]] = []  # text and source line
        self.written: set[str] = set()  # assigned identifiers
        self.inputs: set[str] = set()  # input images that are read
        self.origin = 1  # source line of the current rung
        self.flags = lowered.flags  # whether the status flags are enabled
        self.instructions = 0  # number of instructions so far
        self._texts: dict[str, str] = {}  # see `texts`
        self._texts_of = 0  # number of the instruction after which `_texts` are valid
        self._depth = 1
        self._temporaries = 0  # names since the current rung
        self._lasting = 0  # names of `lasting`

    def line(self, text: str) -> None:
        """Write a line."""
        self.lines.append((INDENT * self._depth + text, self.origin))

    def begin(self, line: LoweredLine) -> None:
        """Begin a rung or a line of structured text: write comment, number and text as Python comments.

        The temporary variables of the previous rung or line can be reused.

        Raises:
            TooLongError: the function has too many lines.
        """
        self.origin = line.origin.line or 1
        self._temporaries = 0
        self._texts.clear()
        if len(self.lines) > MOST_LINES:
            reason = f"routine {self._routine} compiles to more than {MOST_LINES:,} lines of Python"
            raise TooLongError(reason, "divide it", Site(routine=self._routine))
        for text in (*line.comment.splitlines(), *f"{line.number}: {line.text}".splitlines()):
            self.line(f"# {text}")

    @contextmanager
    def block(self, head: str) -> Iterator[None]:
        """Write a block's first line and indent the lines inside; an empty block gets `pass`."""
        self.line(head)
        self._depth += 1
        start = len(self.lines)
        yield
        self.fill(start)
        self._depth -= 1
        self._texts.clear()

    def fill(self, start: int = 0) -> None:
        """Write `pass` if there are only comments since `start`."""
        if all(text.lstrip().startswith("#") for text, _ in self.lines[start:]):
            self.line("pass")

    def texts(self) -> dict[str, str]:
        """Return the variables with the strings that preceding string instructions have stored, by place.

        They are valid in the current block. A variable is None if its instruction stored nothing.
        """
        if self._texts_of != self.instructions - 1:
            self._texts.clear()
        return dict(self._texts)

    def keep_texts(self, texts: dict[str, str]) -> None:
        """Set the result of `texts` for the next instruction."""
        self._texts, self._texts_of = texts, self.instructions

    def temporary(self) -> str:
        """Return a new name."""
        self._temporaries += 1
        return f"__{self._temporaries}"

    def lasting(self) -> str:
        """Return a new name that is unique in all rungs."""
        self._lasting += 1
        return f"__kept_{self._lasting}"

    def name(self, leaf: Leaf) -> str:
        """Return the variable that contains a leaf, its list, or the view of its bytes."""
        spot = self.layout.spot(leaf)
        if spot is not None:
            return spot.variable
        if leaf.is_image and not self.is_live(leaf):
            self.inputs.add(leaf.ident)
            return f"{leaf.ident}_"
        return leaf.ident

    def is_live(self, leaf: Leaf) -> bool:
        """Return whether a leaf is an image used directly; inputs that are only read are copied to a list."""
        return leaf.is_image and (leaf.output or leaf.ident in self.lowered.written_inputs)

    def assigned(self, leaf: Leaf) -> None:
        """Record that a leaf is assigned, unless it is an element of a list."""
        if not leaf.dims and self.layout.spot(leaf) is None:
            self.written.add(leaf.ident)

    def handed(self, root: str) -> list[str]:
        """Return the variables of an instance or an InOut, by `Leaf.root`."""
        if root == OWN:
            return [FRAME, BASE] if self._based else [FRAME]
        assert isinstance(self.layout, FrameLayout)
        name = self.layout.inouts[root]
        bit = [f"{name}_bit"] if root in self._bits else []
        return [name, f"{name}_at", f"{name}_left", *bit]

    def base(self, leaf: Leaf, spot: Spot) -> str:
        """Return text for the start of a stretch in its list or view; "" for 0."""
        return "" if not spot.base or (leaf.root == OWN and not self._based) else spot.begin_text

    def mask(self, leaf: Leaf) -> str:
        """Return the variable with an InOut's bit mask; "" if the InOut is never a bit."""
        if leaf.root not in self._bits:
            return ""
        return self.handed(leaf.root)[3]

    def elements_left(self, leaf: Leaf) -> str:
        """Return the variable with an InOut's number of remaining elements; "" if it is not an array."""
        if leaf.outer != 1:
            return ""
        return self.handed(leaf.root)[2]


def both(a: str, b: str) -> str:
    """Return the conjunction of two conditions."""
    if a == "True" or b == "False":
        return b
    return a if b == "True" or a == "False" else f"{a} and {b}"


def either_of(texts: list[str]) -> str:
    """Return the disjunction of conditions."""
    if "True" in texts:
        return "True"
    live = [text for text in texts if text != "False"]
    if not live:
        return "False"
    return live[0] if len(live) == 1 else f"({' or '.join(live)})"
