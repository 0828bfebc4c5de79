"""Tags of a program, from the rack file or the command line, as a run records them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from costs import lines_executed
from scanrack.commands import build
from scanrack.jobs import open_bench
from scanrack.jobs.record import tag_source
from scanrack.jobs.record.tag_source import tags_of
from scanrack.ladder import LadderError
from scanrack.ladder.debug import Debugger
from scanrack.ladder.debug.tag_values import tag_values
from scanrack.ladder.files import parse_program
from scanrack.ladder.lowering.runnable import LadderLogic
from scanrack.traces import open_trace, read_columns
from typer.testing import CliRunner

LADDER = r"""
PROGRAM line
TYPE Recipe (Time : INT, Names : STRING[2])
TAG Run : BOOL := true
TAG Fill : TIMER
TAG Step : INT
TAG Level : REAL
TAG Total : LINT := 4611686018427387904
TAG Counts : DINT[3]
TAG Name : STRING := "water"
TAG Recipes : Recipe[2]
ALIAS Go : Run
ALIAS Bit : Step.3
ROUTINE Main
XIC(Run)TON(Fill,20,0);
XIC(Fill.DN)RES(Fill)ADD(Step,1,Step)ADD(Counts[1],2,Counts[1]);
ADD(Level,0.5,Level)MOV(Step,Recipes[1].Time);
EQU(Step,3)COP(Recipes[0].Names[0],Name,1);
END
"""


def rack(tmp_path: Path, program: str, tags: str) -> Path:
    (tmp_path / "rack.toml").write_text(
        f"program = '{program}'\ntags = {tags}\n[[slot]]\nnumber = 1\nmodule = 'amci3601'\n", encoding="utf-8"
    )
    return tmp_path / "rack.toml"


def run(path: Path, *options: str, scans: int = 100) -> Path:
    trace = path.parent / "run.mcap"
    result = CliRunner().invoke(
        build(), ["run", str(path), "--scans", str(scans), "--record", str(trace), "-q", *options]
    )
    assert result.exit_code == 0, result.output
    return trace


def recorded(trace: Path) -> tuple[Mapping[str, Any], list[tuple[str, dict[str, object]]]]:
    with open_trace(trace) as opened:
        columns = read_columns(opened, tags=True).tags
        events = [(event.topic, dict(event.fields)) for event in opened.events()]
    assert columns is not None
    return {name: columns[name] for name in columns.dtype.names or ()}, events


PYTHON = """
from dataclasses import dataclass
from enum import Enum

class Step(Enum):
    IDLE = "idle"
    FILL = "fill"

@dataclass
class Line:
    step: Step = Step.IDLE
    count: int = 0
    level: float = 0.0
    lamp: bool = False
    recipe: str = "water"

line = Line()

def logic(scan):
    global line
    if scan.number == 50:
        line = Line(recipe="oil")
    line.count += 1
    line.level += 0.25
    line.lamp = not line.lamp
    line.step = Step.FILL if line.count > 10 else Step.IDLE
    if scan.number == 99:
        line.count = "many"
"""


def test_tags_of_a_ladder_program(tmp_path: Path) -> None:
    (tmp_path / "line.rung").write_text(LADDER, encoding="utf-8")
    trace = run(
        rack(tmp_path, "line.rung", '["Run", "fill", "Level", "Go"]'), "--tag", "Step", "--tag", "Counts"
    )
    tags, _ = recorded(trace)
    assert sorted(tags) == [
        "counts", "fill_acc", "fill_dn", "fill_en", "fill_pre", "fill_tt", "level", "run", "step",
    ]  # fmt: skip
    assert tags["run"].all()
    assert tags["level"].dtype == np.float32
    assert (tags["level"] == 0.5 * np.arange(1, 101)).all()
    assert (tags["fill_pre"] == 20).all()
    # 20 ms at 2 ms a scan: on at 0, ACC 20 ten scans later, reset in the same scan and on again in the next
    assert tags["fill_acc"][:13].tolist() == [0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 0, 0, 2]
    assert tags["step"][9:11].tolist() == [0, 1]
    assert (tags["counts"][:, 1] == 2 * tags["step"]).all()


def test_texts_are_codes_and_messages(tmp_path: Path) -> None:
    (tmp_path / "line.rung").write_text(LADDER, encoding="utf-8")
    tags, events = recorded(run(rack(tmp_path, "line.rung", '["Name", "Recipes[1]"]')))
    texts = [fields for topic, fields in events if topic == "/texts"]
    assert [each["text"] for each in texts if each["tag"] == "Name"] == ["water", ""]
    assert tags["name"][0] == texts[0]["code"]
    assert tags["recipes_1_time"].dtype == np.int16
    assert tags["recipes_1_time"][50] > 0


@pytest.mark.parametrize(
    ("patterns", "names"),
    [
        (["run"], ["Run"]),
        (["F*.ACC"], ["Fill.ACC"]),
        (["Bit"], ["Step"]),
        (["Counts[2]"], ["Counts[2]"]),
        (["Recipes.Time"], ["Recipes[0..1].Time"]),
        (["Step", "St*"], ["Step"]),
    ],
)
def test_patterns(patterns: list[str], names: list[str]) -> None:
    layout = parse_program(LADDER).build().layout
    assert [each.name for each in tag_values(layout, patterns)] == names


@pytest.mark.parametrize(
    ("pattern", "says"), [("Fil", "did you mean"), ("Local:1:I.Data[2]", "Local"), ("[", "'['")]
)
def test_a_pattern_without_a_match_is_refused(pattern: str, says: str) -> None:
    layout = parse_program(LADDER).build().layout
    with pytest.raises(LadderError, match=re.escape(says)):
        tag_values(layout, [pattern])


CONTROLLER = r"""
CONTROLLER plant
TAG Run : BOOL := true
TASK Cycle : CONTINUOUS RUNS Main
PROGRAM Main
TAG Step : DINT
ROUTINE Start
XIC(Run)ADD(Step,1,Step);
END
END PROGRAM
"""


def test_tags_of_a_controllers_program(tmp_path: Path) -> None:
    (tmp_path / "plant.rung").write_text(CONTROLLER, encoding="utf-8")
    trace = run(rack(tmp_path, "plant.rung", r"""['\Main.*', "Run"]"""))
    tags, _ = recorded(trace)
    assert tags["main_step"].tolist() == list(range(1, 101))
    assert tags["run"].all()


def test_tags_of_a_python_program(tmp_path: Path) -> None:
    (tmp_path / "line.py").write_text(PYTHON, encoding="utf-8")
    tags, events = recorded(run(rack(tmp_path, "line.py", '["line"]')))
    assert sorted(tags) == ["line_count", "line_lamp", "line_level", "line_recipe", "line_step"]
    assert tags["line_count"][:3].tolist() == [1, 2, 3]
    assert tags["line_count"][50] == 1, "an object that is replaced is found"
    assert tags["line_count"][99] == 0, "a value that does not fit is 0"
    assert tags["line_level"].dtype == np.float64
    assert tags["line_step"][[9, 10]].tolist() == [0, 1]
    assert tags["line_step"][99] == 1, "values that fit are recorded beside one that does not"
    texts = [fields for topic, fields in events if topic == "/texts"]
    assert texts == [
        {"tag": "line.recipe", "code": 0, "text": "water"},
        {"tag": "line.recipe", "code": 1, "text": "oil"},
    ]
    (refused,) = [fields for topic, fields in events if fields.get("kind") == "tag"]
    assert str(refused["text"]).startswith("line.count has no value that fits LINT")


@pytest.mark.parametrize(
    ("pattern", "says"),
    [("line.cuont", "did you mean line.count?"), ("logic", "is function"), ("exit()", "no tag matches")],
)
def test_a_name_that_can_not_be_recorded_is_refused(tmp_path: Path, pattern: str, says: str) -> None:
    (tmp_path / "line.py").write_text(PYTHON, encoding="utf-8")
    path = rack(tmp_path, "line.py", f'["{pattern}"]')
    result = CliRunner().invoke(build(), ["run", str(path), "--scans", "1", "-q"])
    assert result.exit_code == 2
    assert says in result.output


def test_a_trace_without_tags_is_that_of_a_rack_file_without_the_key(tmp_path: Path) -> None:
    (tmp_path / "line.py").write_text(PYTHON, encoding="utf-8")
    path = rack(tmp_path, "line.py", "[]")
    with open_trace(run(path)) as trace:
        assert trace.head.tags is None
        assert "tags" not in trace.head.metadata


def test_texts_have_codes_of_their_own_up_to_a_bound() -> None:
    names: dict[str, object] = {"text": ""}
    source = eval("lambda scan: None", names)
    tags = tags_of(source, ["text"], bytearray(32))
    for number in range(65_537):
        names["text"] = str(number)
        row = tags.take()
    assert row[-2:] == b"\xff\xff"
    assert [topic for topic, _ in tags.pending].count("/events") == 1


def test_a_bench_records_the_program_it_runs_also_after_an_edit(tmp_path: Path) -> None:
    (tmp_path / "line.rung").write_text(LADDER, encoding="utf-8")
    path = rack(tmp_path, "line.rung", '["Level", "Counts", "Step", "Name"]')
    bench = open_bench(path, tmp_path / "bench.mcap")
    bench.scan(10)
    edited = LADDER.replace("ADD(Level,0.5,Level)", "ADD(Level,2,Level)").replace("DINT[3]", "DINT[4]")
    bench.edit(parse_program(edited.replace("Step,1,Step", "Step,5,Step")))
    bench.scan(10)
    bench.close()
    tags, _ = recorded(tmp_path / "bench.mcap")
    assert tags["level"][[0, 9, 10, 19]].tolist() == [0.5, 5.0, 7.0, 25.0]
    assert tags["counts"].shape == (20, 3)
    assert not tags["counts"][10:].any(), "it has another length now"


def of_many_tags(count: int, value: int = 1) -> LadderLogic:
    tags = "".join(f"TAG A{number} : DINT\n" for number in range(count))
    return parse_program(f"PROGRAM line\n{tags}ROUTINE Main\nMOV({value},A0);\nEND\n")


def test_the_tags_of_a_program_are_compiled_once_however_many_there_are(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    compiled: list[str] = []

    def counted(text: str, *rest: Any) -> Any:
        compiled.append(text)
        return compile(text, *rest)

    monkeypatch.setattr(tag_source, "compile", counted, raising=False)
    for count in (100, 400):
        compiled.clear()
        tags_of(of_many_tags(count), ["*"], bytearray(16))
        assert len(compiled) == 1
        assert len(compiled[0]) < 20 * count


def test_after_an_edit_each_of_many_tags_is_looked_up_once() -> None:
    def lines_of(count: int) -> int:
        debugger = Debugger(of_many_tags(count), remembered=0)
        source = tags_of(debugger, ["*"], bytearray(16))
        debugger.edit(of_many_tags(count, value=2))
        return lines_executed(source.take)

    assert lines_of(400) < 5 * lines_of(100)


def test_a_value_that_does_not_fit_is_found_among_many(tmp_path: Path) -> None:
    text = "a = b = c = 1\ndef logic(scan):\n    global b\n    b = 'many' if scan.number else 2\n"
    (tmp_path / "logic.py").write_text(text, encoding="utf-8")
    tags, events = recorded(run(rack(tmp_path, "logic.py", '["a", "b", "c"]'), scans=2))
    assert [tags[each].tolist() for each in "abc"] == [[1, 1], [2, 0], [1, 1]]
    assert [fields["name"] for topic, fields in events if fields.get("kind") == "tag"] == ["b"]
