"""What the debugger and `scanrack ladder --at` say of a running timer: EN, TT, DN, PRE and ACC."""

import pytest
from ladder_bench import program_of
from scanrack.commands import build
from scanrack.ladder.debug import Debugger
from typer.testing import CliRunner

TAGS = """TAG Run : BOOL
TAG Late : BOOL
TAG Fill : TIMER
TAG All : TIMER[2]
TAG Parts : COUNTER
TAG N : DINT"""
RUNGS = (
    "XIC(Run)TON(Fill,1000,0);",
    "XIC(Fill.DN)OTE(Late);",
    "XIC(Run)[CTU(Parts,3,0),TON(All[1],?,?)]TON(All[N+0],?,?);",
)


@pytest.fixture
def running():
    """A timer that has run for 30 ms, in steps of 10 ms: the first true scan counts nothing."""
    debugger = Debugger(program_of(TAGS, *RUNGS))
    debugger.tags["All[1].PRE"] = 70
    debugger.scan()
    debugger.tags.Run = True
    debugger.scan(4)
    return debugger


def test_why_of_a_timer_speaks_of_its_bits_and_of_acc(running):
    lines = running.why("Fill").splitlines()
    assert lines[0] == "Fill: EN = 1, TT = 1, DN = 0, ACC = 30 of PRE = 1000"
    assert lines[1].startswith("Fill.TT is 1 since scan 1 (0.01 s): TON(Fill,1000,0)")
    running.scan(200)
    assert running.why("Fill").splitlines()[1].startswith("Fill.DN is 1 since scan 101 (1.01 s)")


def test_why_of_a_counter_and_of_one_that_never_ran(running):
    parts = "Parts: CU = 1, CD = 0, DN = 0, OV = 0, UN = 0, ACC = 1 of PRE = 3\n"
    assert running.why("Parts").startswith(parts)
    fresh = Debugger(program_of(TAGS, *RUNGS))
    assert fresh.why("Fill").startswith(
        "Fill is EN = 0, TT = 0, DN = 0, ACC = 0 of PRE = 1000 and has not changed"
    )


def test_no_answer_names_what_is_hidden(running):
    running.scan(300)
    for tag in ("Fill", "Fill.DN", "Fill.ACC", "All", "All[1]", "Parts", "Late"):
        assert "~" not in running.why(tag)


def test_a_condition_on_dn_says_how_far_the_timer_is(running):
    running.scan(200)
    running.tags.Run = False
    running.scan()
    assert "XIC(Fill.DN) [Fill.DN = 0, Fill.ACC = 0, Fill.PRE = 1000]" in running.why("Late")


def test_a_picture_shows_presets_and_accumulators_as_they_stand(running):
    picture = running.picture("Main")
    for line in ("Preset 1000", "Accum    30", "Timer  All[1]", "Preset     70", "Accum      30"):
        assert line in picture, picture
    # a subscript that is an expression keeps what the rung says
    assert "Timer  All[N+0]" in picture
    assert "Accum         ?" in picture
    assert ">30</text>" in running.svg()


def test_the_command_shows_them_at_a_time(tmp_path):
    tmp_path.joinpath("line.rung").write_text(
        "PROGRAM line\nSLOT card : 1\nTAG T : TIMER\nROUTINE Main\n"
        "XIC(card.status.MODULE_OK)TON(T,1000,0);\nEND\n",
        encoding="utf-8",
    )
    rack = tmp_path / "line.toml"
    rack.write_text(
        'program = "line.rung"\nscan_ms = 2\n[[slot]]\nnumber = 1\nmodule = "amci3601"\nfirmware = "4.1"\n',
        encoding="utf-8",
    )
    drawn = CliRunner().invoke(build(), ["ladder", str(rack), "--at", "200 ms"]).stdout
    accumulated = next(line for line in drawn.splitlines() if "Accum" in line)
    assert 190 <= int(accumulated.split("Accum")[1].split()[0]) <= 200, drawn
    plain = CliRunner().invoke(build(), ["ladder", str(rack)]).stdout
    assert "Accum     0" in plain
