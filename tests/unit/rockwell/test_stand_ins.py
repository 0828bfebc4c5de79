"""`scanrack l5x --stand-in`: what a whole controller names and lacks gets a stand-in, and each is listed."""

import json
from typing import Any

import pytest
from l5x_files import data_type, document, ladder, member, program, tag, task
from scanrack.commands import build
from scanrack.jobs.load.program import load_program
from scanrack.ladder.model.stubs import Stubs
from typer.testing import CliRunner

RUNGS = {
    "XIC(Gone)OTE(Lamp);": {"Gone": "BOOL"},
    "MOV(Line.Level,N);": {"Line": "Line_type"},
    r"XIC(\Other.Run)OTL(Lamp);": {r"\Other.Run": "BOOL"},
    "JSR(Nowhere,0);": {r"\Main.Nowhere": "routine that does nothing"},
    "XIC(S.Ready)OTL(Lamp);": {"Simple.Ready": "BOOL"},
    "TON(S.Inner.Delay,?,?);": {"Inside.Delay": "TIMER"},
    "MOV(S.Levels[3],N);": {"Simple.Levels": "DINT[4]"},
}


@pytest.fixture
def export(tmp_path):
    def write(*rungs):
        types = [
            data_type("Inside", member("A", "DINT")),
            data_type("Simple", member("Inner", "Inside"), member("B", "DINT")),
        ]
        tags = [tag("Lamp", "BOOL"), tag("N", "DINT"), tag("S", "Simple")]
        path = tmp_path / "machine.L5X"
        main = program("Main", ladder("Main", *rungs))
        path.write_text(
            document(types=types, tags=tags, programs=[main], tasks=[task("T", "Main")]), encoding="utf-8"
        )
        return path

    return write


def said(path, *options):
    answer = CliRunner().invoke(build(), ["l5x", str(path), "--json", *options])
    return answer.exit_code, json.loads(answer.output)


@pytest.mark.parametrize(("rung", "declared"), RUNGS.items())
def test_a_stand_in_has_the_type_that_its_use_shows(export, rung, declared):
    path = export(rung)
    status, report = said(path)
    (refused,) = report["refused"]
    assert (status, report["ran"], report["declared"]) == (1, 0, {})
    assert refused["remedy"].endswith("; or let --stand-in stand in for it")
    status, report = said(path, "--stand-in")
    assert (status, report["refused"], report["ran"], report["declared"]) == (0, [], 1, declared)


def test_what_is_wrong_has_no_stand_in(export):
    path = export("XIC(N.Ready)OTE(Lamp);", "ADD(Lamp,1,N);")
    for options in ([], ["--stand-in"]):
        status, report = said(path, *options)
        assert (status, report["declared"], len(report["refused"])) == (1, {}, 2)
        assert "--stand-in" not in str(report["refused"])


def test_a_rack_lists_all_stand_ins_in_its_summary(export):
    path = export(*RUNGS)
    loaded: Any = load_program(str(path), stubs=Stubs(missing_tags=True)).function
    names = [f"{name} : {kind}" for each in RUNGS.values() for name, kind in each.items()]
    used = loaded.used_stubs["missing_tags"]
    assert used.startswith("declare: ")
    assert sorted(used.removeprefix("declare: ").split(", ")) == sorted(names)


def test_the_rack_file_declares_what_stands_in(export):
    path = str(export("MOV(S.Extra,N);"))
    answer = CliRunner().invoke(build(), ["l5x", path, "--stand-in", "--print-rack"])
    assert (answer.exit_code, 'missing_tags = "declare"' in answer.output) == (0, True)
