"""Diagrams with many elements cost in proportion to their size, whatever is wired to what."""

import sys
from dataclasses import replace

import pytest
from l5x_files import block, connector, document, program, reference, sheets, wire
from scanrack.ladder.draw import live_diagram
from scanrack.ladder.model.types import DINT
from scanrack.rockwell.l5x.diagrams.lowering import lower_diagram
from scanrack.rockwell.l5x.diagrams.sheets import MOST_ELEMENTS, Diagram, DiagramError
from scanrack.rockwell.l5x.diagrams.wire_values import DocumentNames
from scanrack.rockwell.l5x.xml.document import parse_document

KNOWN = DocumentNames(lambda _: DINT, str.upper, lambda _: (), lambda _: False, lambda _: frozenset())


def chain(count):
    """Connectors one behind the other: ICon n is wired to OCon n + 1."""
    yield reference("IRef", 0, "N") + connector("OCon", 1, "L0") + wire(0, 1)
    for n in range(count):
        yield connector("ICon", 2 * n + 2, f"L{n}") + connector("OCon", 2 * n + 3, f"L{n + 1}")
        yield wire(2 * n + 2, 2 * n + 3)


def one_connector(count):
    """Many readers of one output connector."""
    yield reference("IRef", 0, "N") + connector("OCon", 1, "L") + wire(0, 1)
    for n in range(2, 2 * count, 2):
        yield connector("ICon", n, "L") + reference("ORef", n + 1, f"O{n}") + wire(n, n + 1)


def references(count):
    """Pairs of references, latched, since a JSR may change them."""
    yield '<JSR ID="0" X="0" Y="0" Routine="Other"/>\n'
    for n in range(1, 2 * count, 2):
        yield reference("IRef", n, f"I{n}") + reference("ORef", n + 1, "Same") + wire(n, n + 1)


def pins(count):
    """One add-on with many wired inputs and read outputs."""
    yield '<AddOnInstruction Name="Big" ID="0" X="0" Y="0" Operand="It"/>\n'
    yield reference("IRef", 1, "N") + wire(1, "0.Item")
    for n in range(2, count):
        yield wire(1, f"0.In{n}") + reference("ORef", n, f"O{n}") + wire(f"0.Out{n}", n)


def blocks(count):
    for n in range(0, 2 * count, 2):
        yield block("ADD", n, f"B{n}") + reference("ORef", n + 1, f"O{n}") + wire(f"{n}.Dest", n + 1)


def record_of(*contents):
    text = document(programs=[program("P", sheets("Blocks", *contents))])
    record = parse_document(text.encode(), "machine.L5X").programs[0].routines[0].chart
    assert record is not None
    return record


def lines_run(content):
    """Return how many lines of Python a diagram and its picture take; a one-line loop counts at each turn."""
    count = 0

    def trace(_frame, event, _argument):
        nonlocal count
        count += event == "line"
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        found = lower_diagram(content, "Blocks", KNOWN)
        assert found.drawing is not None
        live_diagram(found.drawing.sheets, "Blocks")
    finally:
        sys.settrace(before)
    return count


@pytest.mark.parametrize("diagram", [chain, one_connector, references, pins, blocks])
def test_twice_the_elements_cost_twice_the_time(diagram):
    """Four times would be quadratic."""
    few, many = (lines_run(record_of("".join(diagram(count)))) for count in (100, 200))
    assert 1.5 * few < many < 2.1 * few


def test_sheets_cost_as_much_as_their_elements():
    few, many = (lines_run(record_of(*[reference("IRef", 0, "N")] * count)) for count in (100, 200))
    assert 1.5 * few < many < 2.1 * few


def test_references_of_one_name_have_their_own_lines():
    """A picture has one element for each."""
    content = "".join(reference("ORef", n, "Same") + wire(0, n) for n in (1, 2, 3))
    found = lower_diagram(record_of(reference("IRef", 0, "N") + content), "Blocks", KNOWN)
    assert found.drawing is not None
    (sheet,) = found.drawing.sheets
    assert [each.places for each in sheet.elements] == [(), (1,), (2,), (3,)]


def test_empty_sheets_count_as_elements():
    record = record_of("")
    sheet = replace(record, tag="Sheet", attributes={}, children=())
    Diagram(replace(record, children=(sheet,)))
    with pytest.raises(DiagramError, match="more than 20,000 elements"):
        Diagram(replace(record, children=(sheet,) * (MOST_ELEMENTS + 1)))
