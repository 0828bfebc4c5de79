"""Tags that are set or forced from outside: rows, flags bit 7, /forces; show, chart and compare of them."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scanrack.commands import build
from scanrack.jobs import open_bench
from scanrack.jobs.bench import Bench
from scanrack.ladder.files import parse_program
from scanrack.runtime.loop.faults import CpuFault
from scanrack.traces import open_trace, read_columns
from scanrack.traces.plot import Envelope, read_chart
from typer.testing import CliRunner

BIT = 1 << 7
FAULT = 1 << 6

LADDER = """
PROGRAM line
TAG Run : BOOL
TAG Lamp : BOOL
TAG Count : DINT
TAG Level : REAL
TAG Zero : DINT
ROUTINE Main
XIC(Run)OTE(Lamp);
ADD(Count,1,Count)MUL(Level,2.0,Level);
END
"""

FAULTING = """
PROGRAM line
TAG Count : DINT
TAG Behind : DINT
TAG Table : DINT[3]
ROUTINE Main
ADD(Count,1,Count)MOV(Count,Table[Count])ADD(Behind,1,Behind);
END
"""


def recorded(
    folder: Path, acts: Callable[[Bench], None], program: str = LADDER, tags: str = '["*"]', name: str = "run"
) -> Path:
    """Record what a bench does; return the trace."""
    (folder / "line.rung").write_text(program, encoding="utf-8")
    (folder / "rack.toml").write_text(
        f"program = 'line.rung'\ntags = {tags}\n[[slot]]\nnumber = 1\nmodule = 'amci3601'\n", encoding="utf-8"
    )
    trace = folder / f"{name}.mcap"
    with open_bench(folder / "rack.toml", record=trace) as bench:
        acts(bench)
    return trace


def columns(trace: Path) -> tuple[np.ndarray, Any]:
    with open_trace(trace) as opened:
        read = read_columns(opened, tags=True)
    return read.flags & BIT != 0, read.tags


def forces(trace: Path) -> list[tuple[int, dict[str, object]]]:
    with open_trace(trace) as opened:
        return [(event.scan, dict(event.fields)) for event in opened.events() if event.topic == "/forces"]


def written(bench: Bench) -> None:
    bench.scan(5)
    bench["Count"] = 100
    bench["Level"] = 1.5
    bench.scan(5)


def test_a_write_between_scans_shows_in_the_next_row_and_its_flag(tmp_path: Path) -> None:
    """A row is the memory at the end of its scan: the program counts once more after the write."""
    trace = recorded(tmp_path, written)
    flags, tags = columns(trace)
    assert np.flatnonzero(flags).tolist() == [5]
    assert tags["count"].tolist() == [1, 2, 3, 4, 5, 101, 102, 103, 104, 105]
    assert tags["level"].tolist() == [0] * 5 + [3, 6, 12, 24, 48]
    assert forces(trace) == []


def forced(bench: Bench) -> None:
    bench.scan(3)
    bench.force("Count", 7)
    bench.force("Run", 1)
    bench.scan(4)
    bench.unforce("Count")
    bench.scan(2)
    bench.unforce("Run")
    bench.scan(2)


def test_a_force_shows_its_value_in_every_row_and_in_the_flags(tmp_path: Path) -> None:
    trace = recorded(tmp_path, forced)
    flags, tags = columns(trace)
    assert tags["count"].tolist() == [1, 2, 3, 7, 7, 7, 7, 8, 9, 10, 11]
    assert tags["run"].tolist() == [False] * 3 + [True] * 8  # released, it stays as it is
    assert tags["lamp"].tolist() == tags["run"].tolist()
    assert np.flatnonzero(flags).tolist() == [3, 4, 5, 6, 7, 8, 9]  # the scan that shows a release, too


def test_forces_tells_the_forced_tags_in_full(tmp_path: Path) -> None:
    assert forces(recorded(tmp_path, forced)) == [
        (3, {"tags": {"Count": 7, "Run": True}}),
        (7, {"tags": {"Run": True}}),
        (9, {}),
    ]


def test_forces_of_images_and_of_tags_stand_side_by_side(tmp_path: Path) -> None:
    def acts(bench: Bench) -> None:
        bench.force("slot1.status.IN_HOME", 1)
        bench.force("Run", 1)
        bench.scan(1)
        bench.unforce("slot1.status.IN_HOME")
        bench.scan(1)

    assert forces(recorded(tmp_path, acts)) == [
        (0, {"Local:1:I.Data[1].2": 1, "tags": {"Run": True}}),
        (1, {"tags": {"Run": True}}),
    ]


def test_values_that_json_has_not_are_text(tmp_path: Path) -> None:
    def acts(bench: Bench) -> None:
        bench.program.force("Level", math.inf)
        bench.scan(1)

    assert forces(recorded(tmp_path, acts)) == [(0, {"tags": {"Level": "inf"}})]


def test_a_write_before_the_first_scan_is_in_its_row(tmp_path: Path) -> None:
    def acts(bench: Bench) -> None:
        bench["Count"] = 41
        bench.scan(2)

    flags, tags = columns(recorded(tmp_path, acts))
    assert tags["count"].tolist() == [42, 43]
    assert flags.tolist() == [True, False]


def test_in_program_mode_values_stand_and_a_write_shows(tmp_path: Path) -> None:
    def acts(bench: Bench) -> None:
        bench.scan(3)
        bench.program_mode()
        bench.scan(2)
        bench["Count"] = 50
        bench.scan(2)
        bench.run_mode()
        bench.scan(1)

    flags, tags = columns(recorded(tmp_path, acts))
    assert tags["count"].tolist() == [1, 2, 3, 3, 3, 50, 50, 51]
    assert np.flatnonzero(flags).tolist() == [5]


def test_after_a_fault_the_row_is_that_of_the_broken_off_scan(tmp_path: Path) -> None:
    """Table has elements 0 to 2: the third scan counts, faults at Table[3] and never reaches Behind."""

    def acts(bench: Bench) -> None:
        with pytest.raises(CpuFault):
            bench.scan(5)

    trace = recorded(tmp_path, acts, FAULTING)
    _, tags = columns(trace)
    assert tags["count"].tolist() == [1, 2, 3]
    assert tags["behind"].tolist() == [1, 2, 2]
    assert tags["table"].tolist() == [[0, 1, 0], [0, 1, 2], [0, 1, 2]]
    with open_trace(trace) as opened:
        assert [int(scan.flags & FAULT != 0) for scan in opened.scans()] == [0, 0, 1]


def test_after_a_fault_of_python_the_row_is_that_of_the_broken_off_scan(tmp_path: Path) -> None:
    (tmp_path / "line.py").write_text(
        "count = behind = 0\n"
        "def logic(scan):\n"
        "    global count, behind\n"
        "    count += 1\n"
        "    1 / (count - 3)\n"
        "    behind += 1\n",
        encoding="utf-8",
    )
    (tmp_path / "rack.toml").write_text(
        'program = "line.py"\ntags = ["count", "behind"]\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n',
        encoding="utf-8",
    )
    trace = tmp_path / "run.mcap"
    scanrack("run", tmp_path / "rack.toml", "--scans", 9, "--record", trace, "-q", status=1)
    _, tags = columns(trace)
    assert tags["count"].tolist() == [1, 2, 3]
    assert tags["behind"].tolist() == [1, 2, 2]


def test_an_edit_that_drops_a_forced_tag_tells_of_it(tmp_path: Path) -> None:
    def acts(bench: Bench) -> None:
        bench.force("Zero", 5)
        bench.force("Run", 1)
        bench.scan(2)
        bench.edit(parse_program(LADDER.replace("TAG Zero : DINT\n", "")))
        bench.scan(2)

    found = forces(recorded(tmp_path, acts, tags='["Run"]'))
    assert found == [(0, {"tags": {"Run": True, "Zero": 5}}), (2, {"tags": {"Run": True}})]


def test_a_run_that_nobody_touches_has_the_bytes_of_a_plain_one(tmp_path: Path) -> None:
    trace = recorded(tmp_path, lambda bench: bench.scan(50))
    scanrack("run", tmp_path / "rack.toml", "--scans", 50, "--record", tmp_path / "b.mcap", "-q")
    assert trace.read_bytes() == (tmp_path / "b.mcap").read_bytes()


def scanrack(*words: object, status: int = 0) -> str:
    result = CliRunner().invoke(build(), [str(word) for word in words])
    assert result.exit_code == status, result.output
    return str(result.output)


def test_show_tells_forces_and_flags(tmp_path: Path) -> None:
    lines = [" ".join(line.split()) for line in scanrack("show", recorded(tmp_path, forced)).splitlines()]
    assert "3 0.006 forces: Count = 7, Run = True" in lines
    assert "9 0.018 forces: none" in lines
    (risen,) = [line for line in lines if "+TAGS_FROM_OUTSIDE" in line]
    assert risen.startswith("3 0.006")
    (fallen,) = [line for line in lines if "-TAGS_FROM_OUTSIDE" in line]
    assert fallen.startswith("10 0.020")


def test_query_knows_the_flag(tmp_path: Path) -> None:
    assert scanrack("query", recorded(tmp_path, forced), "count(cpu.flags.7)") == "1\n"


def test_the_chart_marks_forces_beside_the_tags(tmp_path: Path) -> None:
    with open_trace(recorded(tmp_path, forced)) as trace:
        slot, program = read_chart(trace, Envelope).panels
    assert [(mark.time_ns // 2_000_000, mark.label) for mark in program.marks] == [
        (3, "force"),
        (7, "force Run"),
        (9, "force over"),
    ]
    assert not [mark for mark in slot.marks if "force" in mark.label]
    outside = program.lanes[0]
    assert (outside.name, outside.row.tolist(), outside.value.tolist()) == (
        "from outside",
        [0, 3, 10],
        [0, 1, 0],
    )


def test_a_chart_of_a_run_that_nobody_touched_has_no_such_lane(tmp_path: Path) -> None:
    with open_trace(recorded(tmp_path, lambda bench: bench.scan(9))) as trace:
        assert [lane.name for lane in read_chart(trace, Envelope).panels[-1].lanes] == []


def test_compare_tells_that_one_of_two_was_touched(tmp_path: Path) -> None:
    plain = recorded(tmp_path, lambda bench: bench.scan(11), name="plain")
    said = scanrack("compare", plain, recorded(tmp_path, forced), status=1)
    assert "TAGS_FROM_OUTSIDE" in said
    assert "scan 3" in said
