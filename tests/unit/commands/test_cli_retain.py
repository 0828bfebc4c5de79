"""`scanrack run --retain FILE`: tags from run to run, in the trace as well; warnings of a ladder program."""

import json

import pytest
from scanrack import open_trace
from scanrack.commands import build
from scanrack.jobs import load_job
from scanrack.jobs.run.retained_memory import RetainedMemory
from scanrack.jobs.trust.extracting import attached_files
from scanrack.jobs.trust.trust import FileUse, RunFiles, uses_of
from typer.testing import CliRunner

RACK = """scan_ms = 10
program = "line.rung"
[[slot]]
number = 1
module = "amci3601"
"""

PROGRAM = """PROGRAM line
TAG Count : DINT
TAG Lamp : BOOL
ROUTINE Main
ADD(Count,1,Count);
MOV(Count,Local:1:O.Data[7]);
OTE(Lamp);
{more}
END
"""


@pytest.fixture
def line(tmp_path):
    (tmp_path / "line.toml").write_text(RACK, encoding="utf-8")
    (tmp_path / "line.rung").write_text(PROGRAM.format(more=""), encoding="utf-8")
    return tmp_path


def run(folder, *words):
    rack = str(folder / "line.toml")
    return CliRunner().invoke(build(), ["run", rack, "--scans", "3", "--no-record", "-q", *words])


def test_the_second_run_begins_with_the_tags_of_the_first(line):
    file = line / "tags.json"
    for count in (3, 6):
        result = run(line, "--retain", str(file))
        assert (result.exit_code, result.stderr) == (0, "")
        assert json.loads(file.read_text(encoding="utf-8"))["tags"]["Count"] == ["DINT", count]
    assert [each.name for each in line.glob("*.part")] == []


def recorded(folder, *words):
    """Run with a trace; return its path."""
    trace = folder / "line.mcap"
    rack, tags = str(folder / "line.toml"), str(folder / "tags.json")
    line = ["run", rack, "--scans", "3", "--record", str(trace), "-q", "--retain", tags, *words]
    assert CliRunner().invoke(build(), line).exit_code == 0
    return trace


def test_the_trace_brings_the_tags_and_a_rerun_begins_with_them(line):
    recorded(line)
    before = (line / "tags.json").read_bytes()
    trace = recorded(line)
    with open_trace(trace) as opened:
        assert attached_files(opened)["retained/tags.json"] == before
        assert [each.outputs(1)[7] for each in opened.scans()] == [4, 5, 6]
    (line / "tags.json").unlink()
    (line / "line.rung").unlink()
    result = CliRunner().invoke(build(), ["replay", "--into", "session", str(trace)])
    assert (result.exit_code, result.stdout) == (0, "line.mcap: 3 scans, identical byte for byte\n")


def test_a_first_run_begins_with_nothing_and_its_trace_says_so(line):
    trace = recorded(line)
    with open_trace(trace) as opened:
        assert "retained_file" not in opened.head.metadata
    result = CliRunner().invoke(build(), ["replay", "--into", "session", str(trace)])
    assert (result.exit_code, result.stdout) == (0, "line.mcap: 3 scans, identical byte for byte\n")


def test_an_edited_program_is_replayed_from_the_tags_of_the_recording(line):
    recorded(line)
    trace = recorded(line)
    text = PROGRAM.format(more="")
    (line / "new.rung").write_text(text.replace("TAG Lamp", "TAG More : DINT\nTAG Lamp"), encoding="utf-8")
    words = ["replay", str(trace), "--into", "program", "--program", str(line / "new.rung")]
    result = CliRunner().invoke(build(), words)
    assert result.exit_code == 0, result.output


def test_retained_tags_of_a_trace_are_read_and_never_run():
    rungs = {"rack.toml": RACK.encode(), "a.rung": b"", "tags.json": b"{}"}
    assert uses_of(rungs, RunFiles("rack.toml", "a.rung", "tags.json"))["tags.json"] is FileUse.READ
    forged = uses_of({"rack.py": b""}, RunFiles("rack.py", None, "rack.py"))
    assert forged == {"rack.py": FileUse.RUN}
    with pytest.raises(ValueError, match="leads out of its folder"):
        uses_of(rungs, RunFiles("rack.toml", "a.rung", "../tags.json"))


def test_what_does_not_fit_is_reported(line):
    file = line / "tags.json"
    run(line, "--retain", str(file))
    text = (line / "line.rung").read_text(encoding="utf-8")
    (line / "line.rung").write_text(text.replace("Count : DINT", "Count : LINT"), encoding="utf-8")
    result = run(line, "--retain", str(file))
    assert (result.exit_code, result.stderr) == (0, f"scanrack: {file}: Count is LINT, in the file DINT\n")


@pytest.mark.parametrize(
    ("name", "text", "says"),
    [
        ("tags.json", "no", "is not a file of retained tags, and would be lost: choose another file"),
        ("line.rung", None, "is the program: choose another file to write to"),
    ],
)
def test_files_that_are_refused(line, name, text, says):
    if text is not None:
        (line / name).write_text(text, encoding="utf-8")
    before = (line / name).read_text(encoding="utf-8")
    result = run(line, "--retain", str(line / name))
    assert result.exit_code == 2
    assert says in result.stderr
    assert (line / name).read_text(encoding="utf-8") == before


def test_a_program_in_python_has_no_tags(line):
    (line / "line.py").write_text("def logic(scan):\n    pass\n", encoding="utf-8")
    (line / "line.toml").write_text(RACK.replace("line.rung", "line.py"), encoding="utf-8")
    result = run(line, "--retain", str(line / "tags.json"))
    assert result.exit_code == 2
    assert "it has no tags to retain" in result.stderr


def test_a_run_shows_the_warnings_of_its_program(line):
    (line / "line.rung").write_text(PROGRAM.format(more="XIC(Lamp)OTE(Lamp);"), encoding="utf-8")
    rack = str(line / "line.toml")
    result = CliRunner().invoke(build(), ["run", rack, "--scans", "1", "--no-record"])
    assert result.exit_code == 0
    assert "Lamp is written by a coil in " in result.stderr
    assert "join the two as branches of one rung" in result.stderr


def test_neither_a_name_beside_it_nor_a_link_is_written_to(line):
    """Once the tags went to the fixed name `tags.json.part`, through a link if there was one."""
    (line / "notes").write_text("mine", encoding="utf-8")
    (line / "tags.json.part").symlink_to("notes")
    trace = line / "t.part"
    words = ["run", str(line / "line.toml"), "--scans", "3", "-q", "--record", str(trace)]
    for tags in ("tags.json", "t"):
        assert CliRunner().invoke(build(), [*words, "--retain", str(line / tags)]).exit_code == 0
    assert (line / "notes").read_text(encoding="utf-8") == "mine"
    with open_trace(trace) as opened:
        assert len(list(opened.scans())) == 3


def test_the_file_that_a_link_leads_to_takes_the_tags(line):
    (line / "tags").symlink_to("real")
    for count in (3, 6):
        assert run(line, "--retain", str(line / "tags")).exit_code == 0
        assert json.loads((line / "real").read_text(encoding="utf-8"))["tags"]["Count"] == ["DINT", count]
    assert (line / "tags").is_symlink()


def test_a_second_run_with_the_same_file_is_refused(line):
    job = load_job(str(line / "line.toml"))
    with RetainedMemory(job, line / "tags.json"):
        result = run(line, "--retain", str(line / "tags.json"))
        assert result.exit_code == 3
        assert "tags.json: another process is replacing it" in result.stderr
    assert sorted(path.name for path in line.iterdir()) == ["line.rung", "line.toml"]
    assert run(line, "--retain", str(line / "tags.json")).exit_code == 0


def test_a_folder_that_is_missing_is_told_before_the_first_scan(line):
    result = run(line, "--retain", str(line / "no" / "tags.json"))
    assert result.exit_code == 3
    assert result.stderr == f"scanrack: {line}/no/tags.json: No such file or directory\n"
