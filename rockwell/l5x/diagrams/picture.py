"""Draws a diagram: elements at their places, with pins and the tag of each value."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain

from scanrack.ladder.model.drawing import DrawnElement, DrawnPin, DrawnSheet, DrawnWire

from ..xml.elements import number_of
from ..xml.records import ElementRecord
from .sheets import RUN, Diagram, Node, Pin, pin_of, wires_of
from .wire_values import Values, form_of

_KINDS = {"IRef": "input", "ORef": "output", "ICon": "connector", "OCon": "connector"}


def drawn(diagram: Diagram, values: Values, places: Mapping[Node, Sequence[int]]) -> tuple[DrawnSheet, ...]:
    """Return the sheets; `places` are the lines of structured text of each element."""
    nodes: defaultdict[int, list[Node]] = defaultdict(list)
    for (sheet, _), node in diagram.nodes.items():
        nodes[sheet].append(node)
    connected: dict[Node, Pin] = {}
    for wire in chain.from_iterable(diagram.inputs.values()):
        if wire.through is not None:
            connected.setdefault(wire.through, wire.source)
    parts = _DiagramParts(diagram, values, places, connected)
    return tuple(
        _Sheet(record, number, nodes[number], parts).sheet() for number, record in diagram.sheets.items()
    )


@dataclass(frozen=True, slots=True)
class _DiagramParts:
    """The parts of a diagram that all sheets share."""

    diagram: Diagram
    values: Values
    places: Mapping[Node, Sequence[int]]
    connected: Mapping[Node, Pin]  # the value of each input connector


class _Sheet:
    def __init__(
        self, record: ElementRecord, number: int, nodes: Sequence[Node], shown: _DiagramParts
    ) -> None:
        self._record, self._number, self._nodes, self._shown = record, number, nodes, shown
        self._diagram, self._values = shown.diagram, shown.values
        self._index = {node.key: place for place, node in enumerate(nodes)}

    def sheet(self) -> DrawnSheet:
        comment = next(
            (child.text.strip() for child in self._record.children if child.tag == "Description"), ""
        )
        wires = list(map(self._wire, wires_of(self._record)))
        outputs: defaultdict[int, set[str]] = defaultdict(set)
        for wire in wires:
            outputs[wire.source].add(wire.output)
        elements = [self._element(node, outputs[place]) for place, node in enumerate(self._nodes)]
        texts = [_text(child) for child in self._record.children if child.tag == "TextBox"]
        return DrawnSheet(self._number, comment, (*elements, *texts), tuple(wires))

    def _wire(self, record: ElementRecord) -> DrawnWire:
        get = record.attributes.get
        keys = [(self._number, number_of(get(name, "")) or 0) for name in ("FromID", "ToID")]
        source, target = (self._diagram.nodes[key] for key in keys)
        output, pin = pin_of(record, "FromParam", source), pin_of(record, "ToParam", target)
        value = self._value(source, output)
        feedback = record.tag == "FeedbackWire"
        return DrawnWire(self._index[source.key], output, self._index[target.key], pin, value, feedback)

    def _value(self, node: Node, pin: str) -> str:
        """Return the address of a value on this sheet; an input connector has the address of its source."""
        if node.tag != "ICon":
            return self._values.text(Pin(node, pin))
        source = self._shown.connected.get(node)
        return "" if source is None else self._values.text(source)

    def _element(self, node: Node, wired: set[str]) -> DrawnElement:
        _, x, y, _ = node.position
        places = tuple(self._shown.places.get(node, ()))
        name = node.record.attributes.get("Name", "")
        if node.tag not in RUN:
            kind = _KINDS[node.tag]
            label = name if kind == "connector" else node.operand
            tag = node.operand if kind != "connector" else ""
            return DrawnElement(kind, x, y, (label,), tag, places=places)
        lines = tuple(filter(None, (node.type or node.tag, node.operand)))
        inputs, outputs = self._pins(node, wired)
        return DrawnElement("block", x, y, lines, node.operand, inputs, outputs, places)

    def _pins(self, node: Node, wired: set[str]) -> tuple[tuple[DrawnPin, ...], tuple[DrawnPin, ...]]:
        """Return the visible or wired pins on the left and on the right, in the order of the type."""
        sources = {wire.name: wire.source for wire in self._diagram.inputs_of(node)}
        visible, inputs, returns = (_words(node, key) for key in ("VisiblePins", "In", "Ret"))
        names = list(dict.fromkeys((*visible, *inputs, *returns, *sources, *wired)))
        form = form_of(node)
        order = [member.name for member in form.structure.members] if form else []
        names.sort(key=lambda each: order.index(each) if each in order else len(order))
        right = self._outputs(node, names, order) | (wired - sources.keys())
        if node.tag == "JSR":
            right.update(returns)
        elif node.tag == "SBR":
            right |= {*inputs, *returns} - sources.keys()
        of_wire = sources if node.tag == "Function" else {}  # a function has no memory of its inputs
        pins = {name: DrawnPin(name, self._values.text(of_wire.get(name, Pin(node, name)))) for name in names}
        left = tuple(pin for name, pin in pins.items() if name not in right)
        return left, tuple(pin for name, pin in pins.items() if name in right)

    def _outputs(self, node: Node, names: Iterable[str], order: list[str]) -> set[str]:
        """Return the pins that are outputs according to a node's type."""
        of_type = order[order.index("EnableOut") :] if "EnableOut" in order else []
        of_add_on = self._values.outputs(node)
        return {name for name in names if name in of_type or name.upper() in of_add_on}


def _words(node: Node, name: str) -> list[str]:
    return node.record.attributes.get(name, "").split()


def _text(record: ElementRecord) -> DrawnElement:
    x, y = (int(number_of(record.attributes.get(name, "")) or 0) for name in "XY")
    text = record.text.strip() or next((child.text.strip() for child in record.children), "")
    return DrawnElement("text", x, y, tuple(text.splitlines()))
