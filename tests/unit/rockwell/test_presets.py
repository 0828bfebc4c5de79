"""PRE and ACC that stand in rungs, as exports show them."""

import pytest
from l5x_files import add_on, after, data_type, machine, member, parameter, tag, value

CELL = data_type("Cell", member("Delay", "TIMER"), member("Waits", "TIMER", 4))


@pytest.mark.parametrize(
    ("rung", "preset"),
    [
        ("TON(Delays[2],5000,0);", "Delays[2].PRE"),
        ("TON(Cells[1].Delay,5000,0);", "Cells[1].Delay.PRE"),
        ("TON(Cells[1].Waits[3],5000,0);", "Cells[1].Waits[3].PRE"),
    ],
)
def test_a_preset_of_an_element_is_its_initial_value(imported, rung, preset):
    tags = [tag("Delays", "TIMER", "4"), tag("Cells", "Cell", "3")]
    found = imported(machine(rung, types=[CELL], tags=tags))
    assert (found.report.refused, found.report.ran) == ([], 1)
    said = after(found)
    assert said[preset] == 5000
    first = preset.replace("[2]", "[0]").replace("[1]", "[0]")
    assert said[first] == 0


def test_a_preset_of_a_computed_element_stands_in_the_tags_data_alone(imported):
    tags = [tag("Delays", "TIMER", "4"), tag("Step", "DINT", data=value("DINT", 3))]
    found = imported(machine("TON(Delays[Step],5000,0);", tags=tags))
    assert (found.report.refused, found.report.ran) == ([], 1)
    assert [after(found)[f"Delays[{place}].PRE"] for place in range(4)] == [0, 0, 0, 0]


def test_the_first_of_two_presets_counts(imported):
    rungs = ("TON(Delay,5000,0);", "[XIC(Delay.DN),TON(delay,700,0)];")
    found = imported(machine(*rungs, tags=[tag("Delay", "TIMER")]))
    assert (found.report.refused, found.report.ran) == ([], 2)
    assert after(found)["Delay.PRE"] == 5000


def test_a_control_of_two_instructions_has_one_length(imported):
    rungs = ("FFL(1,Queue[0],Control,6,0);", "BSL(Bits[0],Control,Bits[0].0,32);")
    tags = [tag("Queue", "DINT", "8"), tag("Bits", "DINT", "2"), tag("Control", "CONTROL")]
    found = imported(machine(*rungs, tags=tags))
    assert (found.report.refused, found.report.ran) == ([], 2)
    assert after(found)["Control.LEN"] == 6


def test_presets_in_an_add_on_instruction(imported):
    block = add_on(
        "Waits",
        [parameter("Passed", "TIMER", "InOut")],
        [tag("Own", "TIMER", "3").replace("Tag", "LocalTag")],
        '<Routine Name="Logic" Type="RLL"><RLLContent><Rung Number="0" Type="N"><Text>'
        "TON(Passed,5000,0)TON(Own[1],300,0);</Text></Rung></RLLContent></Routine>",
    )
    tags = [tag("Instances", "Waits", "2"), tag("Delay", "TIMER")]
    found = imported(machine("Waits(Instances[1],Delay);", add_ons=[block], tags=tags))
    assert (found.report.refused, found.report.ran) == ([], 2)
    said = after(found)
    assert said["Delay.PRE"] == 0
    assert [said[f"Instances[{place}].Own[1].PRE"] for place in (0, 1)] == [300, 300]
    assert [said[f"Instances[{place}].Own[2].PRE"] for place in (0, 1)] == [0, 0]
