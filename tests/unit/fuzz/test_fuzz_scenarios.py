"""Scenarios as data: written and read, laid over a rack, and put into a rack file."""

import json
import tomllib
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scanrack.io_images.amci3601 import InputBit
from scanrack.jobs import Kind, LostSteps, SwitchOffset, kinds_for
from scanrack.jobs.fuzz import Press, Scenario
from scanrack.jobs.fuzz.drawing import scenarios
from scanrack.jobs.fuzz.scenarios.rackdoc import rack_text
from scanrack.jobs.fuzz.scenarios.words import described
from scanrack.runtime import FaultKind, InjectedFault, load_rack_file
from scanrack.runtime.loop.incidents import ON_THE_LINE
from scanrack.runtime.machine import Slip, Switch, TimelineEntry

MS = 1_000_000
RACK = """program = "line.py"
scan_ms = 2
[[slot]]
number = 1
module = "amci3601"
[slot.machine]
switches = [{ input = "home", first = 100, last = 110 }, { input = "cw_limit", first = 900 }]
timeline = [{ at_s = 1, input = "estop", for_ms = 20 }]
stations = [{ position = 500, input = "capture", work_ms = 3, pulse_ms = 2 }]
[[slot]]
number = 4
module = "amci3601"
firmware = "3.1"
[[slot]]
number = 7
module = "pcl601-adapter"
"""


@pytest.fixture(scope="module")
def rack_file(tmp_path_factory):
    file = tmp_path_factory.mktemp("rack") / "rack.toml"
    file.write_text(RACK, encoding="utf-8")
    return file


@pytest.fixture(scope="module")
def spec(rack_file):
    return load_rack_file(rack_file).spec


def test_a_press_on_a_free_input_leaves_it_as_it_was_before(spec):
    press = Press(1, InputBit.ESTOP, True, 1010 * MS, 4 * MS)  # while the rack file's own press lasts
    slot = Scenario(presses=(press,)).laid_over(spec).slot[0]
    assert slot.machine.timeline[-2:] == (
        TimelineEntry(1010 * MS, InputBit.ESTOP, True),
        TimelineEntry(1014 * MS, InputBit.ESTOP, True),
    )


def test_a_press_on_a_switch_is_a_fault_of_it_for_a_time(spec):
    press = Press(1, InputBit.HOME, False, 10 * MS, 4 * MS)
    slot = Scenario(presses=(press,)).laid_over(spec).slot[0]
    assert slot.machine.timeline[-1] == TimelineEntry(14 * MS, InputBit.HOME, None)


def test_shifts_and_losses_go_to_their_slot(spec):
    laid = Scenario(shifts=(SwitchOffset(1, -10),), lost=(LostSteps(1, 7, 2),)).laid_over(spec)
    machine = laid.slot[0].machine
    assert machine.switches == (Switch(InputBit.HOME, 90, 100), Switch(InputBit.CW_LIMIT, 890, None))
    assert machine.stations[0].position == 490
    assert machine.slips == (Slip(7, 2),)
    assert laid.slot[1] == spec.slot[1]


def test_incidents_come_after_those_of_the_rack_file(spec):
    incident = InjectedFault(3 * MS, FaultKind.TORN_UPDATE, 4, 0, (2, 3))
    assert Scenario(incidents=(incident,)).laid_over(spec).incidents == (incident,)


def any_scenario(spec):
    return scenarios(spec, 500, frozenset(Kind))


@pytest.mark.slow
@given(data=st.data())
def test_every_scenario_belongs_to_its_rack_and_can_be_told(spec, data):
    scenario = data.draw(any_scenario(spec))
    scenario.check(spec)
    lines = described(scenario)
    assert len(lines) == max(1, scenario.size)
    for part, slots in ((scenario.lost, (1, 4)), (scenario.firmware, (1, 4))):
        assert {getattr(each, "slot", None) or each[0] for each in part} <= set(slots)
    on_the_line = {each.slot for each in scenario.incidents if each.what in ON_THE_LINE}
    assert on_the_line <= {7}


@pytest.mark.slow
@given(data=st.data())
def test_json_and_back_is_the_same(spec, data):
    scenario = data.draw(any_scenario(spec))
    assert Scenario.from_json(json.loads(json.dumps(scenario.to_json()))) == scenario


@pytest.mark.slow
@given(data=st.data())
def test_a_rack_file_with_a_scenario_says_the_same_as_the_objects(spec, rack_file, data):
    scenario = data.draw(any_scenario(spec))
    text = rack_text(rack_file, spec, scenario, 500, rack_file.parent)
    written = rack_file.with_name("written.toml")
    written.write_text(text, encoding="utf-8")
    assert tomllib.loads(text)["run_for_s"] == 1
    laid = scenario.laid_over(spec)
    read = load_rack_file(written).spec
    assert [(each.firmware, each.machine) for each in read.slot] == [
        (each.firmware, each.machine) for each in laid.slot
    ]
    assert read.incidents == laid.incidents


def test_programs_are_found_from_the_folder_of_a_failure(tmp_path):
    """The rack's own and those of the units beside it; one unit has none."""
    units = '[[unit]]\nprogram = "units/press.pclt"\n[[unit]]\naddress = 2\n'
    rack_file = tmp_path / "rack.toml"
    rack_file.write_text(RACK + units, encoding="utf-8")
    folder = tmp_path / "failures" / "one"
    text = rack_text(rack_file, load_rack_file(rack_file).spec, Scenario(), 10, folder)
    document = tomllib.loads(text)
    assert (folder / document["program"]).resolve() == tmp_path / "line.py"
    assert (folder / document["unit"][0]["program"]).resolve() == tmp_path / "units" / "press.pclt"
    assert document["unit"][1] == {"address": 2}


@given(data=st.data())
def test_a_base_is_varied_part_by_part(spec, data):
    base = Scenario(presses=(Press(1, InputBit.ESTOP, True, 0, MS),), lost=(LostSteps(4, 0, 1),))
    varied = data.draw(scenarios(spec, 500, [], base=base))
    assert {replace(each, at_ns=0) for each in varied.presses} <= set(base.presses)
    assert all(0 <= each.at_ns <= 100 * spec.scan_ns for each in varied.presses)
    assert set(varied.lost) <= set(base.lost)


def test_torn_updates_belong_to_a_controller_that_does_not_wait(spec):
    assert Kind.TORN not in kinds_for(spec)
    assert Kind.TORN in kinds_for(spec.model_copy(update={"controller": "compactlogix"}))


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"press": []}, "unknown key press; choose from firmware, presses"),
        ({"presses": [{"slot": 1}]}, "input"),
        ({"incidents": [{"at_ns": 0, "what": "flood"}]}, "flood"),
        (
            {"incidents": [{"at_ns": 0, "what": "torn-update", "late_words": [250]}]},
            r"late_words \[250\] are not allowed: 0 to 249",
        ),
        ({"firmware": {"1": "9.9"}}, "unknown 3601 firmware '9.9'"),
        ({"shifts": [{"slot": True, "steps": 2}]}, r"shifts\.0\.slot = True: .* valid integer"),
        ({"shifts": [{"slot": 1}]}, r"^scenario: key shifts\.0\.steps is missing$"),
        ({"lost": [{"slot": 1, "at": 0, "steps": 1, "times": 2}]}, r"lost\.0\.times = 2: "),
        (5, "^scenario: 5: must be an object with firmware, presses, .*$"),
    ],
)
def test_json_that_is_no_scenario_is_refused(given, says):
    with pytest.raises(ValueError, match=says):
        Scenario.from_json(given)
