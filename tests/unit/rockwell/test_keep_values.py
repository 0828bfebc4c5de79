"""An export begins as after a download, or in the middle: `--keep-values`."""

from pathlib import Path
from typing import Any

import pytest
from l5x_files import machine, tag
from scanrack.commands import build
from scanrack.jobs import load_job
from scanrack.ladder.files import parse_program
from scanrack.ladder.model.errors import LadderError
from scanrack.rockwell.l5x import import_l5x
from typer.testing import CliRunner


def controller_of(path: Path) -> Any:
    return import_l5x(path).controller


def begun(name, kind, l5k):
    return tag(name, kind).replace("</Tag>", f'<Data Format="L5K"><![CDATA[{l5k}]]></Data></Tag>')


TAGS = [
    begun("Wait", "TIMER", f"[{(1 << 31 | 1 << 30) - (1 << 32)},1000,400]"),  # EN and TT
    begun("On", "BOOL", 1),
    begun("Shot", "BOOL", 0),
    begun("Lamp", "BOOL", 1),
    tag("Shots", "DINT"),
    tag("Firsts", "DINT"),
]
RUNGS = (
    "XIC(On)TON(Wait,?,?);",
    "XIC(On)ONS(Shot)ADD(Shots,1,Shots);",
    "XIC(S:FS)ADD(Firsts,1,Firsts);",
    "XIC(Wait.DN)OTE(Never);",
    "XIC(Shot)OTE(Lamp);",
)


@pytest.fixture
def path(tmp_path):
    found = tmp_path / "machine.L5X"
    found.write_text(machine(*RUNGS, tags=[*TAGS, tag("Never", "BOOL")]), encoding="utf-8")
    return found


@pytest.mark.parametrize("how", ["compile", "interpret"])
@pytest.mark.parametrize(
    ("keep", "elapsed", "shots", "firsts"),
    [
        (False, 10, 0, 1),  # prescan clears the timer [1756-RM003N p. 118], and sets the storage bit [p. 103]
        (True, 410, 1, 0),  # the storage bit is clear: the rung is an edge
    ],
)
def test_the_first_scan_is_that_after_a_download_or_the_next_one(path, how, keep, elapsed, shots, firsts):
    controller = controller_of(path)
    if keep:
        controller.keep_values()
    engine = getattr(controller, how)()
    engine.step(10)
    engine.step(10)
    tags = engine.tags
    assert (tags["Wait.ACC"], tags["Shots"], tags["Firsts"], tags["Lamp"]) == (elapsed, shots, firsts, True)


def test_a_program_that_has_begun_does_not_begin_again(path):
    controller = controller_of(path)
    controller.step()
    with pytest.raises(LadderError, match="runs already"):
        controller.keep_values()


def test_prescan_comes_after_program_mode_all_the_same(path):
    controller = controller_of(path)
    controller.keep_values()
    engine = controller.compile()
    engine.step(10)
    engine.prescan()
    engine.step(10)
    assert (engine.tags["Wait.ACC"], engine.tags["Firsts"]) == (0, 1)


MIXER = Path(__file__).parents[3] / "examples" / "l5x" / "mixer.L5X"
STEPS = ("Idle", "Filling", "Heating", "Stirring", "Stopping", "Emptying", "Finished")


@pytest.mark.parametrize(("keep", "active"), [(False, ["Idle"]), (True, ["Stirring"])])
def test_a_chart_continues_with_the_step_that_is_active(tmp_path, keep, active):
    """In the middle of a step: 1,200 ms of it are over."""
    shown = '<Structure DataType="SFC_STEP">'
    head = '<Tag Name="Stirring" TagType="Base" DataType="SFC_STEP"'
    before, after = MIXER.read_text(encoding="utf-8").split(head)
    middle = "".join(
        f'<DataValueMember Name="{name}" DataType="{kind}" Value="{value}"/>'
        for name, kind, value in (("X", "BOOL", 1), ("T", "DINT", 1200))
    )
    path = tmp_path / "mixer.L5X"
    path.write_text(before + head + after.replace(shown, shown + middle, 1), encoding="utf-8")
    controller = controller_of(path)
    if keep:
        controller.keep_values()
    for engine in (controller.compile(), controller.interpret()):
        engine.step(10)
        engine.step(10)
        name = next(each for each in engine.lowered.layout.tags() if each.endswith("STIRRING")).rpartition(
            "."
        )[0]
        own = f"{name}." if name else ""
        assert [each for each in STEPS if engine.tags[f"{own}{each}.X"]] == active
        assert engine.tags[f"{own}Stirring.T"] == (1210 if keep else 0)


LOOP = """\
PROGRAM Loop
TAG Level : PID := {{"UPD": 0.1, "MAXS": 100.0, "MAXO": 100.0, "KP": 1.0, "KI": 0.2, "SP": 50.0{rest}}}
TAG In : REAL := 40.0
TAG Out : REAL
ROUTINE Main
PID(Level,In,0,Out,0,0,0);
END
"""


def test_the_output_of_a_loop_goes_on_without_a_bump():
    """The integral term is hidden; what the export shows is the output."""
    usual = parse_program(LOOP.format(rest=""))
    for _ in range(20):
        usual.step()
    shown = usual.tags["Level"]
    rest = f', "SO": {shown["SO"]}, "ERR": {shown["ERR"]}, "PV": {shown["PV"]}, "INI": true'
    again, third = (parse_program(LOOP.format(rest=rest)) for _ in range(2))
    again.keep_values()
    for each in (usual, again, third):
        each.step()
    assert usual.tags["Level"]["SO"] == pytest.approx(again.tags["Level"]["SO"], abs=0.01)
    assert abs(usual.tags["Level"]["SO"] - third.tags["Level"]["SO"]) > 1


# --- what a run says, and where a rack file says it


def invoked(*line):
    answer = CliRunner().invoke(build(), [*map(str, line)])
    return answer.exit_code, " ".join(answer.output.split())


def test_a_run_says_in_one_line_what_prescan_resets(path):
    status, said = invoked("run", path, "--scans", 1, "--no-record")
    assert status == 0
    listed = "Wait.EN, Wait.TT, Wait.ACC, Lamp; --keep-values begins with them"
    assert f"prescan resets 4 values of the export, as after a download: {listed}" in said
    status, said = invoked("run", path, "--scans", 1, "--no-record", "--keep-values")
    assert (status, "prescan resets" in said) == (0, False)


def test_a_rack_file_says_how_its_export_begins(path):
    status, text = invoked("l5x", path, "--print-rack", "--keep-values", "--memory", 64)
    assert (status, "[export] keep_values = true memory_mib = 64" in text) == (0, True)
    rack = path.with_name("rack.toml")
    rack.write_text(
        'program = "machine.L5X"\n[export]\nkeep_values = true\n[[slot]]\nnumber = 1\nmodule = "amci3601"\n',
        encoding="utf-8",
    )
    logic: Any = load_job(str(rack)).logic
    assert logic.keeps_values
    for line in (["run", rack, "--keep-values", "--no-record"], ["watch", rack, "--keep-values"]):
        status, said = invoked(*line)
        assert (status, "--keep-values and --memory are for exports" in said) == (2, True)


@pytest.mark.parametrize("command", ["run", "watch", "l5x"])
def test_the_memory_of_tags_is_at_least_a_mebibyte(path, command):
    assert invoked(command, path, "--memory", 0)[0] == 2


def test_tags_beyond_the_memory_are_refused_with_what_allows_them(tmp_path):
    path = tmp_path / "large.L5X"
    tags = [tag("C", "DINT", "200000"), tag("A", "DINT")]
    path.write_text(machine("MOV(C[1],A);", tags=tags), encoding="utf-8")
    status, said = invoked("l5x", path, "--memory", 1)
    assert (status, "tag C is not declared: it takes 2 MiB; 1 MiB are allowed (--memory)" in said) == (
        1,
        True,
    )
    assert invoked("l5x", path, "--memory", 2)[0] == 0
    status, said = invoked("l5x", tmp_path, "--memory", 1)
    assert (status, "tags that are not declared" in said) == (1, True)
