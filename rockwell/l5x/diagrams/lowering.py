"""Translates a function block diagram to structured text: lines for each wire, block and output.

    FBD_Blocks_1_0 := Level;                              // an input reference whose tag changes below
    Sum.EnableIn [:=] Run;                                // wires to the inputs of a block
    Sum.SourceA := FBD_Blocks_1_0;
    IF Sum.EnableIn THEN                                  // only if EnableIn is wired
        Sum.Dest := Sum.SourceA + Sum.SourceB;
        Sum.EnableOut [:=] ABS(Sum.Dest) <= 3.4028235e+38;
    ELSE
        Sum.EnableOut := 0;
    END_IF;
    Level := Sum.Dest;                                    // output references, after their block

Data latching: wherever it is wired, an IRef has its value from the beginning of the routine [1756-RM003,
Function Block Attributes, Latching Data]. A generated tag keeps that value if the diagram may change the tag.
EnableOut is the wired EnableIn, otherwise true. It is false after an overflow. Prescan clears EnableIn and
EnableOut [Function Block States].

Interpretations: a wire also writes its value to a block that EnableIn disables; EnableIn without a wire is
not read.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

from scanrack.io_images.site import Site
from scanrack.ladder.instructions.addons import OFF
from scanrack.ladder.model.drawing import Drawing
from scanrack.ladder.model.tags import Tag
from scanrack.ladder.model.tree import Address
from scanrack.ladder.model.types import MAX_REAL, REAL, Elementary

from ..xml.records import ElementRecord
from .blocks import BlockForm, canonical
from .picture import drawn_sheets
from .sheets import Diagram, DiagramError, Node, Pin
from .wire_values import DocumentNames, Values, form_of, name_in

ENABLE_IN, ENABLE_OUT = "EnableIn", "EnableOut"

_PIN = re.compile(r"\{(\w*)\}")
_ANY = {"BAND": " AND ", "BOR": " OR "}
"""Operators of the functions that take any number of wired inputs."""


@dataclass(frozen=True, slots=True)
class DiagramLine:
    """A line of structured text, with the element that it is generated from."""

    text: str
    node: Node

    @property
    def place(self) -> str:
        """The place of its element, for messages."""
        return self.node.place

    @property
    def number(self) -> int:
        """The line of its element in the file."""
        return self.node.record.line


@dataclass(slots=True)
class DiagramText:
    """The structured text of a diagram's routine."""

    lines: list[DiagramLine] = field(default_factory=list)
    tags: list[Tag] = field(default_factory=list)  # tags generated for it
    drawing: Drawing | None = None


def lower_diagram(content: ElementRecord, routine: str, names: DocumentNames) -> DiagramText:
    """Return a diagram's structured text; raise a DiagramError if the diagram can't run."""
    return _Lowering(content, routine, names).run()


class _Lowering:
    """Writes a diagram as structured text, one element after another in order of execution."""

    def __init__(self, content: ElementRecord, routine: str, names: DocumentNames) -> None:
        """Read a diagram and find the tags that it writes; generate a tag for each function's value."""
        self._content, self._names = content, names
        self._diagram = Diagram(content)
        self._values = Values(self._diagram, routine, names)
        self._order = self._diagram.in_order()
        self._lines: list[DiagramLine] = []
        self._refuse_unknown()
        self._written = {names.resolved(name_in(output)) for output in self._written_tags()}
        self._has_calls = any(node.tag == "JSR" for node in self._order)
        for node in self._order:
            if node.tag == "Function":
                self._values.keep_in_tag(node)

    def _refuse_unknown(self) -> None:
        """Raise a DiagramError that names all unknown blocks."""
        blocks = (node for node in self._order if node.tag in ("Block", "Function"))
        unknown_blocks = [block for block in blocks if form_of(block) is None]
        if unknown_blocks:
            names = "; ".join(block.place for block in unknown_blocks)
            kinds = ", ".join(dict.fromkeys(block.type for block in unknown_blocks))
            text = f"{names}: scanrack has no {kinds} in function block diagrams"
            raise DiagramError(text, Site(line=unknown_blocks[0].record.line))

    def _written_tags(self) -> Iterator[str]:
        """Yield the tags that the diagram writes, including the tags of its blocks."""
        for node in self._diagram.nodes.values():
            if node.tag != "IRef" and node.operand:
                yield node.operand
            yield from self._values.arguments(node).values()

    def run(self) -> DiagramText:
        """Return the structured text, and the drawing that refers to its lines by number."""
        self._latch_references()
        for node in self._input_references():
            self._write_references(node)
        for node in self._order:
            _RUN[node.tag](self, node)
            self._write_references(node)
        lines: dict[Node, list[int]] = {}
        for number, line in enumerate(self._lines, start=1):
            if not line.text.startswith("//"):
                lines.setdefault(line.node, []).append(number)
        drawing = Drawing(drawn_sheets(self._diagram, self._values, lines), self._content)
        return DiagramText(self._lines, self._values.tags, drawing)

    # --- input references

    def _input_references(self) -> list[Node]:
        """Return the input references in order of position."""
        references = (node for node in self._diagram.nodes.values() if node.tag == "IRef")
        return sorted(references, key=lambda node: node.position)

    def _latch_references(self) -> None:
        """Copy input references to generated tags if their own tags may change before use."""
        nodes_read = self._nodes_read()
        for node in self._input_references():
            operand = self._values.operand(node)
            if isinstance(operand, Address) and (
                self._has_calls or self._names.resolved(operand.name) in self._written
            ):
                kind = self._names.type_of(operand)
                if isinstance(kind, Elementary) and node in nodes_read:
                    self._add(node, f"{self._values.keep_in_tag(node, kind)} := {node.operand};")

    def _nodes_read(self) -> set[Node]:
        """Return the elements with an output that is wired to an input other than an InOut."""
        nodes: set[Node] = set()
        for key, inputs in self._diagram.inputs.items():
            inouts = self._values.inouts(self._diagram.nodes[key])
            nodes |= {wire.source.node for wire in inputs if wire.name.upper() not in inouts}
        return nodes

    # --- lines

    def _add(self, node: Node, *texts: str) -> None:
        """Add an element's lines, below a comment with its place."""
        if not self._lines or self._lines[-1].place != node.place:
            texts = (f"// {node.place}", *texts)
        self._lines += (DiagramLine(text, node) for text in texts)

    def _write_inputs(self, node: Node) -> None:
        """Copy values to the block's inputs, which are members of its tag.

        Because of the operator [:=], prescan clears EnableIn.
        """
        inouts = self._values.inouts(node)
        for wire in self._diagram.inputs_of(node):
            if wire.name.upper() not in inouts:
                assigns = "[:=]" if wire.name.upper() == ENABLE_IN.upper() else ":="
                target = wire.name if node.tag in ("JSR", "RET") else f"{node.operand}.{wire.name}"
                self._add(node, f"{target} {assigns} {self._values.text(wire.source)};")

    def _write_references(self, node: Node) -> None:
        """Copy the outputs of an element to the output references that are wired to it."""
        for reference, wire in self._diagram.readers(node):
            self._values.operand(reference)
            text = f"{reference.operand} := {self._values.text(wire.source)};"
            self._lines.append(DiagramLine(text, reference))

    def _is_enabled_by_wire(self, node: Node) -> bool:
        return any(wire.name.upper() == ENABLE_IN.upper() for wire in self._diagram.inputs_of(node))

    def _add_conditional(self, node: Node, body: list[str], off: str = "") -> None:
        """Add the lines of a block; if EnableIn is wired and false, only `off` runs."""
        if self._is_enabled_by_wire(node):
            otherwise = ("ELSE", f"    {off or f'{node.operand}.{ENABLE_OUT} := 0;'}", "END_IF;")
            body = [f"IF {node.operand}.{ENABLE_IN} THEN", *(f"    {line}" for line in body), *otherwise]
        self._add(node, *body)

    # --- elements that run

    def _block(self, node: Node) -> None:
        """Add the lines of a block after its inputs; an infinite or unknown result clears EnableOut."""
        self._values.operand(node)
        self._write_inputs(node)
        form = form_of(node)
        assert form is not None
        operands = ",".join((node.operand, *_arrays(node, form)))

        def filled(place: re.Match[str]) -> str:
            return f"{node.operand}.{place[1]}" if place[1] else operands

        body = [_PIN.sub(filled, line) for line in form.lines]
        if form.output:
            result = form.structure.member(form.output)
            valid = "1"
            if result is not None and result.type is REAL:
                valid = f"ABS({node.operand}.{form.output}) <= {MAX_REAL!r}"
            body.append(f"{node.operand}.{ENABLE_OUT} [:=] {valid};")
        self._add_conditional(node, body)

    def _function(self, node: Node) -> None:
        """Add the assignment of a function's value, with its wired inputs instead of the pins."""
        form = form_of(node)
        assert form is not None
        wired = {wire.name.upper(): wire.source for wire in self._diagram.inputs_of(node)}
        formula = form.formula
        operator = _ANY.get(canonical(node.type))
        if operator:
            pins = (pin for pin in _PIN.findall(formula) if pin.upper() in wired)
            formula = operator.join(f"{{{pin}}}" for pin in pins) or formula
        for pin in _PIN.findall(formula):
            if pin.upper() not in wired:
                raise node.refused(f"nothing is wired to its input {pin}")
        text = _PIN.sub(lambda match: self._values.text(wired[match[1].upper()]), formula)
        self._add(node, f"{self._values.text(Pin(node, form.output))} := {text};")

    def _add_on(self, node: Node) -> None:
        """Add the call of an add-on with its InOuts' arguments, and members of its tag for the rest."""
        parameters = self._names.arguments(node.type)
        if parameters is None:
            raise node.refused(f"no add-on {node.type} in the file")
        self._write_inputs(node)
        arguments = self._values.arguments(node)
        missing = next((inout for inout in sorted(self._values.inouts(node)) if inout not in arguments), None)
        if missing is not None:
            raise node.refused(f"its {missing} has no argument")
        operands = (
            arguments.get(parameter.name.upper(), f"{node.operand}.{parameter.name}")
            for parameter in parameters
        )
        operand_list = f"({','.join((node.operand, *operands))});"
        off_call = f"{node.type}{OFF}{operand_list}" if self._names.acts_when_off(node.type) else ""
        self._add_conditional(node, [f"{node.type}{operand_list}"], off_call)

    def _call(self, node: Node) -> None:
        """Add a JSR. Its pins are the tags that it passes and receives. A wire to a pin writes its tag."""
        self._write_inputs(node)
        inputs, returns = (node.record.attributes.get(name, "").split() for name in ("In", "Ret"))
        self._add(node, f"JSR({','.join((node.type, str(len(inputs)), *inputs, *returns))});")

    def _begin(self, node: Node) -> None:
        """Put an SBR with the parameters of the routine at the beginning, if there are any."""
        if _parameters(node):
            self._lines.insert(0, DiagramLine(f"SBR({','.join(_parameters(node))});", node))

    def _return(self, node: Node) -> None:
        """Add a RET with the values that the routine returns."""
        self._write_inputs(node)
        self._add(node, f"RET({','.join(_parameters(node))});")


_RUN: Mapping[str, Callable[[_Lowering, Node], None]] = {
    "Block": _Lowering._block,
    "Function": _Lowering._function,
    "AddOnInstruction": _Lowering._add_on,
    "JSR": _Lowering._call,
    "SBR": _Lowering._begin,
    "RET": _Lowering._return,
}


def _arrays(node: Node, form: BlockForm) -> list[str]:
    """Return the array operands of a block in call order."""
    by_name: dict[str, str] = {}
    for child in node.record.children:
        if child.tag == "Array":
            name = child.attributes.get("Name", "").upper().removesuffix("ARRAY")
            by_name[name] = child.attributes.get("Operand", "")
    arrays = [by_name.pop(name.upper(), "") for name in form.arrays]
    if by_name:
        raise node.refused(f"it has no array {', '.join(by_name)}")
    return [array for array in arrays if array]


def _parameters(node: Node) -> list[str]:
    """Return the tags of an SBR or RET."""
    get = node.record.attributes.get
    return [*get("In", "").split(), *get("Ret", "").split()]
