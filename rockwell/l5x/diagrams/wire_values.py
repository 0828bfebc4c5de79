"""Values on the wires of a diagram: the text of each output, and its type.

A function has no tag, so a generated tag stores its value. Interpretation: this tag has the type of the
widest input, but an integer tag is at least a DINT, so 7 / 2 with two INTs is 3.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

from scanrack.ladder.model.errors import LadderError
from scanrack.ladder.model.expressions import parse_expression
from scanrack.ladder.model.tags import Tag
from scanrack.ladder.model.tree import Address, Number, Operand
from scanrack.ladder.model.types import BOOL, DINT, LINT, LREAL, REAL, DataType, Elementary

from ..xml.records import TagRecord
from .blocks import BLOCKS, FUNCTION, BlockForm, canonical
from .sheets import Diagram, Node, Pin


@dataclass(frozen=True, slots=True)
class DocumentNames:
    """Functions that look up the names of a diagram in the document."""

    type_of: Callable[[Address], DataType | None]
    resolved: Callable[[str], str]  # the tag of a name without aliases, in capitals
    arguments: Callable[[str], tuple[TagRecord, ...] | None]  # of an add-on, in call order; None if unknown
    acts_when_off: Callable[[str], bool]  # whether an add-on has logic for a false EnableIn
    outputs: Callable[[str], frozenset[str]]  # names of an add-on's outputs, in capitals


def name_in(operand: str) -> str:
    """Return the tag in an address given as text; return any other operand unchanged."""
    try:
        expression = parse_expression(operand)
    except LadderError:
        return operand
    return expression.name if isinstance(expression, Address) else operand


def form_of(node: Node) -> BlockForm | None:
    """Return the form of a block or function; None if it is unknown."""
    form = BLOCKS.get(canonical(node.type))
    if node.tag == "Function":
        return form if form is not None and form.formula and node.type.endswith(FUNCTION) else None
    return form


class Values:
    """The values of one diagram."""

    def __init__(self, diagram: Diagram, routine: str, names: DocumentNames) -> None:
        self._diagram, self._routine, self._names = diagram, routine, names
        self._generated: dict[Node, Tag] = {}
        self._arguments: dict[Node, Mapping[str, str]] = {}

    @property
    def tags(self) -> list[Tag]:
        """The generated tags."""
        return [*self._generated.values()]

    def keep_in_tag(self, node: Node, kind: Elementary | None = None) -> str:
        """Generate a tag for the value of an element; return the tag's name.

        Args:
            kind: the tag's type; None for the result type of a function.
        """
        sheet, number = node.key
        name = f"FBD_{self._routine}_{sheet}_{number}"
        self._generated[node] = Tag(name, kind or self._function_type(node), comment=node.place)
        return name

    def operand(self, node: Node) -> Operand:
        """Return the operand of a reference or the tag of a block; raise a DiagramError if it is invalid."""
        try:
            operand = parse_expression(node.operand)
        except LadderError:
            operand = None
        if isinstance(operand, Address) or (isinstance(operand, Number) and node.tag == "IRef"):
            return operand
        raise node.refused(f"its operand must be {'a tag or a number' if node.tag == 'IRef' else 'a tag'}")

    def text(self, source: Pin) -> str:
        """Return a value as structured text."""
        node = source.node
        if node in self._generated:
            return self._generated[node].name
        if node.tag == "IRef":
            self.operand(node)
            return f"({node.operand})" if node.operand.startswith("-") else node.operand
        if node.tag in ("JSR", "SBR"):
            return source.name
        return self.arguments(node).get(source.name.upper(), f"{node.operand}.{source.name}")

    def _type(self, source: Pin) -> DataType | None:
        """Return the type of a value; None if it is unknown."""
        if source.node in self._generated:
            return self._generated[source.node].type
        form = form_of(source.node)
        if source.node.tag == "Block" and form is not None:
            member = form.structure.member(source.name)
            return member.type if member else None
        operand = parse_expression(self.text(source))
        if isinstance(operand, Address):
            return self._names.type_of(operand)
        return REAL if isinstance(operand, Number) and isinstance(operand.value, float) else DINT

    def _function_type(self, node: Node) -> Elementary:
        """Return the type of a function's value: BOOL, or the type that its widest inputs require."""
        form = form_of(node)
        member = form.structure.member(form.output) if form else None
        assert member is not None
        if member.type is BOOL:
            return BOOL
        kinds = list(self._types_of_inputs(node))
        if member.type is REAL and LREAL in kinds:
            return LREAL
        if member.type is REAL and (REAL in kinds or None in kinds):
            return REAL
        for kind in kinds:
            if isinstance(kind, Elementary) and kind.is_integer and kind.bits > DINT.bits:
                return LINT
        return DINT

    def _types_of_inputs(self, node: Node) -> Iterator[DataType | None]:
        """Yield the types of a node's inputs, except inputs from functions that have no tag yet."""
        for wire in self._diagram.inputs_of(node):
            if wire.source.node.tag != "Function" or wire.source.node in self._generated:
                yield self._type(wire.source)

    # --- parameters of add-ons

    def outputs(self, node: Node) -> frozenset[str]:
        """Return the outputs of an add-on's element, by name in capitals."""
        return self._names.outputs(node.type) if node.tag == "AddOnInstruction" else frozenset()

    def inouts(self, node: Node) -> frozenset[str]:
        """Return the InOuts of an add-on's element, by name in capitals."""
        arguments = self._names.arguments(node.type) if node.tag == "AddOnInstruction" else None
        return frozenset(
            argument.name.upper() for argument in arguments or () if argument.usage.upper() == "INOUT"
        )

    def arguments(self, node: Node) -> Mapping[str, str]:
        """Return the arguments of InOuts by name in capitals, from the element or from a wired reference."""
        if node.tag != "AddOnInstruction":
            return {}
        if node not in self._arguments:
            self._arguments[node] = self._read_arguments(node)
        return self._arguments[node]

    def _read_arguments(self, node: Node) -> Mapping[str, str]:
        """Return the arguments of InOuts; a wired input reference takes precedence over the element."""
        arguments = {
            child.attributes.get("Name", "").upper(): child.attributes.get("Argument", "")
            for child in node.record.children
            if child.tag == "InOutParameter"
        }
        inouts = self.inouts(node)
        for wire in self._diagram.inputs_of(node):
            if wire.name.upper() in inouts and wire.source.node.tag == "IRef":
                arguments[wire.name.upper()] = wire.source.node.operand
        return {name: argument for name, argument in arguments.items() if argument}
