"""The fuzz search gives analog inputs other values for a time, and writes down which."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import pytest
from hypothesis import find
from scanrack.commands import build
from scanrack.jobs import Kind, Scenario, build_cpu, build_rack, possible_kinds
from scanrack.jobs.fuzz.drawing import scenarios
from scanrack.jobs.fuzz.scenarios.kinds import card_signals
from scanrack.jobs.fuzz.scenarios.rackdoc import rack_text
from scanrack.jobs.fuzz.scenarios.scenario import Signal
from scanrack.jobs.fuzz.scenarios.words import described
from scanrack.jobs.fuzz.shrink import parts_of, scenario_of, simpler_parts
from scanrack.runtime import RackSpec, SlotSpec, parse_rack_file
from typer.testing import CliRunner

MS = 1_000_000
OPTIONS: Any = {
    "inputs": {"level": 0, "count": 1},
    "ranges": {"level": "4..20 mA"},
    "timeline": [{"at_ms": 4, "input": "level", "value": 12}],
}
RACK = RackSpec(program=lambda scan: None, slot=(SlotSpec(number=2, module="1769-IF4", options=OPTIONS),))
HIGH = Scenario(signals=(Signal(2, "level", 20.5, 20 * MS, 10 * MS),))


def test_values_at_the_ends_of_the_range_and_beyond_them_are_tried() -> None:
    values = {
        name: [each[2] for each in card_signals(RACK) if each[1] == name] for name in ("level", "count")
    }
    assert {4.0, 20.0, 12.0, 20.16, 3.84, 21.0, 3.2, 0.0, 22.0} == set(values["level"])
    assert {0.0, 32_767.0, -32_768.0} < set(values["count"])
    assert Kind.INPUTS in possible_kinds(RACK)
    assert find(scenarios(RACK, 100, {Kind.INPUTS}), lambda found: bool(found.signals)).pushes == ()


def test_a_signal_is_what_the_program_sees_and_goes_again() -> None:
    """From 20 to 30 ms, scans 10 to 14 of 2 ms; before and after it is the rack file's 12 mA."""
    seen: list[tuple[int, bool]] = []

    def logic(scan: Any) -> None:
        inputs = scan.slot[2].inputs
        seen.append((inputs[0], inputs.bit(5, 14)))

    build_cpu(RACK, logic, build_rack(HIGH.laid_over(RACK))).run(20)
    steady, high = int(12 / 21 * 32767), int(20.5 / 21 * 32767)
    assert [over for _, over in seen] == [10 <= scan < 15 for scan in range(20)]
    assert [value for value, _ in seen[2:]] == [high if 10 <= scan < 15 else steady for scan in range(2, 20)]


def test_a_signal_is_written_and_read_again(tmp_path: Path) -> None:
    assert Scenario.from_json(HIGH.to_json()) == HIGH == scenario_of(parts_of(HIGH))
    assert described(HIGH) == ["0.02 s: input level of slot 2 is 20.5 for 10 ms"]
    file = tmp_path / "rack.toml"
    file.write_text(
        'program = "p"\n[[slot]]\nnumber = 2\nmodule = "1769-IF4"\n[slot.options]\ninputs = { level = 1 }\n'
        'ranges = { level = "0..10 V" }\n',
        encoding="utf-8",
    )
    spec = parse_rack_file(file.read_text(encoding="utf-8"), file).spec
    (slot,) = tomllib.loads(rack_text(file, spec, HIGH, 100, tmp_path))["slot"]
    assert slot["options"]["timeline"] == [
        {"at_ms": 20, "input": "level", "value": 20.5},
        {"at_ms": 30, "input": "level", "value": 0},
    ]


def test_a_signal_of_another_rack_is_refused() -> None:
    HIGH.check(RACK)
    with pytest.raises(ValueError, match="slot 2 has no analog input 'speed', only level, count"):
        Scenario(signals=(Signal(2, "speed", 1, 0, MS),)).check(RACK)
    with pytest.raises(ValueError, match="no slot 7"):
        Scenario(signals=(Signal(7, "level", 1, 0, MS),)).check(RACK)


def test_rounder_values_are_simpler() -> None:
    values = [part.value for part in simpler_parts(Signal(2, "count", 31_206, 0, MS), {}, 2 * MS)]
    assert values[:3] == [0, 1, 2]
    assert 31_000 in values


PROGRAM = """
def logic(scan):
    assert not scan.slot[2].inputs.bit(5, 14), "the tank runs over"
"""


def test_a_signal_breaks_a_program(tmp_path: Path) -> None:
    (tmp_path / "tank.py").write_text(PROGRAM, encoding="utf-8")
    (tmp_path / "rack.toml").write_text(
        'program = "tank.py"\nrun_for_s = 0.05\n[[slot]]\nnumber = 2\nmodule = "1769-IF4"\n[slot.options]\n'
        'inputs = { level = 0 }\nranges = { level = "4..20 mA" }\n',
        encoding="utf-8",
    )
    (tmp_path / "high.json").write_text(json.dumps(HIGH.to_json()), encoding="utf-8")
    words = [
        "fuzz",
        tmp_path / "rack.toml",
        "--scenario",
        tmp_path / "high.json",
        "--out",
        tmp_path / "found",
    ]
    result = CliRunner().invoke(build(), [str(word) for word in words])
    assert result.exit_code == 1, result.output
    assert "the tank runs over" in result.output
