"""Pictures of function block diagrams: what stands where, what a page lights and shows."""

import pytest
from l5x_files import (
    add_on,
    block,
    connector,
    document,
    ladder,
    parameter,
    program,
    reference,
    sheets,
    tag,
    task,
    wire,
)
from lxml import etree
from scanrack.ladder.draw import routines_svg
from scanrack.watch.history.catalog import Catalog

FIRST = (
    "<Description>\n<![CDATA[Starts\nthe motor]]>\n</Description>\n"
    + reference("IRef", 0, "Start", x=20, y=40)
    + block("TONR", 1, "Delay", x=100, y=20, pins="TimerEnable PRE ACC DN")
    + block("ADD__F", 2, x=100, y=200)
    + reference("IRef", 3, "N", x=20, y=200)
    + reference("IRef", 4, "5", x=20, y=240)
    + connector("OCon", 5, "Late")
    + '<AddOnInstruction Name="Valve" ID="6" X="300" Y="200" Operand="V1" VisiblePins="Level Open"/>\n'
    + '<TextBox ID="7" X="20" Y="300" Width="0">\n<Text>\n<![CDATA[a < b]]>\n</Text>\n</TextBox>\n'
    + wire(0, "1.TimerEnable")
    + wire("1.DN", 5)
    + wire(3, "2.SourceA")
    + wire(4, "2.SourceB")
    + wire("2.Dest", "6.Level")
)
SECOND = connector("ICon", 0, "Late") + reference("ORef", 1, "Motor", x=90, y=0) + wire(0, 1, feedback=True)
KINDS = {"BOOL": "Start Motor", "DINT": "N", "FBD_TIMER": "Delay", "Valve": "V1"}


@pytest.fixture
def made(imported):
    pins = [
        parameter("Level", "DINT", "Input", required=False),
        parameter("Open", "BOOL", "Output", required=False),
    ]
    valve = add_on("Valve", pins, [], ladder("Logic", "GRT(Level,3)OTE(Open);"))
    tags = [tag(name, kind) for kind, names in KINDS.items() for name in names.split()]
    routines = ladder("Main", "JSR(Blocks,0);"), sheets("Blocks", FIRST, SECOND)
    text = document(add_ons=[valve], tags=tags, programs=[program("P", *routines)], tasks=[task("T", "P")])
    found = imported(text)
    assert found.report.objects == []
    return found.controller


@pytest.fixture
def picture(made):
    _, answer = Catalog(made).show(r"\P.Blocks", 100)
    return etree.fromstring(answer["diagram"].encode())


def elements(picture):
    return {each[0].text: each for each in picture.iter("{*}g") if "element" in each.get("class", "")}


def boxes(picture):
    return {name: each.find("{*}rect") for name, each in elements(picture).items()}


def test_a_page_gets_a_diagram_with_its_tags(made):
    catalog = Catalog(made)
    assert [each["kind"] for each in catalog.routines()] == ["ladder", "fbd"]
    shown, answer = catalog.show(r"\p.blocks", 100)
    assert set(answer) == {"routine", "diagram", "addresses"}
    assert {"Start", "Delay.ACC", "N", r"\P.FBD_Blocks_1_2", "V1.Open"} <= set(shown.names)


def test_elements_stand_as_in_the_editor_and_the_second_sheet_below(picture):
    places = {name: (float(box.get("x")), float(box.get("y"))) for name, box in boxes(picture).items()}
    assert places["Start"][0] < places["TONR Delay"][0] < places["Valve V1"][0]
    assert places["TONR Delay"][1] < places["ADD__F"][1] < places["Motor"][1]
    titles = [each.text for each in picture.iter("{*}text") if each.get("class") == "heading"]
    assert titles[0] == "Sheet 1 Starts the motor"
    assert "Sheet 2" in titles
    assert any(each.text == "a < b" for each in picture.iter("{*}text"))


def test_wires_of_bits_are_lit_by_their_values_and_those_of_numbers_are_not(picture):
    wires = [(each.get("data-lit"), each.get("class")) for each in picture.iter("{*}path")]
    number = (None, "wire")
    assert wires == [
        ("Start", "wire"),
        ("Delay.DN", "wire"),
        *[number] * 3,
        ("Delay.DN", "wire feedback"),  # behind the connectors
    ]


def test_pins_show_inputs_on_the_left_and_outputs_on_the_right(picture):
    """A function shows what its wires bring; an add-on's output without a wire is on its right, too."""
    of = elements(picture)
    values = {
        name: [(each.get("data-value-of"), each.get("text-anchor")) for each in of[name].iter("{*}text")]
        for name in ("TONR Delay", "ADD__F", "Valve V1")
    }
    assert [pair for pair in values["TONR Delay"] if pair[0]] == [
        ("Delay.TimerEnable", "end"),
        ("Delay.PRE", "end"),
        ("Delay.ACC", None),
        ("Delay.DN", None),
    ]
    assert [pair for pair in values["ADD__F"] if pair[0]] == [("N", "end"), (r"\P.FBD_Blocks_1_2", None)]
    assert [pair for pair in values["Valve V1"] if pair[0]] == [("V1.Level", "end"), ("V1.Open", None)]


def test_an_element_has_the_lines_of_its_structured_text(made, picture):
    """What a question names by its line is found in the picture."""
    routine = next(each for each in made.routines if each.name == r"\P.Blocks")
    marked = {each.get("data-at") for each in picture.iter("{*}g") if each.get("data-at")}
    assert {rf"\P.Blocks.{number}" for number in routine.numbers} <= marked


def test_a_diagram_as_svg_is_drawn_above_its_text(made):
    routine = next(each for each in made.routines if each.name == r"\P.Blocks")
    text = routines_svg([(routine, routine.numbers)])
    root = etree.fromstring(text.encode())
    assert len([each for each in root.iter("{*}svg") if "fbd" in each.get("class", "")]) == 1
    assert "TONR(Delay);" in text


def test_a_pin_with_an_odd_name_has_no_value(imported):
    """Studio does not write such a name, and a file may have it; the rest of the diagram is drawn."""
    content = block("ADD", 0, "Sum", pins="SourceA bad] Dest")
    routines = ladder("Main", "JSR(Blocks,0);"), sheets("Blocks", content)
    found = imported(
        document(tags=[tag("Sum", "FBD_MATH")], programs=[program("P", *routines)], tasks=[task("T", "P")])
    )
    shown, answer = Catalog(found.controller).show(r"\P.Blocks", 100)
    assert shown.names == ("Sum.SourceA", "Sum.Dest")
    assert ">bad]<" in answer["diagram"]
