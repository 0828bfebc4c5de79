"""Tags of every kind on record: packed bits, instances, arrays, aliases, strings, values that do not fit."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest
from scanrack.commands import build
from scanrack.jobs import open_bench
from scanrack.jobs.bench import Bench
from scanrack.ladder import LadderError
from scanrack.ladder.debug.tag_values import tag_values
from scanrack.ladder.files import parse_program
from scanrack.traces import open_trace, read_columns
from typer.testing import CliRunner

PACKED = """
PROGRAM line
TYPE Flags (Host : SINT HIDDEN, Ready : BOOL AT Host.0, Busy : BOOL AT Host.7, Count : DINT)
TYPE Cell (Inner : Flags[2], Name : STRING, Delay : TIMER, Limit : DINT AT Delay.PRE)
TAG F : Flags
TAG One : Cell
TAG Cells : Cell[3]
ALIAS IsReady : F.Ready
ALIAS Second : Cells[1]
ALIAS Third : F.Count.3
ALIAS Lamp : Local:1:O.Data[0].3
ROUTINE Main
XIO(F.Ready)XIO(F.Busy)OTE(F.Busy);
ADD(F.Count,1,F.Count)EQU(F.Count,3)OTE(F.Ready);
EQU(F.Count,2)OTL(Cells[1].Inner[1].Busy);
MOV(50,Cells[1].Delay.PRE);
TON(Cells[1].Delay,?,?);
END
"""


def names(*patterns: str) -> list[tuple[str, str, int]]:
    layout = parse_program(PACKED).build().layout
    return [(each.name, each.type, each.length) for each in tag_values(layout, patterns)]


def test_a_structure_is_recorded_by_its_bits_and_not_by_their_hidden_host() -> None:
    assert names("F") == [("F.Ready", "BOOL", 0), ("F.Busy", "BOOL", 0), ("F.Count", "DINT", 0)]
    assert [name for name, *_ in names("*") if "Host" in name] == []


def test_arrays_of_structures_are_arrays_of_bits() -> None:
    assert ("Cells[0..2].Inner[0..1].Busy", "BOOL", 6) in names("Cells")
    assert names("Cells[1].Inner[1].Busy") == [("Cells[1].Inner[1].Busy", "BOOL", 0)]
    assert names("Cells[1].Inner")[:2] == [
        ("Cells[1].Inner[0..1].Ready", "BOOL", 2),
        ("Cells[1].Inner[0..1].Busy", "BOOL", 2),
    ]


def test_a_string_in_an_element_is_a_text() -> None:
    assert ("Cells[1].Name", "TEXT", 0) in names("Cells[1]")
    assert [name for name, kind, _ in names("Cells") if kind == "TEXT"] == [
        f"Cells[{at}].Name" for at in range(3)
    ]


def test_a_second_name_of_a_member_is_recorded_where_it_is_one_value() -> None:
    assert names("One.Limit") == [("One.Limit", "DINT", 0)]
    assert names("Cells[2].Limit") == [("Cells[2].Limit", "DINT", 0)]


def test_an_alias_is_its_target_and_a_bit_of_a_number_its_word() -> None:
    assert names("IsReady") == [("F.Ready", "BOOL", 0)]
    assert names("Second.Delay.ACC") == [("Cells[1].Delay.ACC", "DINT", 0)]
    assert names("Third") == [("F.Count", "DINT", 0)]


@pytest.mark.parametrize("pattern", ["Lamp", "Local:1:O.Data[0].3", "O:1.0/3"])
def test_a_part_of_an_image_says_where_it_is(pattern: str) -> None:
    with pytest.raises(LadderError, match="a part of slot 1's images, which every trace has"):
        names(pattern)


def record(folder: Path, program: str, tags: str, acts: Any, suffix: str = "rung") -> Mapping[str, Any]:
    """Return the recorded tags of what a bench does."""
    (folder / f"line.{suffix}").write_text(program, encoding="utf-8")
    (folder / "rack.toml").write_text(
        f"program = 'line.{suffix}'\ntags = {tags}\n[[slot]]\nnumber = 1\nmodule = 'amci3601'\n",
        encoding="utf-8",
    )
    with open_bench(folder / "rack.toml", record=folder / "run.mcap") as bench:
        acts(bench)
    with open_trace(folder / "run.mcap") as trace:
        found = read_columns(trace, tags=True).tags
    assert found is not None
    return {name: found[name].tolist() for name in found.dtype.names or ()}


def test_packed_bits_are_recorded_as_they_are_in_every_scan(tmp_path: Path) -> None:
    """Busy turns over in every scan in which Ready is off; Ready is on in the scan of Count 3, below it."""
    found = record(tmp_path, PACKED, '["F", "Cells[1]"]', lambda bench: bench.scan(5))
    assert found["f_count"] == [1, 2, 3, 4, 5]
    assert found["f_ready"] == [False, False, True, False, False]
    assert found["f_busy"] == [True, False, True, False, True]
    assert found["cells_1_inner_busy"] == [[False, False], *[[False, True]] * 4]
    assert found["cells_1_delay_acc"] == [0, 2, 4, 6, 8]
    assert found["cells_1_limit"] == [50] * 5


def test_packed_bits_on_record_are_those_that_the_debugger_shows(tmp_path: Path) -> None:
    shown: list[tuple[object, ...]] = []

    def acts(bench: Bench) -> None:
        for _ in range(4):
            bench.scan(1)
            shown.append(tuple(bool(bench[tag]) for tag in ("F.Ready", "F.Busy", "Cells[1].Inner[1].Busy")))

    found = record(tmp_path, PACKED, '["F.*", "Cells[1].Inner[1].Busy"]', acts)
    columns = (found["f_ready"], found["f_busy"], found["cells_1_inner_1_busy"])
    assert list(zip(*columns, strict=True)) == shown


INSTANCES = """
PROGRAM line
INSTRUCTION Pulse
INPUT Every : DINT REQUIRED
OUTPUT Out : BOOL
LOCAL Passed : DINT
ROUTINE Logic
ADD(Passed,1,Passed);
GEQ(Passed,Every)CLR(Passed)OTE(Out);
END
END INSTRUCTION
TAG A : Pulse
TAG B : Pulse
ROUTINE Main
Pulse(A,2);
Pulse(B,3);
END
"""


def test_tags_in_an_add_on_instance_are_recorded_each_by_its_own(tmp_path: Path) -> None:
    """A is on in every second scan, B in every third one."""
    found = record(tmp_path, INSTANCES, '["A.Out", "B.Out", "A.Passed"]', lambda bench: bench.scan(6))
    assert found["a_out"] == [False, True] * 3
    assert found["b_out"] == [False, False, True] * 2
    assert found["a_passed"] == [1, 0] * 3


NOT_FITTING = """
from enum import Enum


class Step(Enum):
    IDLE = 0
    FILL = 1


class Line:
    def __init__(self):
        self.count = 0
        self.flag = False
        self.level = 0.5
        self.step = Step.IDLE
        self.name = "water"
        self.gone = 1


line = Line()


def logic(scan):
    n = scan.number
    line.count = 2**63 if n == 2 else n
    line.flag = "yes" if n == 3 else True
    line.level = "high" if n == 4 else n / 2
    line.step = 7 if n == 5 else Step.FILL
    line.name = 5 if n == 6 else "oil"
    if n == 7:
        del line.gone
"""


def test_values_of_python_that_do_not_fit_are_0_with_one_event_each(tmp_path: Path) -> None:
    (tmp_path / "line.py").write_text(NOT_FITTING, encoding="utf-8")
    (tmp_path / "rack.toml").write_text(
        "program = 'line.py'\ntags = ['line']\n[[slot]]\nnumber = 1\nmodule = 'amci3601'\n", encoding="utf-8"
    )
    words = ["run", tmp_path / "rack.toml", "--scans", 10, "--record", tmp_path / "run.mcap", "-q"]
    result = CliRunner().invoke(build(), [str(word) for word in words])
    assert result.exit_code == 0, result.output
    with open_trace(tmp_path / "run.mcap") as trace:
        found = read_columns(trace, tags=True).tags
        told = [
            (event.scan, event.fields["name"])
            for event in trace.events()
            if event.topic == "/events" and event.fields.get("kind") == "tag"
        ]
    assert found is not None
    assert found["line_count"].tolist() == [0, 1, 0, 3, 4, 5, 6, 7, 8, 9]
    assert found["line_flag"].tolist() == [True] * 10  # any object is true or false
    assert found["line_level"].tolist() == [0, 0.5, 1, 1.5, 0, 2.5, 3, 3.5, 4, 4.5]
    assert found["line_step"].tolist() == [1] * 5 + [0] + [1] * 4
    assert found["line_gone"].tolist() == [1] * 7 + [0] * 3
    assert told == [
        (2, "line.count"),
        (4, "line.level"),
        (5, "line.step"),
        (6, "line.name"),
        (7, "line.gone"),
    ]
