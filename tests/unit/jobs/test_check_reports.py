"""`scanrack check`: JSON, SARIF and JUnit, findings that comments ignore, programs without a rack."""

import json
import shutil
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
import slc_files as slc
from check_programs import BLOCKS, RACK, SEQUENCE, check
from scanrack.commands import build
from scanrack.jobs.check import RULES, FileLine, ProofFinding, check_rack, load_any
from typer.testing import CliRunner

pytestmark = pytest.mark.slow  # together they take seconds

EXPORT = Path(__file__).parents[3] / "examples" / "l5x" / "indexer.L5X"
BROKEN = "XIC(Alarm)XIO(Alarm)OTE(Horn);"


def run(*arguments):
    return CliRunner().invoke(build(), ["check", *map(str, arguments)])


@pytest.fixture
def unproved(monkeypatch):
    """Leave out what a proof finds: it takes seconds, and reports are the same without it."""
    monkeypatch.setattr("scanrack.jobs.prove.serving.judging.verdicts", lambda _job, _facts: [])


@pytest.fixture
def rack(tmp_path, unproved):
    """A rack whose program has a contradiction in line 42, rung 5."""
    check(tmp_path, "line.rung", BLOCKS.replace("XIC(Alarm)OTE(Horn);", BROKEN))
    return tmp_path / "rack.toml"


def test_json(rack):
    found = json.loads(run(rack, "--format", "json").stdout)["findings"]
    line = BLOCKS.replace("XIC(Alarm)OTE(Horn);", BROKEN).splitlines().index(BROKEN) + 1
    assert [(each["rule"], each["line"], each["rung"], each["level"]) for each in found] == [
        ("contradiction", line, 5, "error")
    ]
    assert json.loads(run(rack, "--json").stdout)["findings"] == found


def test_sarif(rack):
    """The required properties of SARIF 2.1.0, sections 3.13, 3.14, 3.18, 3.19, 3.27 and 3.28."""
    done = run(rack, "--format", "sarif")
    log = json.loads(done.stdout)
    assert (done.exit_code, log["version"]) == (1, "2.1.0")
    (tool_run,) = log["runs"]
    driver = tool_run["tool"]["driver"]
    assert driver["name"] == "scanrack check"
    assert [each["id"] for each in driver["rules"]] == [rule.id for rule in RULES]
    (result,) = tool_run["results"]
    assert driver["rules"][result["ruleIndex"]]["id"] == result["ruleId"] == "contradiction"
    assert result["level"] in ("none", "note", "warning", "error")
    assert result["message"]["text"]
    where = result["locations"][0]["physicalLocation"]
    assert where["artifactLocation"]["uri"].endswith("line.rung")
    assert where["region"]["startLine"] > 1
    assert result["locations"][0]["logicalLocations"][0]["fullyQualifiedName"] == "Main, rung 5"


SARIF = {
    "$schema": str,
    "version!": str,
    "runs!": [
        {
            "tool!": {
                "driver!": {
                    "name!": str,
                    "version": str,
                    "rules": [
                        {
                            "id!": str,
                            "shortDescription": {"text!": str},
                            "help": {"text!": str},
                            "defaultConfiguration": {"level": str},
                        }
                    ],
                }
            },
            "results": [
                {
                    "ruleId": str,
                    "ruleIndex": int,
                    "level": str,
                    "message!": {"text": str},
                    "locations": [
                        {
                            "physicalLocation": {
                                "artifactLocation!": {"uri": str},
                                "region": {"startLine": int},
                            },
                            "logicalLocations": [{"fullyQualifiedName": str, "kind": str}],
                        }
                    ],
                }
            ],
        }
    ],
}
"""The part of the schema of SARIF 2.1.0 that is used: types by property, required ones with !."""


def assert_fits(value, schema, at="log"):
    if isinstance(schema, type):
        assert type(value) is schema, at
    elif isinstance(schema, list):
        for number, each in enumerate(value):
            assert_fits(each, schema[0], f"{at}[{number}]")
    else:
        allowed = {name.rstrip("!"): kind for name, kind in schema.items()}
        assert value.keys() <= allowed.keys(), at
        assert {name[:-1] for name in schema if name.endswith("!")} <= value.keys(), at
        for name, each in value.items():
            assert_fits(each, allowed[name], f"{at}.{name}")


def test_sarif_fits_its_schema(rack):
    log = json.loads(run(rack, "--format", "sarif").stdout)
    assert_fits(log, SARIF)
    rules = log["runs"][0]["tool"]["driver"]["rules"]
    assert len({each["id"] for each in rules}) == len(rules)


def test_a_file_is_a_uri_in_sarif(rack, monkeypatch):
    folder = rack.parent / "line 2#a"
    folder.mkdir()
    for each in ("line.rung", "rack.toml"):
        shutil.copy(rack.parent / each, folder)
    monkeypatch.chdir(rack.parent)
    log = json.loads(run("line 2#a/rack.toml", "--format", "sarif").stdout)
    (result,) = log["runs"][0]["results"]
    assert result["locations"][0]["physicalLocation"]["artifactLocation"]["uri"] == "line%202%23a/line.rung"


def test_what_is_proved_says_so_and_what_is_refuted_is_left_out(rack):
    job, _ = load_any(str(rack))
    (found,) = check_rack(job).findings
    proved = check_rack(job, prover=lambda _job, _facts: [ProofFinding(found.rule, found.place, holds=True)])
    assert [each.text for each in proved.findings] == [f"{found.text} (proved)"]
    assert (
        check_rack(
            job, prover=lambda _job, _facts: [ProofFinding(found.rule, found.place, holds=False)]
        ).findings
        == ()
    )
    more = ProofFinding("division-by-zero", FileLine(found.place.file, 1), holds=True, text="it divides by 0")
    assert [each.rule for each in check_rack(job, prover=lambda _job, _facts: [more]).findings] == [
        "contradiction",
        "division-by-zero",
    ]


def test_a_program_of_rslogix_500(tmp_path):
    """A coil twice, a contradiction, a preset of 0, a division by 0, in the lines of the export.

    Proved: the coil of rung 0 is never on, as that of rung 3 waits for a timer that the contradiction stops.
    """
    export_ = slc.export(
        slc.ladder(
            2,
            "XIC I:1.0/0 XIO I:1.0/1 OTE O:2/0",
            "XIC I:1.0/0 XIO I:1.0/0 OTE B3/1",
            "XIC B3/1 TON T4:0 1.0 0 0",
            "XIC T4:0/DN OTE O:2/0",
            "EQU N7:0 3 DIV N7:1 0 N7:0",
            "END",
        ),
        slc.words("N7", [0] * 4),
        slc.words("B3", ["0X0000"] * 2),
        slc.elements("T4", [("0X0000", 0, 0)]),
        slots=[slc.slot(1, "1762-IQ16", "In", 1, 0), slc.slot(2, "1762-OB16", "Out", 0, 1)],
        names={2: "MAIN"},
    )
    file = tmp_path / "line.SLC"
    file.write_text(export_, encoding="utf-8")
    found = [
        each for each in json.loads(run(file, "--json").stdout)["findings"] if each["rule"] != "never-written"
    ]
    lines = export_.splitlines()
    assert [(each["rule"], each["rung"], "SOR" in lines[each["line"] - 1]) for each in found] == [
        ("repeated-coil", 3, True),
        ("contradiction", 1, True),
        ("preset-zero", 2, True),
        ("division-by-zero", 4, True),
        ("constant-condition", 0, True),
    ]


def test_junit(rack):
    suite = ET.fromstring(run(rack, "--format", "junit").stdout)
    assert (suite.get("tests"), suite.get("failures")) == (str(len(RULES)), "1")
    failed = [each.get("name") for each in suite if each.find("failure") is not None]
    assert failed == ["contradiction"]


def test_each_level_is_one_of_sarif():
    assert {rule.level for rule in RULES} <= {"error", "warning", "note"}


@pytest.mark.parametrize(
    ("name", "text", "old", "new"),
    [
        ("a.rung", BLOCKS, "XIC(Alarm)OTE(Horn);", f"// the horn; check: ignore contradiction\n{BROKEN}"),
        ("a.rung", BLOCKS, "XIC(Alarm)OTE(Horn);", f"// check: ignore never-read, Contradiction\n{BROKEN}"),
        (
            "a.rung",
            BLOCKS,
            "TAG Rate : DINT",
            "TAG Rate : DINT\nTAG Spare : DINT  // check: ignore unused-tag",
        ),
        (
            "a.py",
            SEQUENCE,
            "self.parts += 1",
            "self.parts //= 0 + 0\n            self.parts = 1 // 0  # scanrack: ignore[all]",
        ),
        (
            "a.py",
            SEQUENCE,
            "self.parts += 1",
            "# scanrack: ignore[division-by-zero]\n            self.parts = 1 // 0",
        ),
    ],
)
def test_a_comment_ignores_a_finding(name, text, old, new, tmp_path):
    report = check(tmp_path, name, text.replace(old, new))
    assert (report.findings, report.ignored) == ((), 1)


def test_a_comment_for_another_rule_ignores_nothing(tmp_path):
    program = BLOCKS.replace("XIC(Alarm)OTE(Horn);", f"// check: ignore never-read\n{BROKEN}")
    assert [each.rule for each in check(tmp_path, "a.rung", program).findings] == ["contradiction"]


def test_an_export_without_a_rack(tmp_path, unproved):
    copy = Path(shutil.copy(EXPORT, tmp_path))
    assert run(copy).exit_code == 0
    text = copy.read_text(encoding="utf-8")
    copy.write_text(text.replace("XIC(Run)OTE(RunLamp);", "XIC(Run)XIO(Run)OTE(RunLamp);"), encoding="utf-8")
    done = run(copy)
    assert done.exit_code == 1
    assert "contradiction" in done.stdout.splitlines()[0]


@pytest.mark.parametrize("tags", ["", "TAG S : INT[84]\n"])
def test_the_status_file_of_an_slc_is_no_unused_tag(tags, tmp_path, unproved):
    file = tmp_path / "slc.rung"
    text = f"PROGRAM p\nDIALECT slc\n{tags}TAG N7 : INT[2]\nROUTINE Main\nADD(N7:0,1,N7:1);\nEND\n"
    file.write_text(text, encoding="utf-8")
    done = run(file)
    assert (done.stdout, done.exit_code) == ("no findings\n", 0)


def test_rungs_without_a_rack(tmp_path, unproved):
    (tmp_path / "line.rung").write_text(BLOCKS, encoding="utf-8")
    assert run(tmp_path / "line.rung").stdout.splitlines()[0] == "no findings"


def test_what_is_refused_is_a_finding_in_other_formats(tmp_path):
    program = SEQUENCE.replace("self.lamp = self", "self.lmap = self")
    (tmp_path / "a.py").write_text(program, encoding="utf-8")
    (tmp_path / "rack.toml").write_text(
        RACK.replace("PROGRAM", "a.py").replace("CONTROLLER", ""), encoding="utf-8"
    )
    done = run(tmp_path / "rack.toml", "--json")
    line = next(at for at, text in enumerate(program.splitlines(), 1) if "self.lmap" in text)
    (found,) = json.loads(done.stdout)["findings"]
    assert (done.exit_code, found["rule"], found["line"]) == (2, "refused", line)
    assert "did you mean self.lamp" in found["text"]
