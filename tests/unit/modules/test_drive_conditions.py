"""The conditions of a drive, from the rack's timeline and by orders; docs/drives.md#conditions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from drive_unit import ENABLE, VALID, Unit
from scanrack.io_images.amci3601 import InputBit
from scanrack.io_images.image import Image, signed_word
from scanrack.io_images.site import SettingError
from scanrack.jobs.load.building import build_rack
from scanrack.runtime.config.rackspec import RackSpec
from scanrack.runtime.loop.exposed import ExposedModule
from scanrack.runtime.loop.incidents import FaultKind, InjectedFault
from scanrack.runtime.machine import MachineSpec, Switch
from scanrack.runtime.modules.drives.conditions import DriveConditions, states
from scanrack.runtime.modules.drives.drive import DriveUnit
from scanrack.runtime.modules.drives.record import RECORDS
from scanrack.watch.monitors.hello import incidents_of

MS = 1_000_000
SHOWN = {
    "temperature=95": "TEMPERATURE_90C",
    "driver_fault=on": "DRIVER_FAULT",
    "encoder_error=on": "ENCODER_ERROR",
    "connection=lost": "POSITION_INVALID",
    "stall=now": "STALL_DETECTED",
    "cable=lost": "POSITION_INVALID",
    "in1=on": "INPUT_1",
    "in2=on": "INPUT_2",
}
"""A state, and the status bit that shows it [17 p. 84; SMD p. 83]."""


def exposed(drive: DriveUnit, *incidents: InjectedFault) -> ExposedModule:
    return ExposedModule(drive, incidents, DriveConditions(drive))


def around(state: str, at_ms: int = 40) -> InjectedFault:
    return InjectedFault(at_ms * MS, FaultKind.CONDITION, state=state)


def jogging(drive: ExposedModule, until_ms: int = 60) -> Image:
    """Configure with stall detection, preset, jog; return the inputs in the end."""
    configuration = (VALID[0] | 1 << 10 | 1 << 13, *VALID[1:6], 4096, *VALID[7:])
    jog = (1 << 7, ENABLE, 0, 0, 5, 0, 50, 50, 0, 0)
    begins = {0: configuration, 5: (0, ENABLE, *8 * (0,)), 10: (1 << 9, ENABLE, *8 * (0,)), 20: jog}
    outputs, inputs = Image(size=10), Image(size=10)
    for ms in range(until_ms):
        if ms in begins:
            for at, word in enumerate(begins[ms]):
                outputs[at] = signed_word(word)
        inputs = drive.update(ms * MS, outputs)
    return inputs


def is_on(drive: DriveUnit, inputs: Image, bit: str) -> bool:
    at = drive.model.words.groups["status"][bit]
    return inputs.bit(at.word, at.bit)


@pytest.mark.parametrize(("state", "bit"), SHOWN.items())
def test_the_timeline_sets_what_is_around_a_drive(state: str, bit: str) -> None:
    for incidents, expected in (((), False), ((around(state),), True)):
        drive = Unit().drive
        inputs = jogging(exposed(drive, *incidents))
        assert is_on(drive, inputs, bit) is expected


def test_a_switch_of_the_shaft_is_wired_while_the_rack_runs() -> None:
    drive = Unit().drive
    module = exposed(drive, around("in1=-100000..100000"), around("in1=off", 55))
    assert is_on(drive, jogging(module, 50), "INPUT_1")
    drive = Unit().drive
    assert not is_on(drive, jogging(exposed(drive, around("in1=on"), around("in1=off", 50))), "INPUT_1")


@pytest.mark.parametrize("model", [record.name for record in RECORDS])
def test_each_state_is_accepted_or_refused_by_what_the_model_lacks(model: str) -> None:
    drive = Unit(model).drive
    for name, known in states().items():
        incident = around(f"{name}={known[0]}")
        if model == "anf2" and name not in {"cable", "connection", "power", "encoder"}:
            with pytest.raises(ValueError, match="the ANF2 lacks the status bit"):
                exposed(drive, incident)
        else:
            exposed(drive, incident)


@pytest.mark.parametrize(
    ("state", "words"),
    {
        "temperature=warm": "-273 to 1,000",
        "cable=cut": "lost or connected",
        "humidity=3": "choose from in1, in2, driver_fault",
        "stall": "NAME=STATE",
    }.items(),
)
def test_a_wrong_state_is_refused_with_what_is_allowed(state: str, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        exposed(Unit().drive, around(state))


def test_an_input_of_the_machine_and_a_missing_encoder_are_refused() -> None:
    machine = MachineSpec(switches=(Switch(InputBit.HOME, 0, 10),))
    with pytest.raises(ValueError, match=r"in1 is wired to the machine \(home\)"):
        exposed(Unit(machine=machine).drive, around("in1=on"))
    without = Unit(encoder_fitted=False).drive
    with pytest.raises(ValueError, match="no encoder"):
        exposed(without, around("encoder=-400"))


def test_an_entry_has_a_state_and_no_duration() -> None:
    with pytest.raises(SettingError, match="name the state"):
        InjectedFault(0, FaultKind.CONDITION)
    with pytest.raises(SettingError, match="another entry"):
        InjectedFault(0, FaultKind.CONDITION, for_ns=MS, state="stall=now")
    with pytest.raises(SettingError, match="go together"):
        InjectedFault(0, FaultKind.POWER_CYCLE, state="stall=now")


def rack(module: str, **incident: Any) -> RackSpec:
    slot = {"number": 1, "module": module}
    given = [{"at_ms": 1, "what": "condition", **incident}] if incident else []
    return RackSpec.model_validate({"program": "p.py", "scan_ms": 1, "slot": [slot], "incident": given})


def test_a_rack_file_sets_conditions_and_a_3601_has_none(tmp_path: Path) -> None:
    spec = rack("smd24e2", state="cable=lost")
    assert spec.incidents == (InjectedFault(MS, FaultKind.CONDITION, 1, state="cable=lost"),)
    build_rack(spec)
    with pytest.raises(ValueError, match="condition does not apply to Amci3601"):
        build_rack(rack("amci3601", state="cable=lost"))


def test_a_lost_link_of_a_drive_names_its_conditions() -> None:
    drive = Unit().drive
    with pytest.raises(ValueError, match=r"link-lost does not apply to DriveUnit; .* cable=lost"):
        exposed(drive, InjectedFault(0, FaultKind.LINK_LOST))


def test_a_page_sets_conditions_by_choice_or_as_text() -> None:
    (condition,) = [each for each in incidents_of(rack("ang1")) if each["name"] == "condition"]
    assert "cable=lost" in condition["fields"][1]["choices"]
    assert condition["fields"][1]["kind"] == "text"
    assert all(each["name"] != "condition" for each in incidents_of(rack("amci3601")))


def test_an_order_while_it_runs_is_checked_and_acts() -> None:
    drive = Unit().drive
    module = exposed(drive)
    with pytest.raises(ValueError, match="choose from"):
        module.happen(around("humidity=3", 0))
    module.happen(around("temperature=95", 0))
    assert is_on(drive, jogging(module, 10), "TEMPERATURE_90C")
    (event,) = [each for each in module.events if each.kind == "stimulus"]
    assert (event.name, event.fields["state"]) == ("condition", "temperature=95")
