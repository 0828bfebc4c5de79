"""Replay and `why` do again what was done to the tags: forces of any recording, writes of a session."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

import pytest
from scanrack.commands import build
from scanrack.jobs import JobRun, RunOptions, load_job, open_bench
from scanrack.jobs.bench import Bench
from scanrack.runtime import Force, Write
from scanrack.runtime.live.actions import Action, Unforce
from typer.testing import CliRunner

LADDER = """
PROGRAM line
TAG Run : BOOL
TAG Count : DINT
ROUTINE Main
XIC(Run)OTE(Local:1:O.Data[1].0);
ADD(Count,1,Count)MOV(Count,Local:1:O.Data[3]);
END
"""

FORCE_RUN = 3, Force("Run", True)
WRITE_COUNT = 5, Write("Count", 100)
RELEASE = 8, Unforce("all")


@pytest.fixture
def rack(tmp_path: Path) -> Path:
    (tmp_path / "line.rung").write_text(LADDER, encoding="utf-8")
    rack = tmp_path / "rack.toml"
    rack.write_text("program = 'line.rung'\n[[slot]]\nnumber = 1\nmodule = 'amci3601'\n", encoding="utf-8")
    return rack


def session(rack: Path, *orders: tuple[int, Action]) -> Path:
    """Record twelve scans of a session in which orders are given before some of them."""
    trace = rack.with_name("session.mcap")
    with ExitStack() as ports:
        run = JobRun(load_job(str(rack)), ports, RunOptions(trace=trace, handled=True))
        hands = run.hands
        for scan in range(12):
            for at, order in orders:
                if at == scan:
                    hands.act(order, scan * 2_000_000, scan)
            run.cpu.run(1)
        run.cpu.close()
    return trace


def benched(rack: Path, acts: Callable[[Bench], None]) -> Path:
    trace = rack.with_name("bench.mcap")
    with open_bench(rack, record=trace) as bench:
        acts(bench)
    return trace


def forced(bench: Bench) -> None:
    bench.scan(3)
    bench.force("Run", True)
    bench.scan(4)
    bench.unforce("Run")
    bench.force("Count", 7)
    bench.scan(4)


def written(bench: Bench) -> None:
    bench.scan(3)
    bench["Count"] = 50
    bench.scan(3)


def scanrack(*words: object, status: int = 0) -> str:
    result = CliRunner().invoke(build(), [str(word) for word in words])
    assert result.exit_code == status, result.output
    return " ".join(str(result.output).split())


@pytest.mark.parametrize("into", ["program", "rack"])
def test_orders_of_a_session_are_given_again(rack: Path, into: str) -> None:
    said = scanrack("replay", session(rack, FORCE_RUN, WRITE_COUNT, RELEASE), "--into", into)
    assert said.endswith("show the same: 12 scans")


def test_forces_of_a_recording_that_is_no_session_are_done_again(rack: Path) -> None:
    assert scanrack("replay", benched(rack, forced), "--into", "program").endswith("show the same: 11 scans")


def test_what_a_bench_writes_is_not_recorded_and_a_note_says_so(rack: Path) -> None:
    said = scanrack("replay", benched(rack, written), "--into", "program", status=1)
    assert "tags were set from outside before 1 scan, first before scan 3: the trace does not have" in said


def test_a_program_without_the_tag_refuses_the_order(rack: Path) -> None:
    other = rack.with_name("other.rung")
    other.write_text(LADDER.replace("Run", "Going"), encoding="utf-8")
    trace = session(rack, FORCE_RUN)
    said = scanrack("replay", trace, "--into", "program", "--program", other, "--to-the-end", status=1)
    assert "note: the action before scan 3 is not repeated: " in said


def test_a_program_in_python_has_no_tags_to_set(rack: Path) -> None:
    other = rack.with_name("other.py")
    other.write_text("def logic(scan):\n    pass\n", encoding="utf-8")
    trace = session(rack, FORCE_RUN)
    said = scanrack("replay", trace, "--into", "program", "--program", other, "--to-the-end", status=1)
    assert "not repeated: Run: the program has no tags that can be set" in said


def test_why_follows_what_was_written(rack: Path) -> None:
    """After scan 5 the counter has counted once from the 100 that was written before it."""
    said = scanrack("why", session(rack, WRITE_COUNT), "Count", "--at", "5")
    assert "Count is 101" in said
    assert "writes other words" not in said
