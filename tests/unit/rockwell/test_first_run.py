"""`scanrack l5x FILE --run`, and exports opened as they are by run, watch and why."""

import json

import l5x_files as files
import pytest
from scanrack.commands import build
from scanrack.jobs import load_job
from scanrack.jobs.load.loading import is_export, runs
from typer.testing import CliRunner

TAGS = (
    files.tag("Step", "DINT"),
    files.tag("Auto", "BOOL"),
    files.tag("Part", "BOOL"),
    files.tag("Clamp", "BOOL"),
    files.tag("Delay", "TIMER"),
    files.alias("Start", "Local:1:I.Data.3"),
)
RUNGS = (
    "XIC(Start)OTE(Clamp);",
    "EQU(Step,0)TON(Delay,100,0);",
    "EQU(Step,0)XIC(Delay.DN)MOV(10,Step);",
    "EQU(Step,10)XIC(Part)MOV(20,Step);",
)
MODULES = (files.module("Panel", 1), files.module("Valves", 2, catalog="1734-OB8"))


def invoke(*arguments):
    result = CliRunner().invoke(build(), list(arguments))
    return result.exit_code, result.stdout, result.output


@pytest.fixture
def machine(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def make(*rungs, **parts):
        text = files.machine(*rungs, tags=TAGS, modules=MODULES, **parts)
        (tmp_path / "machine.L5X").write_text(text, encoding="utf-8")
        return tmp_path / "machine.L5X"

    return make


@pytest.mark.slow
def test_the_first_run_says_what_the_program_waits_for(machine):
    """The timer takes Step to 10; there it waits for Part, which nobody sets."""
    machine(*RUNGS)
    status, output, _ = invoke("l5x", "machine.L5X", "--run", "--json")
    run = json.loads(output)["run"]
    assert (status, run["scans"], run["fault"]) == (0, 1000, "")
    nearest, first = run["waits"][:2]
    assert (nearest["condition"], nearest["rung"]) == ("XIC(Part)", 3)
    assert nearest["why"] == "Part is 0: no rung writes it."
    assert first["condition"] == "XIC(Start)"
    assert run["unchanged_inputs"] == ["Start"]
    assert run["never_written"] == ["Part"]
    assert [each["name"] for each in run["modules"]] == ["Valves"]
    text = invoke("l5x", "machine.L5X", "--run")[1]
    assert "first run: 1,000 scans" in text
    assert "    1734-OB8 Valves, slot 2" in text


def test_structured_text_waits_at_an_if_that_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    text = "IF Step = 1 THEN\nStep := 2;\nEND_IF;\nIF Step = 0 AND Part THEN\nStep := 1;\nEND_IF;"
    whole = files.document(
        tags=TAGS[:4],
        programs=[files.program("Main", files.structured("Main", text))],
        tasks=[files.task("T", "Main")],
    )
    (tmp_path / "text.L5X").write_text(whole, encoding="utf-8")
    waits = json.loads(invoke("l5x", "text.L5X", "--run", "--json")[1])["run"]["waits"]
    assert [(each["condition"], each["tag"]) for each in waits] == [
        ("IF Step=1 THEN", "Step"),
        ("IF Step=0 AND Part THEN", "Part"),
    ]


def test_a_file_that_is_no_export_gives_json_too(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.L5X").write_text("nothing", encoding="utf-8")
    status, output, _ = invoke("l5x", "bad.L5X", "--run", "--json")
    assert (status, list(json.loads(output))) == (2, ["file", "problem"])


def test_a_fault_ends_the_first_run_and_refused_rungs_are_empty(machine):
    """1,000 / 0 is a minor fault; a subscript out of range a major one."""
    machine("NOSUCH(Step);", "XIC(Auto)OTE(Clamp);")
    status, output, _ = invoke("l5x", "machine.L5X", "--run", "--json")
    report = json.loads(output)
    assert (status, len(report["refused"]), report["run"]["scans"]) == (1, 1, 1000)
    assert any("NOSUCH = false" in each or "refused" in each for each in report["run"]["stubs"])


@pytest.mark.slow
def test_an_export_is_a_rack_for_run_watch_and_why(machine):
    path = machine(*RUNGS)
    assert (is_export("machine.L5X"), runs("machine.SLC"), runs("a.mcap")) == (True, True, False)
    status, output, said = invoke("run", "machine.L5X", "--scans", "100", "--no-record", "--json")
    assert (status, json.loads(output)["scans"]) == (0, 100), said
    status, output, said = invoke("why", "machine.L5X", "Step", "--at", "199")
    assert (status, "Step is 10" in output) == (0, True), said
    job = load_job(str(path))
    assert (job.program, job.rack_name) == (path.resolve(), "machine.toml")


SLC = "SLOT 0 1 2 3\nSOR XIC B3:0/0 OTE B3:0/1 EOR\nSOR XIC B3:0/1 NOSUCH B3:0/2 EOR\n"


def test_a_text_of_rslogix_500_runs_too(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "line.SLC").write_text(SLC, encoding="utf-8")
    status, output, said = invoke("l5x", "line.SLC", "--run", "--json")
    run = json.loads(output)["run"]
    assert (status, run["scans"], run["problem"]) == (1, 1000, ""), said
    assert run["waits"][0]["condition"] == "XIC(B3:0/0)"


def test_an_export_without_a_program_says_so(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "types.L5X").write_text(files.document(types=[files.data_type("T")]), encoding="utf-8")
    status, output, _ = invoke("l5x", "types.L5X", "--run", "--json")
    assert (status, "contains no program" in json.loads(output)["run"]["problem"]) == (1, True)
    for command in ("check", "run", "watch"):
        status, _, said = invoke(command, "types.L5X")
        assert (status, said) == (2, f"scanrack: {tmp_path}/types.L5X contains no program\n")
