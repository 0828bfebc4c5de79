"""Words of instructions in an add-on instruction are not taken for its tags."""

import pytest
from l5x_files import add_on, document, ladder, tag


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
