"""Words of instructions in an add-on instruction are not taken for its tags."""

import pytest
from l5x_files import add_on, after, document, ladder, parameter, program, structured, tag


@pytest.mark.parametrize("passes", ["ALL", "INC", "2"])
def test_passes_of_a_file_instruction(imported, passes):
    local = [
        tag("Control", "CONTROL").replace("Tag", "LocalTag"),
        tag("Numbers", "DINT", "4").replace("Tag", "LocalTag"),
    ]
    text = f"FAL(Control,4,0,{passes},Numbers[Control.POS],Control.POS+1);"
    block = add_on("Counts", [], local, ladder("Logic", text))
    found = imported(document(target="AddOnInstructionDefinition", add_ons=[block]))
    assert (found.report.refused, found.report.ran) == ([], 1)


def test_true_and_false(imported):
    text = "Yes := TRUE; No := False OR NOT true;"
    outputs = [parameter(name, "BOOL", "Output", required=False) for name in ("Yes", "No")]
    block = add_on("Truths", outputs, [], structured("Logic", text))
    main = program("Main", ladder("Main", "Truths(T);"))
    found = imported(document(add_ons=[block], tags=[tag("T", "Truths")], programs=[main]))
    assert (found.report.objects, found.report.ran) == ([], 1)
    assert (after(found)["T.Yes"], after(found)["T.No"]) == (True, False)


@pytest.mark.slow
@pytest.mark.parametrize("attribute", ["Vendor", "RevisionExtendedText"])
def test_texts_of_the_definition_are_empty(imported, attribute):
    outputs = [parameter("Same", "BOOL", "Output", required=False)]
    local = [tag(name, "STRING").replace("Tag", "LocalTag") for name in ("Text", "Before")]
    rungs = ("CONCAT('a','b',Text);", f"GSV(AddOnInstructionDefinition,THIS,{attribute},Text);")
    block = add_on("Named", outputs, local, ladder("Logic", *rungs, "EQU(Text,Before)OTE(Same);"))
    main = program("Main", ladder("Main", "Named(T);"))
    found = imported(document(add_ons=[block], tags=[tag("T", "Named")], programs=[main]))
    assert (found.report.refused, after(found)["T.Same"]) == ([], True)
