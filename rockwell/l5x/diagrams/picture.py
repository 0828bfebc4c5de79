"""Draws a diagram: elements at their positions, with pins and the tag of each value."""

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


def drawn_sheets(
    diagram: Diagram, values: Values, lines: Mapping[Node, Sequence[int]]
) -> tuple[DrawnSheet, ...]:
    """Return the sheets of a diagram.

    Args:
        lines: line numbers of each element's structured text.
    """
    nodes: defaultdict[int, list[Node]] = defaultdict(list)
    for (sheet, _), node in diagram.nodes.items():
        nodes[sheet].append(node)
    connected: dict[Node, Pin] = {}
    for wire in chain.from_iterable(diagram.inputs.values()):
        if wire.through is not None:
            connected.setdefault(wire.through, wire.source)
    shared = _SharedParts(diagram, values, lines, connected)
    return tuple(
        _Sheet(record, number, nodes[number], shared).sheet() for number, record in diagram.sheets.items()
    )


@dataclass(frozen=True, slots=True)
class _SharedParts:
    """The parts of a diagram that all sheets share."""

    diagram: Diagram
    values: Values
    lines: Mapping[Node, Sequence[int]]  # of the structured text, by element
    connected: Mapping[Node, Pin]  # the value of each input connector


class _Sheet:
    """One sheet of a diagram, with the elements on it."""

    def __init__(
        self, record: ElementRecord, number: int, nodes: Sequence[Node], shared: _SharedParts
    ) -> None:
        self._record, self._number, self._nodes, self._shared = record, number, nodes, shared
        self._diagram, self._values = shared.diagram, shared.values
        self._index = {node.key: index for index, node in enumerate(nodes)}

    def sheet(self) -> DrawnSheet:
        """Return the sheet with its elements, texts and wires."""
        comment = next(
            (child.text.strip() for child in self._record.children if child.tag == "Description"), ""
        )
        wires = list(map(self._wire, wires_of(self._record)))
        outputs: defaultdict[int, set[str]] = defaultdict(set)
        for wire in wires:
            outputs[wire.source].add(wire.output)
        elements = [self._element(node, outputs[index]) for index, node in enumerate(self._nodes)]
        texts = [_text(child) for child in self._record.children if child.tag == "TextBox"]
        return DrawnSheet(self._number, comment, (*elements, *texts), tuple(wires))

    def _wire(self, record: ElementRecord) -> DrawnWire:
        """Return a wire; its ends are indexes of elements of this sheet."""
        get = record.attributes.get
        keys = [(self._number, number_of(get(name, "")) or 0) for name in ("FromID", "ToID")]
        source, target = (self._diagram.nodes[key] for key in keys)
        output, pin = pin_of(record, "FromParam", source), pin_of(record, "ToParam", target)
        value = self._value(source, output)
        feedback = record.tag == "FeedbackWire"
        source_index, target_index = self._index[source.key], self._index[target.key]
        return DrawnWire(source_index, output, target_index, input=pin, value=value, feedback=feedback)

    def _value(self, node: Node, pin: str) -> str:
        """Return the address of a value on this sheet; for an input connector, the address of its source."""
        if node.tag != "ICon":
            return self._values.text(Pin(node, pin))
        source = self._shared.connected.get(node)
        return "" if source is None else self._values.text(source)

    def _element(self, node: Node, wired: set[str]) -> DrawnElement:
        """Return an element as drawn: with its pins if it runs, else with one label."""
        _, x, y, _ = node.position
        lines = tuple(self._shared.lines.get(node, ()))
        if node.tag not in RUN:
            kind = _KINDS[node.tag]
            if kind == "connector":
                label, tag = node.record.attributes.get("Name", ""), ""
            else:
                label = tag = node.operand
            return DrawnElement(kind, x, y, (label,), tag, places=lines)
        labels = tuple(filter(None, (node.type or node.tag, node.operand)))
        inputs, outputs = self._pins(node, wired)
        return DrawnElement(
            "block", x, y, labels, tag=node.operand, inputs=inputs, outputs=outputs, places=lines
        )

    def _pins(self, node: Node, wired: set[str]) -> tuple[tuple[DrawnPin, ...], tuple[DrawnPin, ...]]:
        """Return the visible or wired pins on the left and on the right, in the order of the block type."""
        sources = {wire.name: wire.source for wire in self._diagram.inputs_of(node)}
        visible, inputs, returns = (_words(node, key) for key in ("VisiblePins", "In", "Ret"))
        names = list(dict.fromkeys((*visible, *inputs, *returns, *sources, *wired)))
        form = form_of(node)
        order = [member.name for member in form.structure.members] if form else []
        names.sort(key=lambda name: order.index(name) if name in order else len(order))
        right = self._outputs(node, names, order) | (wired - sources.keys())
        if node.tag == "JSR":
            right.update(returns)
        elif node.tag == "SBR":
            right |= {*inputs, *returns} - sources.keys()
        # an input of a function has no tag of its own: show the value on its wire
        on_wires = sources if node.tag == "Function" else {}
        pins = [DrawnPin(name, self._values.text(on_wires.get(name, Pin(node, name)))) for name in names]
        left = tuple(pin for pin in pins if pin.name not in right)
        return left, tuple(pin for pin in pins if pin.name in right)

    def _outputs(self, node: Node, names: Iterable[str], order: list[str]) -> set[str]:
        """Return the pins that are outputs according to a node's type: EnableOut and the members after it."""
        type_outputs = order[order.index("EnableOut") :] if "EnableOut" in order else []
        add_on_outputs = self._values.outputs(node)
        return {name for name in names if name in type_outputs or name.upper() in add_on_outputs}


def _words(node: Node, name: str) -> list[str]:
    return node.record.attributes.get(name, "").split()


def _text(record: ElementRecord) -> DrawnElement:
    """Return a text box as drawn, without wires."""
    x, y = (int(number_of(record.attributes.get(name, "")) or 0) for name in "XY")
    text = record.text.strip() or next((child.text.strip() for child in record.children), "")
    return DrawnElement("text", x, y, tuple(text.splitlines()))
