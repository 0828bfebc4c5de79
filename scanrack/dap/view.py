"""The scan in view, and the tree of its values that a client browses."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import islice
from typing import Any, NamedTuple, Protocol

from scanrack.ladder.debug.executed import StepRun
from scanrack.ladder.debug.watched import shown
from scanrack.ladder.model.tree import Origin

from .conditions import Values
from .protocol import DebugError, Json

ITEMS_MOST = 1_000
"""Maximum number of values sent for a level if the client does not select a range."""


Node = Callable[[], Iterable[Json]]
"""A node of the tree: returns its values as protocol objects, with a `node` for each value with members."""


class Tree:
    """The nodes that the client has opened, by number; valid until the program continues.

    Args:
        view: the scan in view.
        forced: the names of forced tags.
    """

    def __init__(self, view: View, forced: Sequence[str]) -> None:
        self.view = view
        self._forced = {name.upper() for name in forced}
        self._nodes: dict[int, Node] = {}

    def add(self, node: Node) -> int:
        """Add a node and return its number."""
        self._nodes[len(self._nodes) + 1] = node
        return len(self._nodes)

    def node(self, number: int) -> Node:
        """Return a node by its number; raise DebugError if the number is from an earlier stop."""
        if number not in self._nodes:
            raise DebugError(f"variables {number}: no longer exist, since the program has continued")
        return self._nodes[number]

    def variables(self, number: int, start: int = 0, count: int = 0) -> list[Json]:
        """Return the values of a node; `count` 0 = all, up to a limit."""
        values = islice(self.node(number)(), start, start + (count or ITEMS_MOST))
        return [self._with_reference(value) for value in values]

    def tag(self, number: int, name: str) -> str:
        """Return the tag or address of one of a node's values; raise DebugError if it can't be set."""
        variable = next((row for row in self.node(number)() if row["name"] == name), None)
        if variable is None:
            raise DebugError(f"no value {name!r}")
        if variable["type"] == "module":
            raise DebugError(f"{name} is a module: set one of its words or bits")
        if "evaluateName" not in variable:
            raise DebugError(f"{name} is a local value of a past scan: set a value of the program")
        tag: str = variable["evaluateName"]
        return tag

    def _with_reference(self, child: Json) -> Json:
        node = child.pop("node", None)
        return {**child, "variablesReference": 0 if node is None else self.add(node)}

    def value(self, name: str, address: str) -> Json:
        """Return a tag as a protocol object with a short name."""
        return self.view.value(self, name, address)

    def text(self, address: str, value: object) -> str:
        """Return a plain value as text."""
        text = repr(value) if isinstance(value, str) else shown(value)
        return f"{text} (forced)" if address.upper() in self._forced else text


class Stop(NamedTuple):
    """A place before an instruction in a scan."""

    order: int  # writes after this index have not happened yet
    run: Any  # a LineRun; a TextRun of a language without rungs
    step: StepRun | None  # None before the first instruction of a rung
    depth: int  # calls around it


class View(Protocol):
    """The scan in view, in any language.

    Attributes:
        scan: number of the scan.
        tags: the values at the current place, by name.
        values: the values that expressions read.
    """

    scan: int
    tags: Any
    values: Values

    @property
    def stops(self) -> Sequence[Stop]:
        """The places before rungs, instructions or lines, in the order of execution."""

    def show(self, order: int | None) -> None:
        """Show the values after an instruction; None = at the end of the scan."""

    def set(self, tag: str, value: object) -> None:
        """Show a value that was set after the scan, until another place is shown."""

    def leave(self) -> None:
        """Release the replayer."""
        return

    def last_write(self, tag: str) -> tuple[int, int | None] | None:
        """Return the index and order of the place after a tag's last change; None if there is none."""

    def frame(self, run: Any) -> str:
        """Return the name of the frame of a rung or line."""

    def task(self, run: Any) -> str:
        """Return the task of a rung; "" if it has none."""
        return ""

    def last_origin(self) -> Origin | None:
        """Return the place that is shown at the end of the scan; None if there is none."""

    def full_name(self, name: str, run: Any) -> str | None:
        """Return the full name of a tag from its name in a rung or line; None for other names."""

    def names(self, run: Any) -> Sequence[tuple[str, str]]:
        """Return the short and full names of all tags that a rung or line can name."""

    def scopes(self, tree: Tree, run: Any) -> Iterator[tuple[str, Node]]:
        """Yield the scopes of a frame; `run` is None outside of rungs."""

    def value(self, tree: Tree, name: str, address: str) -> Json:
        """Return a value as a protocol object with a short name."""

    def described(self, tag: str) -> Iterator[str]:
        """Yield the texts that a hover over a tag shows in addition to its value."""
        return iter(())

    def own_word(self, slot: int, image: str, number: int) -> int | None:
        """Return a word of the program's image at the current place; None if there is no such image."""
        return None
