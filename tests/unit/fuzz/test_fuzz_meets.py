"""The table "What a run can meet" of docs/fuzz-events.md: what is drawn for each module."""

from random import Random

import pytest
from scanrack.jobs import Kind
from scanrack.jobs.fuzz.aim.draws import Draws
from scanrack.jobs.fuzz.scenarios.parts import parts_of
from scanrack.runtime import RackSpec

ANALOG = {"inputs": {"level": 0}, "ranges": {"level": "4..20 mA"}}
CONTACTS = {"inputs": {"start": 0}}
ANYWHERE = {"power-cycle", "program-mode", "torn-update"}
BOLTED = {"presses", "shifts"}
AT_A_3601 = {"firmware", "lost", "link-lost", "removed", "fatal-error"}
ON_A_LINE = {"line-down", "replies-lost", "replies-damaged", "controller-power-cycle"}


@pytest.mark.parametrize(
    ("module", "options", "meets"),
    [
        pytest.param("amci3601", {}, BOLTED | AT_A_3601, id="3601"),
        pytest.param("pcl601-adapter", {}, BOLTED | ON_A_LINE, id="pcl601"),
        pytest.param("pmc006-adapter", {}, BOLTED | ON_A_LINE, id="pmc006"),
        pytest.param("1769-IQ16", CONTACTS, {"pushes"}, id="contacts"),
        pytest.param("1769-IF4", ANALOG, {"signals"}, id="analog"),
    ],
)
def test_each_module_meets_what_the_table_says(module, options, meets):
    slot = {"number": 1, "module": module, "options": options}
    spec = RackSpec.model_validate({"program": "none.py", "slot": [slot]})
    draws = Draws(spec, 500, frozenset(Kind), Random(1))
    drawn = [part for _ in range(300) for part in parts_of(draws.scenario())]
    found = {part.what.value if field == "incidents" else field for field, part in drawn}
    assert found == meets | ANYWHERE


def test_an_analog_input_meets_a_broken_wire():
    slot = {"number": 1, "module": "1769-IF4", "options": ANALOG}
    spec = RackSpec.model_validate({"program": "none.py", "slot": [slot]})
    draws = Draws(spec, 500, {Kind.INPUTS}, Random(1))
    values = {part.value for _ in range(100) for _, part in parts_of(draws.scenario())}
    assert {0.0, 3.2, 22.0} <= values
