"""`scanrack check` of programs that stage a module's words in a tag, and copy them in every scan."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from scanrack.commands import build
from typer.testing import CliRunner

EXPORT = Path(__file__).parents[3] / "examples" / "l5x"
HOME = '    { input = "home", first = -1500, last = -1300 },\n'
SPARE = '<Tag Name="Spare" TagType="Base" DataType="DINT" ExternalAccess="Read/Write"></Tag><Tag Name="Index"'

PLANTED = {
    "input not used": ("-31684", "-31700", [("not-configured", "indexer.toml:21")]),
    "home not used": (
        "-31684",
        "-31688",
        [("not-configured", "indexer.toml:19"), ("out-of-range", "indexer.L5X:361")],
    ),
    "home not wired": (HOME, "", [("search-without-switch", "indexer.L5X:384")]),
    "lamp never written": ("XIC(Run)OTE(RunLamp);", "NOP();", [("unused-terminal", "indexer.toml:42")]),
    "lamp written twice": (
        "(Step,90)OTE(",
        "(Step,90)OTE(RunLamp)OTE(",
        [("repeated-coil", "indexer.L5X:338")],
    ),
    "spare tag": ('<Tag Name="Index"', SPARE, [("unused-tag", "indexer.L5X:192")]),
    "word out of range": (
        "Words[0] := 1;",
        "Words[0] := 1; Words[6] := 2500;",
        [("out-of-range", "indexer.L5X:499")],
    ),
}
"""What is replaced everywhere by what, and the rules with the places where it is found."""


@pytest.mark.slow
@pytest.mark.parametrize("mistake", PLANTED)
def test_a_planted_mistake_in_an_export_is_found(mistake, tmp_path):
    old, new, expected = PLANTED[mistake]
    folder = Path(shutil.copytree(EXPORT, tmp_path / "export"))
    changed = 0
    for name in ("indexer.toml", "indexer.L5X"):
        text = (folder / name).read_text(encoding="utf-8")
        changed += text.count(old)
        (folder / name).write_text(text.replace(old, new), encoding="utf-8")
    assert changed
    done = CliRunner().invoke(build(), ["check", str(folder / "indexer.toml"), "--json"])
    findings = json.loads(done.stdout)["findings"]
    assert [(each["rule"], f"{Path(each['file']).name}:{each['line']}") for each in findings] == expected


RACK = 'program = "line.rung"\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n'
STAGED = """\
PROGRAM line
SLOT axis : 1
TAG Words : INT[10]
TAG Go : BOOL
ROUTINE Main
XIC(Go)MOV(1,Words[2]);
XIO(Go)MOV(0,Words[2]);
MOV(2001,Words[8]);
MOV(2001,Words[1]);
COP(Words[2],axis.O.Data,8);
END
"""

TEMPLATE = """\
PROGRAM line
SLOT axis : 1
TAG Words : INT[8] := [1, 0, 0, 0, 1, 0, 1, 1]
TAG Go : BOOL
ROUTINE Main
MOV(4,Words[2]);
XIC(Go)COP(Words,axis.O.Data,8);
END
"""


INDEXED = """\
PROGRAM line
SLOT axis : 1
TAG Words : INT[8] := [0, 0, 0, 0, 0, 0, 2001, 0]
TAG At : INT
ROUTINE Main
MOV(1,Words[At]);
COP(Words,axis.O.Data,7);
END
"""


@pytest.mark.parametrize(
    ("program", "expected"),
    [
        (STAGED, [("out-of-range", 8)]),
        (STAGED.replace("INT[10]", "INT[10] := [0]"), [("out-of-range", 8)]),
        (INDEXED, []),
        (INDEXED.replace("Words[At]", "Words[0]").replace("TAG At : INT\n", ""), [("out-of-range", 6)]),
        (STAGED.replace("XIO(Go)MOV(0,Words[2]);", "NOP();"), [("command-held", 6), ("out-of-range", 8)]),
        (STAGED.replace(",8);", ",4);"), []),
        (TEMPLATE, [("command-held", 7)]),
    ],
)
def test_words_behind_an_offset(program, expected, tmp_path):
    """Word 8 of the tag is word 6 of the module; word 1 is none of it. Four words are no whole image.

    A command whose target is written, and not its first word, is given where it is copied. Which word an
    index reaches is not known, so none of them is a constant.
    """
    (tmp_path / "rack.toml").write_text(RACK, encoding="utf-8")
    (tmp_path / "line.rung").write_text(program, encoding="utf-8")
    done = CliRunner().invoke(build(), ["check", str(tmp_path / "rack.toml"), "--json"])
    findings = json.loads(done.stdout)["findings"]
    found = [(each["rule"], each["line"]) for each in findings]
    assert [each for each in found if each[0] in ("command-held", "out-of-range")] == expected
