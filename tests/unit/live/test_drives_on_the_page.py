"""A networked drive on the page: the inputs that are wired to it, and its conditions to choose.

Broken on purpose: six inputs of a 3601 for every axis, names of conditions of another table: red.
"""

import pytest
from scanrack.jobs.load.loading import load_spec
from scanrack.runtime.modules.drives.conditions import states
from scanrack.watch.monitors.hello import incidents_of, slots_of

RACK = """
name = "drives"
[[slot]]
number = 1
module = "{}"
{}
"""


def spec_of(tmp_path, module, options=""):
    (tmp_path / "rack.toml").write_text(RACK.format(module, options), encoding="utf-8")
    return load_spec(str(tmp_path / "rack.toml"), program="none.py")[0]


@pytest.mark.parametrize(
    ("module", "options", "titles"),
    [
        ("smd23e2", "", ["Home (in1)", "CW limit (in2)"]),
        ("smd23e2", 'options = { in1 = "estop", in2 = "capture" }', ["E-stop (in1)", "Capture (in2)"]),
        ("smd23e2", 'options = { in1 = "home", in2 = "home" }', ["Home (in1, in2)"]),
        ("anf2", "", ["Capture", "External", "Home", "CW limit", "CCW limit"]),
        ("amci3601", "", ["Capture", "External", "Home", "E-stop", "CW limit", "CCW limit"]),
    ],
)
def test_a_module_has_the_inputs_that_are_wired_to_it(tmp_path, module, options, titles):
    (slot,) = slots_of(spec_of(tmp_path, module, options))
    assert [each["title"] for each in slot["inputs"]] == titles


def test_conditions_are_one_field_that_offers_all_of_them(tmp_path):
    found = [each for each in incidents_of(spec_of(tmp_path, "smd23e2")) if each["name"] == "condition"]
    (card,) = found
    assert [each["name"] for each in card["fields"]] == ["slot", "state"]
    offered = {choice.partition("=")[0] for choice in card["fields"][1]["choices"]}
    assert offered == set(states())


def test_error_bits_are_named_and_no_other_ones(tmp_path):
    (slot,) = slots_of(spec_of(tmp_path, "smd23e2"))
    errors = {each["name"] for each in slot["bits"] if each["error"]}
    assert "DRIVER_FAULT" in errors
    assert "MODULE_OK" not in errors
