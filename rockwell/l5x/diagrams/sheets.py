"""The sheets of a function block diagram: elements, wires between them, and the order of the blocks.

    IRef -- Wire --> Block, Function, AddOnInstruction -- Wire --> ORef
    an OCon and an ICon with the same name join wires across sheets; an OCon may have several ICons

A block runs after the blocks that are wired to its inputs. A wire with the Assume Data Available indicator
(in an export a FeedbackWire) has the value of the previous execution. So does a wire from a block to itself.
A loop of several blocks without a feedback wire has no order, as in Studio 5000 [1756-RM003, Function Block
Attributes, Order of Execution and Resolve a Loop; 1756-PM009, Program a Function Block Diagram].

The manual says that the order of blocks that are not wired together does not matter. It does matter if they
use the same tag. Interpretation: these blocks run sheet by sheet, from left to right, then from top to
bottom.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from heapq import heapify, heappop, heappush
from typing import NamedTuple

from scanrack.io_images.site import Site
from scanrack.ladder.model.errors import LadderError

from ..xml.elements import number_of
from ..xml.records import ElementRecord

RUN = ("Block", "Function", "AddOnInstruction", "JSR", "SBR", "RET")
"""Elements that run."""

_NODES = (*RUN, "IRef", "ORef", "ICon", "OCon")
_WIRES = ("Wire", "FeedbackWire")
_REMARKS = ("TextBox", "Attachment", "Description")
_RANKS = {"SBR": 0, "RET": 2}
"""Order of elements that could run at the same time; 1 for all others."""

MOST_ELEMENTS = 20_000
"""Maximum number of elements and wires in a routine."""

Key = tuple[int, int]
"""Sheet, from 1, and ID of an element."""


class DiagramError(LadderError):
    """The diagram can't run; the error's site has the line."""


@dataclass(frozen=True, slots=True)
class Pin:
    """An output of an element; `name` is "" for an IRef."""

    node: Node
    name: str


@dataclass(frozen=True, slots=True, eq=False)
class Node:
    """An element of a sheet."""

    key: Key
    record: ElementRecord

    @property
    def tag(self) -> str:
        """Its kind, for example `IRef` or `Block`."""
        return self.record.tag

    @property
    def type(self) -> str:
        """Its instruction or routine; "" for a reference or connector."""
        get = self.record.attributes.get
        return (get("Type") or get("Name") or get("Routine") or "") if self.tag in RUN else ""

    @property
    def operand(self) -> str:
        """Its tag, address or number; "" if it has none."""
        return self.record.attributes.get("Operand", "").strip()

    @property
    def place(self) -> str:
        """Its place, for messages."""
        sheet, number = self.key
        name = self.operand
        if not name and self.tag in ("ICon", "OCon"):
            name = self.record.attributes.get("Name", "")
        return f"sheet {sheet}, {self.type or self.tag} {name or f'with ID {number}'}"

    @property
    def position(self) -> tuple[int, int, int, int]:
        """Its place in the order of blocks that are not wired together: sheet, X, Y, ID."""
        x, y = (int(number_of(self.record.attributes.get(name, "")) or 0) for name in "XY")
        sheet, number = self.key
        return sheet, x, y, number

    def refused(self, text: str) -> DiagramError:
        """Return the error for this element."""
        return DiagramError(f"{self.place}: {text}", Site(line=self.record.line))


@dataclass(frozen=True, slots=True)
class Input:
    """A wired input."""

    name: str  # of the pin; "" for an ORef
    source: Pin
    feedback: bool  # whether it has the value of the previous execution
    through: Node | None = None  # the input connector at the end of its wire


@dataclass(frozen=True, slots=True)
class _Wire:
    pin: str  # of its target, as written
    source: Key  # the element at its beginning, which may be a connector
    output: str  # the pin of the source
    feedback: bool


class _Source(NamedTuple):
    """The output at the beginning of a chain of connectors."""

    key: Key
    pin: str
    feedback: bool  # whether a wire of the chain is a feedback wire


class Diagram:
    """The elements of a routine, with their inputs."""

    def __init__(self, content: ElementRecord) -> None:
        """Read the sheets; find the source of each wired input, and the references that read it."""
        self.nodes: dict[Key, Node] = {}
        self.sheets: dict[int, ElementRecord] = {}
        self._wires: dict[Key, dict[str, _Wire]] = {}  # by target and pin in capitals
        self._connectors: dict[str, Node] = {}
        self._sources: dict[Key, _Source] = {}  # by input connector, so that each chain is followed once
        self._read_sheets(content)
        self.inputs: Mapping[Key, tuple[Input, ...]] = {
            key: tuple(self._input(key, wire) for wire in wires.values())
            for key, wires in self._wires.items()
        }
        self._readers: dict[Key, list[tuple[Node, Input]]] = {}  # by source
        for reference in sorted(self._nodes("ORef"), key=lambda node: node.position):
            for wire in self.inputs_of(reference):
                self._readers.setdefault(wire.source.node.key, []).append((reference, wire))

    def _read_sheets(self, content: ElementRecord) -> None:
        """Read the elements of all sheets, then their wires; raise a DiagramError for a repeated number."""
        sheets = [child for child in content.children if child.tag == "Sheet"]
        if sum(1 + len(page.children) for page in sheets) > MOST_ELEMENTS:
            raise DiagramError(f"it has more than {MOST_ELEMENTS:,} elements", Site(line=content.line))
        for position, sheet in enumerate(sheets, start=1):
            number = number_of(sheet.attributes.get("Number", "")) or position
            if self.sheets.setdefault(number, sheet) is not sheet:
                raise DiagramError(f"it has two sheets {number}", Site(line=sheet.line))
            for child in sheet.children:
                self._node(number, child)
            for child in wires_of(sheet):
                self._wire(number, child)

    def _node(self, sheet: int, record: ElementRecord) -> None:
        """Add an element; ignore wires and remarks. Raise a DiagramError if it is unknown or ambiguous."""
        if record.tag in (*_WIRES, *_REMARKS):
            return
        number = number_of(record.attributes.get("ID", ""))
        node = Node((sheet, -1 if number is None else number), record)
        if record.tag not in _NODES:
            raise node.refused(f"elements are {', '.join(_NODES)}")
        if number is None or node.key in self.nodes:
            raise node.refused("its ID is missing, or another element has it")
        self.nodes[node.key] = node
        if record.tag == "OCon":
            name = record.attributes.get("Name", "").upper()
            if self._connectors.setdefault(name, node) is not node:
                raise node.refused("another output connector has this name")

    def _wire(self, sheet: int, record: ElementRecord) -> None:
        """Add a wire; raise a DiagramError for a missing end or pin, and for a second wire to an input."""
        source, target = (self._end(sheet, record.attributes.get(name, "")) for name in ("FromID", "ToID"))
        if source is None or target is None:
            text = f"sheet {sheet}: a wire leads to an element that does not exist"
            raise DiagramError(text, Site(line=record.line))
        pin = pin_of(record, "ToParam", target)
        wired_pins = self._wires.setdefault(target.key, {})
        if pin.upper() in wired_pins:
            raise target.refused(f"two wires lead to its input {pin}".rstrip())
        name = pin_of(record, "FromParam", source)
        if (target.tag in RUN and not pin) or (source.tag in RUN and not name):
            raise target.refused("a wire to it names no pin")
        wired_pins[pin.upper()] = _Wire(pin, source.key, name, record.tag == "FeedbackWire")

    def _end(self, sheet: int, number: str) -> Node | None:
        """Return the element with an ID on a sheet; None if the sheet has no such element."""
        node_number = number_of(number)
        return None if node_number is None else self.nodes.get((sheet, node_number))

    def _input(self, key: Key, wire: _Wire) -> Input:
        """Return a wired input, with its source traced through connectors."""
        neighbor = self.nodes[wire.source]
        source = self._behind_connectors(wire.source, wire.output)
        node = self.nodes[source.key]
        if node.tag in ("ORef", "OCon"):
            raise node.refused("a wire leaves it, and it has no output")
        # a block that is wired to itself needs no indicator
        feedback = wire.feedback or source.feedback or source.key == key
        through = neighbor if neighbor.tag == "ICon" else None
        return Input(wire.pin, Pin(node, source.pin), feedback, through)

    def _behind_connectors(self, key: Key, pin: str) -> _Source:
        """Follow input connectors backward to an element's output."""
        visited: dict[Key, bool] = {}  # whether a feedback wire leads to the connector
        while self.nodes[key].tag == "ICon" and key not in self._sources:
            node = self.nodes[key]
            connector = self._connectors.get(node.record.attributes.get("Name", "").upper())
            if connector is None or not self._wires.get(connector.key) or key in visited:
                raise node.refused("nothing is wired to its output connector")
            wire = self._wires[connector.key][""]
            visited[key] = wire.feedback
            key, pin = wire.source, wire.output
        source = self._sources.get(key, _Source(key, pin, feedback=False))
        for connector_key, feedback in reversed(visited.items()):
            source = source._replace(feedback=source.feedback or feedback)
            self._sources[connector_key] = source
        return source

    def inputs_of(self, node: Node) -> tuple[Input, ...]:
        """Return the wired inputs of an element."""
        return self.inputs.get(node.key, ())

    def readers(self, node: Node) -> Sequence[tuple[Node, Input]]:
        """Return the output references that receive a value of a node, in order of position."""
        return self._readers.get(node.key, ())

    def _nodes(self, *tags: str) -> Iterator[Node]:
        return (node for node in self.nodes.values() if node.tag in tags)

    def in_order(self) -> list[Node]:
        """Return the elements that run, in order of execution: SBR first, RET last.

        Raises:
            DiagramError: a loop has no order.
        """
        blocks = {node.key: node for node in self._nodes(*RUN)}
        waits = {
            key: {wire.source.node.key for wire in self.inputs_of(node) if not wire.feedback} & blocks.keys()
            for key, node in blocks.items()
        }
        followers = _followers(waits)
        ranks = {key: (_RANKS.get(node.tag, 1), node.position, key) for key, node in blocks.items()}
        ready = [ranks[key] for key in blocks if not waits[key]]
        heapify(ready)
        ordered: list[Node] = []
        while ready:
            key = heappop(ready)[-1]
            ordered.append(blocks[key])
            for follower in followers.get(key, ()):
                waits[follower].discard(key)
                if not waits[follower]:
                    heappush(ready, ranks[follower])
        if len(ordered) < len(blocks):
            raise self._loop({key: sources for key, sources in waits.items() if sources}, blocks)
        return ordered

    def _loop(self, waits: Mapping[Key, set[Key]], blocks: Mapping[Key, Node]) -> DiagramError:
        """Return the error for a loop without an order; follow wires backward until a block repeats."""

        def position(key: Key) -> tuple[int, ...]:
            return blocks[key].position

        path: dict[Key, None] = {}
        key = min(waits, key=position)
        while key not in path:
            path[key] = None
            key = min(waits[key], key=position)
        loop_keys = [*path][[*path].index(key) :]
        loop = [blocks[loop_key] for loop_key in sorted(loop_keys, key=position)]
        names = ", ".join(node.place for node in loop)
        text = f"{names}: they are a loop without the Assume Data Available indicator"
        return DiagramError(text, Site(line=loop[0].record.line))


def wires_of(sheet: ElementRecord) -> Iterator[ElementRecord]:
    """Yield the wires of a sheet."""
    return (child for child in sheet.children if child.tag in _WIRES)


def pin_of(wire: ElementRecord, name: str, node: Node) -> str:
    """Return the pin at an end of a wire; "" for a reference or connector."""
    return wire.attributes.get(name, "") if node.tag in RUN else ""


def _followers(waits: Mapping[Key, Iterable[Key]]) -> dict[Key, list[Key]]:
    """Return the elements that wait for each element."""
    followers: dict[Key, list[Key]] = {}
    for key, sources in waits.items():
        for source in sources:
            followers.setdefault(source, []).append(key)
    return followers
