"""An online edit on a bench is on record: an event in front of the first scan of the edited program."""

from typing import Any

import pytest
from scanrack import open_trace
from scanrack.commands import build
from scanrack.jobs import open_bench
from scanrack.jobs.record.program_versions import edits_of
from scanrack.ladder.files import parse_program
from scanrack.runtime import Edit
from scanrack.traces import TraceEvent
from typer.testing import CliRunner

RACK = """scan_ms = 10
program = "line.rung"
[[slot]]
number = 1
module = "amci3601"
"""

BEFORE = """PROGRAM line
TAG Count : DINT
TAG Size : INT
TAG Gone : BOOL
ROUTINE Main
ADD(Count,1,Count);
MOV(Count,Local:1:O.Data[7]);
END
"""

AFTER = """PROGRAM line
TAG Count : DINT
TAG Size : DINT
TAG Fresh : DINT
ROUTINE Main
ADD(Count,100,Count);
MOV(Count,Local:1:O.Data[7]);
END
"""


@pytest.fixture
def trace(tmp_path):
    (tmp_path / "line.toml").write_text(RACK, encoding="utf-8")
    (tmp_path / "line.rung").write_text(BEFORE, encoding="utf-8")
    with open_bench(tmp_path / "line.toml", tmp_path / "line.mcap") as bench:
        bench.scan(3)
        bench.edit(parse_program(AFTER))
        bench.program.edit(parse_program(AFTER.replace("100", "1000")))
        bench.scan(2)
        assert [each.text for each in bench.events if each.kind == "edit"] == [
            "edited at 0.02 s, 1 tags keep their values; new: Fresh; of another type: Size; gone: Gone",
            "edited at 0.02 s, 3 tags keep their values",
        ]
    return tmp_path / "line.mcap"


def test_an_edit_is_an_event_of_the_first_scan_behind_it(trace):
    with open_trace(trace) as opened:
        entries = list(opened)
        assert [each.outputs(1)[7] for each in opened.scans()] == [1, 2, 3, 1003, 2003]
    events = [each for each in entries if isinstance(each, TraceEvent) and each.topic == "/events"]
    edits = [each for each in events if each.fields["kind"] == "edit"]
    assert [(each.scan, each.now_ns) for each in edits] == [(3, 20_000_000)] * 2
    first = dict(edits[0].fields)
    assert str(first.pop("text")).startswith("edited at 0.02 s")
    assert first == {
        "kind": "edit",
        "name": "line",
        "new": ["Fresh"],
        "changed": ["Size"],
        "dropped": ["Gone"],
    }


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["replay", "--into", "session"], "the trace contains only the first program"),
        (["replay", "--into", "program"], "the first program continues here"),
    ],
)
def test_what_runs_the_trace_again_says_where_it_was_edited(trace, words, says):
    result = CliRunner().invoke(build(), [words[0], str(trace), *words[1:]])
    assert result.exit_code == 1
    assert f"note: the program was edited before scan 3: {says}" in result.stderr


FIELDS = """from scanrack import Input, Logic, Output


class Line(Logic):
    go = Input("Local:2:I.Data.1")
    lamp: Output = Output("Local:2:O.Data.0")
    count = 0

    def every_scan(self) -> None:
        self.count += 1
        self.lamp = self.count > 100
"""
CARD = 'scan_ms = 10\nprogram = "PROGRAM"\n[[slot]]\nnumber = 2\nmodule = "discrete16"\n'
RUNGS = BEFORE.replace("Local:1:O.Data[7]", "Local:2:O.Data[0]")


@pytest.mark.parametrize(
    ("name", "text", "edits"),
    [
        ("line.rung", RUNGS, [("ADD(Count,1,", "ADD(Count,100,"), ("Count,100,", "Count,1000,")]),
        ("line.py", FIELDS, [("count > 100", "count > 2"), ("self.count > 2", "self.count < 2")]),
    ],
)
def test_a_recording_with_edits_of_files_runs_again_as_it_was(tmp_path, name, text, edits):
    """Twice edited: the trace has both programs, and each runs from its scan on."""
    rack, program = tmp_path / "line.toml", tmp_path / name
    rack.write_text(CARD.replace("PROGRAM", name), encoding="utf-8")
    program.write_text(text, encoding="utf-8")
    with open_bench(rack, tmp_path / "line.mcap") as bench:
        for old, new in edits:
            bench.scan(3)
            assert old in program.read_text(encoding="utf-8")
            program.write_text(program.read_text(encoding="utf-8").replace(old, new), encoding="utf-8")
            bench.edit(rack)
        bench.scan(3)
    with open_trace(tmp_path / "line.mcap") as opened:
        seen = [each.outputs(2)[0] for each in opened.scans()]
        assert [
            (each.scan, each.order.number) for each in edits_of(opened) if isinstance(each.order, Edit)
        ] == [(3, 1), (6, 2)]
        assert len(edits_of(opened)) == 2
    assert (
        seen
        == {"line.rung": [1, 2, 3, 103, 203, 303, 1303, 2303, 3303], "line.py": [0] * 3 + [1] * 3 + [0] * 3}[
            name
        ]
    )
    result = CliRunner().invoke(
        build(), ["replay", "--into", "session", str(tmp_path / "line.mcap"), "--trust"]
    )
    assert (result.exit_code, result.stderr) == (0, "")
    assert "show the same: 9 scans" in result.stdout


def test_an_edit_that_is_refused_leaves_the_program_and_the_recording_as_they_are(tmp_path):
    rack, program = tmp_path / "line.toml", tmp_path / "line.rung"
    rack.write_text(CARD.replace("PROGRAM", "line.rung"), encoding="utf-8")
    program.write_text(RUNGS, encoding="utf-8")
    with open_bench(rack, tmp_path / "line.mcap") as bench:
        bench.scan(1)
        program.write_text(RUNGS.replace("ADD(Count,1,Count)", "ADD(Cuont,1,Count)"), encoding="utf-8")
        with pytest.raises(ValueError, match="Cuont"):
            bench.edit(rack)
        bench.scan(1)
        assert (bench["Count"], [each for each in bench.events if each.kind == "edit"]) == (2, [])
    with open_trace(tmp_path / "line.mcap") as opened:
        assert edits_of(opened) == []


STEPPED = """from scanrack import Logic, Output


class Line(Logic):
    lamp: Output = Output("Local:2:O.Data.0")
    count = 0

    def every_scan(self) -> None:
        self.count += 1
        self.lamp = self.count > 100
"""


@pytest.mark.slow
def test_why_runs_the_edited_program_from_its_scan_on(tmp_path):
    """Scans 0 to 2 are of the first program, 3 to 5 of the second, and the file has the third."""
    rack, program = tmp_path / "line.toml", tmp_path / "line.py"
    rack.write_text(CARD.replace("PROGRAM", "line.py"), encoding="utf-8")
    program.write_text(STEPPED, encoding="utf-8")
    with open_bench(rack, tmp_path / "line.mcap") as bench:
        bench.scan(3)
        for old, new in (("count += 1", "count += 10"), ("count += 10", "count += 100")):
            program.write_text(program.read_text(encoding="utf-8").replace(old, new), encoding="utf-8")
            bench.edit(rack)
            bench.scan(3)
        assert bench["line.count"] == 333
        assert "line.count is 333 since 0.08 s (scan 8)" in (said := bench.why("line.count"))
        assert "self.count += 100" in said
        lamp = bench.why("lamp")
        assert "lamp is on since 0.06 s (scan 6)" in lamp
        assert "self.lamp = self.count > 100" in lamp
        assert bench.chain("line.count").before == 233
        assert program.read_text(encoding="utf-8").count("+= 100") == 1
    result = CliRunner().invoke(build(), ["why", str(tmp_path / "line.mcap"), "lamp", "--trust"])
    assert result.exit_code == 0, result.output
    assert (result.exit_code, "lamp is on since 0.06 s (scan 6)" in result.output) == (0, True)
    assert "self.lamp = self.count > 100" in result.output


def test_why_says_that_an_edited_program_without_files_can_not_be_run_again(tmp_path):
    rack, program = tmp_path / "line.toml", tmp_path / "line.py"
    rack.write_text(CARD.replace("PROGRAM", "line.py"), encoding="utf-8")
    program.write_text(STEPPED, encoding="utf-8")
    with open_bench(rack) as bench:
        bench.scan(3)
        namespace: dict[str, Any] = {}
        exec(STEPPED.replace("+= 1", "+= 10"), namespace)
        bench.edit(namespace["Line"]())
        bench.scan(3)
        said = bench.why("line.count")
        assert "no line can be named: the program was edited before scan 3 (" in said
        assert "the program was edited" in bench.chain("line.count").text
