"""A served controller turns the shaft of a machine: its switches stop it, its people act on its inputs.

Broken on purpose: the machine not asked for its next change, its pins wired by hand: a test turns red.
"""

from __future__ import annotations

from pathlib import Path

import pytest
from scanrack.io_images.pcl601 import Code
from scanrack.jobs.run.served_units import Unit, pcl601_units, pmc006_units
from scanrack.jobs.serve.machines import on_machines

MS = 1_000_000
PROGRAM = 'program = "none.py"\n'
MACHINE = """
program = "none.py"
[[slot]]
number = 1
module = "{module}"

[slot.machine]
switches = [{switches}]
timeline = [{timeline}]
"""


def rack(
    folder: Path, *, module: str = "amci3601", switches: str = "", timeline: str = "", name: str = "m.toml"
) -> str:
    file = folder / name
    file.write_text(MACHINE.format(module=module, switches=switches, timeline=timeline), encoding="utf-8")
    return str(file)


def on_machine(file: str) -> Unit:
    (unit,) = on_machines(pcl601_units([], [], 1.0), [file])
    return unit


def do(unit: Unit, code: Code) -> None:
    assert unit.do is not None
    unit.do(code)


@pytest.mark.parametrize("module", ["amci3601", "pcl601-adapter"])
def test_a_limit_switch_stops_the_motor_where_it_closes(tmp_path: Path, module: str) -> None:
    unit = on_machine(rack(tmp_path, module=module, switches='{ input = "cw_limit", first = 3000 }'))
    do(unit, Code.GO_SLEW)  # 500 to 5,000 steps/s: some 700 ms to there
    unit.device.advance(5000 * MS)
    assert (unit.device.motor_position, unit.device.motor_turns) == (3000, False)


def test_a_normally_closed_limit_leaves_the_hard_limit_open(tmp_path: Path) -> None:
    closed = '{ input = "cw_limit", first = 3000, normally_closed = true }'
    unit = on_machine(rack(tmp_path, switches=closed))
    do(unit, Code.GO_SLEW)
    unit.device.advance(5000 * MS)
    assert unit.device.motor_position > 3000


@pytest.mark.parametrize("steps_ms", [1, 37, 1000], ids=["each ms", "each 37 ms", "at once"])
def test_people_act_at_their_times_however_often_the_line_is_looked_at(tmp_path: Path, steps_ms: int) -> None:
    """Input 3 is grounded while the external input is energized, from 120 ms to 130 ms; the motor begins at 0
    and stops at the end of travel at 3,000 steps: 1 s is before that at no speed above 500 steps/s.
    """
    on = '{ at_s = 0.12, input = "external", energized = true }'
    off = '{ at_s = 0.13, input = "external", energized = false }'
    unit = on_machine(rack(tmp_path, timeline=f"{on}, {off}", switches='{ input = "home", first = 9000 }'))
    levels: dict[int, int] = {}
    for until in (119, 121, 131):
        for now in [*range(max(0, until - 120), until, steps_ms), until]:
            unit.device.advance(max(now, *levels, 0) * MS)
        levels[until] = unit.values()["inputs"] >> 2 & 1
    assert levels == {119: 0, 121: 1, 131: 0}


def test_a_pmc006_is_wired_as_its_adapter(tmp_path: Path) -> None:
    """The end limit pulls EXT2 low: at 500 steps it is high, from 2,000 on low."""
    file = rack(tmp_path, module="pmc006-adapter", switches='{ input = "cw_limit", first = 0 }')
    (unit,) = on_machines(pmc006_units([], [], 1.0), [file])
    (bare,) = pmc006_units([], [], 1.0)
    assert unit.values()["levels"] != bare.values()["levels"]
    with pytest.raises(ValueError, match="the machine operates this input, like all of ext1, ext2, fset"):
        unit.wire("ext2", "high")


def test_other_pins_are_wired_by_hand(tmp_path: Path) -> None:
    unit = on_machine(rack(tmp_path, switches='{ input = "home", first = 9000 }'))
    unit.wire("in1", "open")
    with pytest.raises(ValueError, match="home: the machine operates this input"):
        unit.wire("home", "ground")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("m.toml", "must be ADDRESS:FILE if several units are served"),
        ("7:m.toml", "no unit 7; addresses: 1, 2"),
        ("1:none.toml", "none.toml"),
        ("1:two.toml", "2 slots have an amci3601; only one may"),
        ("1:card.toml", "no slot has a pcl601-adapter or an amci3601"),
        ("1:slips.toml", "slips and jams are simulated with module amci3601 only"),
    ],
)
def test_what_is_no_machine_of_a_unit(tmp_path: Path, monkeypatch, text: str, said: str) -> None:
    monkeypatch.chdir(tmp_path)
    rack(tmp_path)
    slot = '[[slot]]\nnumber = {}\nmodule = "{}"\n'
    Path("two.toml").write_text(
        PROGRAM + slot.format(1, "amci3601") + slot.format(2, "amci3601"), encoding="utf-8"
    )
    Path("card.toml").write_text(PROGRAM + slot.format(1, "1762-IQ8"), encoding="utf-8")
    Path("slips.toml").write_text(
        PROGRAM + slot.format(1, "amci3601") + "[slot.machine]\nslips = [{ at = 100, steps = 3 }]\n",
        encoding="utf-8",
    )
    with pytest.raises(ValueError, match=said):
        on_machines(pcl601_units([1, 2], [], 1.0), [text])


def test_of_several_units_each_has_its_own(tmp_path: Path) -> None:
    near = rack(tmp_path, switches='{ input = "cw_limit", first = 1000 }', name="near.toml")
    units = on_machines(pcl601_units([1, 2], [], 1.0), [f"2:{near}"])
    for unit in units:
        do(unit, Code.GO_SLEW)
        unit.device.advance(5000 * MS)
    assert units[0].device.motor_position > 1000
    assert units[1].device.motor_position == 1000
    with pytest.raises(ValueError, match="unit 2 already has a machine"):
        on_machines(units, [f"2:{near}"])
