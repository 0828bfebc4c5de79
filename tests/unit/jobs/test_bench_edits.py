"""An online edit on a bench is on record: an event in front of the first scan of the edited program."""

import pytest
from scanrack import open_trace
from scanrack.commands import build
from scanrack.jobs.bench.opening import open_bench
from scanrack.ladder.files.rungfile import parse_program
from scanrack.traces.read.reader import TraceEvent
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
        assert [each.text for each in bench.told if each.kind == "edit"] == [
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
        (["rerun"], "the trace brings the one that it began with"),
        (["replay", "--into", "program"], "here the one that the trace begins with runs on"),
    ],
)
def test_what_runs_the_trace_again_says_where_it_was_edited(trace, words, says):
    result = CliRunner().invoke(build(), [words[0], str(trace), *words[1:]])
    assert result.exit_code == 1
    assert f"note: the program was edited before scan 3: {says}" in result.stderr
