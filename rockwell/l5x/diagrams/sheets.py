"""The sheets of a function block diagram: elements, wires between them, and the order of the blocks.

    IRef -- Wire --> Block, Function, AddOnInstruction -- Wire --> ORef
    an OCon and an ICon with the same name join wires across sheets; an OCon may have several ICons

A block runs after the blocks whose outputs it receives. A wire with the Assume Data Available indicator, in
an export a FeedbackWire, has the value of the previous execution, and so does a wire from a block to itself.
A loop of several blocks without such a wire has no order, as in Studio 5000 [1756-RM003, Function Block
Attributes, Order of Execution and Resolve a Loop; 1756-PM009, Program a Function Block Diagram].

The manual says that order does not matter between blocks that are not wired together. Interpretation: where
it does, because they use the same tag, they run sheet by sheet, from left to right, then from top to bottom.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from heapq import heapify, heappop, heappush

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
"""Maximum elements and wires of a routine."""

Key = tuple[int, int]
"""Sheet, from 1, and ID of an element."""


class DiagramError(LadderError):
    """The diagram can't be run; the error's site has the line."""


@dataclass(frozen=True, slots=True)
class Pin:
    """An output of an element; `name` is "" for an IRef."""

    node: Node
    name: str


@dataclass(frozen=True, slots=True, eq=False)
class Node:
    """An element."""

    key: Key
    record: ElementRecord

    @property
    def tag(self) -> str:
        """Its kind, by the name in an export."""
        return self.record.tag

    @property
    def type(self) -> str:
        """Its instruction or routine, "" for a reference or connector."""
        get = self.record.attributes.get
        return (get("Type") or get("Name") or get("Routine") or "") if self.tag in RUN else ""

    @property
    def operand(self) -> str:
        """Its tag, address or number; "" if it has none."""
        return self.record.attributes.get("Operand", "").strip()

    @property
    def place(self) -> str:
        """Its place, as readable text."""
        name = self.operand or self.record.attributes.get("Name", "") * (self.tag in ("ICon", "OCon"))
        label = " ".join(filter(None, (self.type or self.tag, name or f"with ID {self.key[1]}")))
        return f"sheet {self.key[0]}, {label}"

    @property
    def position(self) -> tuple[int, int, int, int]:
        """Its place in the order of blocks that are not wired together."""
        x, y = (int(number_of(self.record.attributes.get(name, "")) or 0) for name in "XY")
        return self.key[0], x, y, self.key[1]

    def refused(self, text: str) -> DiagramError:
        """Return the error for it."""
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
    source: Key
    output: str
    feedback: bool


class Diagram:
    """The elements of a routine, with their inputs."""

    def __init__(self, content: ElementRecord) -> None:
        self.nodes: dict[Key, Node] = {}
        self.sheets: dict[int, ElementRecord] = {}
        self._wires: dict[Key, dict[str, _Wire]] = {}  # by target and pin in capitals
        self._connectors: dict[str, Node] = {}
        self._sources: dict[Key, tuple[Key, str, bool]] = {}  # true source of each input connector
        self._read_sheets(content)
        self.inputs: Mapping[Key, tuple[Input, ...]] = {
            key: tuple(self._input(key, wire) for wire in wires.values())
            for key, wires in self._wires.items()
        }
        self._readers: dict[Key, list[tuple[Node, Input]]] = {}  # by source
        for reference in sorted(self._of("ORef"), key=lambda each: each.position):
            for drawn in self.inputs_of(reference):
                self._readers.setdefault(drawn.source.node.key, []).append((reference, drawn))

    def _read_sheets(self, content: ElementRecord) -> None:
        sheets = [child for child in content.children if child.tag == "Sheet"]
        if sum(1 + len(page.children) for page in sheets) > MOST_ELEMENTS:
            raise DiagramError(f"it has more than {MOST_ELEMENTS:,} elements", Site(line=content.line))
        for place, sheet in enumerate(sheets, start=1):
            number = number_of(sheet.attributes.get("Number", "")) or place
            if self.sheets.setdefault(number, sheet) is not sheet:
                raise DiagramError(f"there are two sheets {number}", Site(line=sheet.line))
            for child in sheet.children:
                self._node(number, child)
            for child in wires_of(sheet):
                self._wire(number, child)

    def _node(self, sheet: int, record: ElementRecord) -> None:
        if record.tag in (*_WIRES, *_REMARKS):
            return
        number = number_of(record.attributes.get("ID", ""))
        node = Node((sheet, -1 if number is None else number), record)
        if record.tag not in _NODES:
            raise node.refused(f"elements are {', '.join(_NODES)}")
        if number is None or node.key in self.nodes:
            raise node.refused("its ID is missing, or that of another element")
        self.nodes[node.key] = node
        if record.tag == "OCon":
            name = record.attributes.get("Name", "").upper()
            if self._connectors.setdefault(name, node) is not node:
                raise node.refused("there are two output connectors of this name")

    def _wire(self, sheet: int, record: ElementRecord) -> None:
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
        node_number = number_of(number)
        return None if node_number is None else self.nodes.get((sheet, node_number))

    def _input(self, key: Key, wire: _Wire) -> Input:
        """Return an input, with its source traced through connectors."""
        first = self.nodes[wire.source]
        origin, pin, delayed = self._past_connectors(wire.source, wire.output)
        if self.nodes[origin].tag in ("ORef", "OCon"):
            raise self.nodes[origin].refused("a wire leaves it, and it has no output")
        # a block that is wired to itself needs no indicator
        feedback = wire.feedback or delayed or origin == key
        return Input(wire.pin, Pin(self.nodes[origin], pin), feedback, first if first.tag == "ICon" else None)

    def _past_connectors(self, at: Key, pin: str) -> tuple[Key, str, bool]:
        """Follow input connectors to an element and its output; the last value: past a feedback wire."""
        visited: dict[Key, bool] = {}
        while self.nodes[at].tag == "ICon" and at not in self._sources:
            connector = self._connectors.get(self.nodes[at].record.attributes.get("Name", "").upper())
            if connector is None or not self._wires.get(connector.key) or at in visited:
                raise self.nodes[at].refused("nothing is wired to its output connector")
            wire = self._wires[connector.key][""]
            visited[at] = wire.feedback
            at, pin = wire.source, wire.output
        source = self._sources.get(at, (at, pin, False))
        for passed, feedback in reversed(visited.items()):
            source = self._sources[passed] = (*source[:2], source[2] or feedback)
        return source

    def inputs_of(self, node: Node) -> tuple[Input, ...]:
        """Return its wired inputs."""
        return self.inputs.get(node.key, ())

    def readers(self, node: Node) -> Sequence[tuple[Node, Input]]:
        """Return the output references that receive a value of a node, in order of position."""
        return self._readers.get(node.key, ())

    def _of(self, *tags: str) -> Iterator[Node]:
        return (node for node in self.nodes.values() if node.tag in tags)

    def in_order(self) -> list[Node]:
        """Return the elements that run, in order of execution: SBR is first, RET last."""
        blocks = {node.key: node for node in self._of(*RUN)}
        waits = {
            key: {wire.source.node.key for wire in self.inputs_of(node) if not wire.feedback} & blocks.keys()
            for key, node in blocks.items()
        }
        after = _readers(waits)
        ranks = {key: (_RANKS.get(node.tag, 1), node.position, key) for key, node in blocks.items()}
        ready = [ranks[key] for key in blocks if not waits[key]]
        heapify(ready)
        ordered: list[Node] = []
        while ready:
            key = heappop(ready)[-1]
            ordered.append(blocks[key])
            for follower in after.get(key, ()):
                waits[follower].discard(key)
                if not waits[follower]:
                    heappush(ready, ranks[follower])
        if len(ordered) < len(blocks):
            raise self._loop({key: sources for key, sources in waits.items() if sources}, blocks)
        return ordered

    def _loop(self, waits: Mapping[Key, set[Key]], blocks: Mapping[Key, Node]) -> DiagramError:
        """Return the error for a loop without an order; go backward until a block repeats."""
        key = min(waits, key=lambda each: blocks[each].position)
        visited: dict[Key, int] = {}
        while key not in visited:
            visited[key] = len(visited)
            key = min(waits[key], key=lambda each: blocks[each].position)
        loop = sorted(
            (blocks[block_key] for block_key in [*visited][visited[key] :]), key=lambda each: each.position
        )
        names = ", ".join(node.place for node in loop)
        text = f"{names}: they are a loop without the Assume Data Available indicator"
        return DiagramError(text, Site(line=loop[0].record.line))


def wires_of(sheet: ElementRecord) -> Iterator[ElementRecord]:
    """Yield the wires of a sheet."""
    return (child for child in sheet.children if child.tag in _WIRES)


def pin_of(wire: ElementRecord, name: str, node: Node) -> str:
    """Return the pin at an end of a wire, "" for a reference or connector."""
    return wire.attributes.get(name, "") if node.tag in RUN else ""


def _readers(waits: Mapping[Key, Iterable[Key]]) -> dict[Key, list[Key]]:
    """Return the elements that read each one."""
    readers: dict[Key, list[Key]] = {}
    for key, sources in waits.items():
        for source in sources:
            readers.setdefault(source, []).append(key)
    return readers
