"""One name of a tag, the program's own, in every command; a name that two programs have is ambiguous."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from l5x_files import data_type, document, ladder, member, program, tag, task
from scanrack.commands import build
from scanrack.jobs import open_bench
from scanrack.ladder.debug import Debugger
from scanrack.traces import open_trace
from scanrack.traces.compare import compare, report
from typer.main import get_command
from typer.testing import CliRunner, Result

STEPS = ("ADD(Step,1,Step);", "GRT(Step,4)OTE(Go);")
LOCAL = [tag("Step", "DINT"), tag("Go", "BOOL")]
MACHINE = document(
    types=[data_type("Pair", member("Count", "DINT"), member("On", "BOOL"), member("Name", "STRING"))],
    tags=[tag("Ps", "Pair", "3"), tag("B", "DINT", "40"), tag("Grid", "INT", "2 3"), tag("Word", "STRING")],
    programs=[
        program("A", ladder("Main", *STEPS, "ADD(Ps[1].Count,2,Ps[1].Count);"), tags=LOCAL),
        program("C", ladder("Main", *STEPS, "ADD(B[34],1,B[34]);"), tags=LOCAL),
        program("D", ladder("Main", "ADD(Alone,1,Alone);", "ADD(Grid[1,2],1,Grid[1,2]);")
                + ladder("Rest", "NOP();"), tags=[tag("Alone", "DINT")]),
    ],
    tasks=[task("T", "A", "C", "D")],
)  # fmt: skip
RACK = """
program = "m.L5X"
controller = "compactlogix"
scan_ms = 2
run_for_s = 0.02
tags = ["*"]

[[slot]]
number = 2
module = "1769-IQ16"

[slot.options]
inputs = { start = 3 }
timeline = [{ at_ms = 6, input = "start" }]
"""

TAGS = {
    r"\A.Step": [r"\a.step", "Program:A.Step"],
    r"\D.Alone": ["Alone", "alone", "Program:D.Alone"],
    "Ps[1].Count": ["ps[ 1 ].COUNT"],
    "B[34]": ["b[34]"],
    "Grid[1,2]": ["Grid[1, 2]"],
}
"""Numbers by their names, and other ways to write them."""

BITS = {r"\A.Go": ["Program:A.Go"], r"\A.Step.2": [r"\a.step.2"], "B[34].2": ["b[34].2"]}
IMAGES = {"Local:2:I.Data[0].3": ["I:2.0/3", "I:2/3", "slot2.input.start", "SLOT2.IN.START"]}

Asked = Callable[[str], Result]


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    folder = tmp_path_factory.mktemp("names")
    (folder / "m.L5X").write_text(MACHINE, encoding="utf-8")
    (folder / "m.toml").write_text(RACK, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert scanrack("run", "m.toml", "--record", "m.mcap", "--quiet").exit_code == 0
        yield folder


def scanrack(*words: str) -> Result:
    return CliRunner().invoke(build(), list(words))


def exported(name: str) -> Result:
    return scanrack("export", "m.mcap", "--csv", "-", "--signal", name)


def plotted(name: str) -> Result:
    Path("p.html").unlink(missing_ok=True)
    return scanrack("plot", "m.mcap", "--tag", name, "--out", "p.html")


RECORDED_ANEW = ("--quiet", "--record", "again.mcap", "--replace")


def recorded(name: str) -> Result:
    Path("rack.toml").write_text(RACK.replace('"*"', json.dumps(name)), encoding="utf-8")
    return scanrack("check", "rack.toml")


ASKED: dict[str, tuple[Asked, dict[str, list[str]]]] = {
    "query text": (lambda name: scanrack("query", "m.mcap", f"changed({name})"), TAGS | BITS | IMAGES),
    "query show": (lambda name: scanrack("query", "m.mcap", "scan == 5", "--show", name), TAGS | IMAGES),
    "export signal": (exported, TAGS | BITS | IMAGES),
    "plot tag": (plotted, TAGS | BITS),
    "compare align_at": (lambda bit: scanrack("compare", "m.mcap", "m.mcap", "--align", bit), BITS | IMAGES),
    "compare realign_at": (
        lambda bit: scanrack("compare", "m.mcap", "m.mcap", "--realign", bit),
        BITS | IMAGES,
    ),
    "why what": (lambda name: scanrack("why", "m.mcap", name), TAGS | BITS | IMAGES),
    "why until": (lambda bit: scanrack("why", "m.mcap", r"\A.Step", "--until", bit), BITS | IMAGES),
    "xref tag": (lambda name: scanrack("xref", "m.L5X", name), TAGS),
    "prove outputs": (lambda name: scanrack("prove", "m.L5X", "m.L5X", "--outputs", name), TAGS),
    "prove only": (lambda name: scanrack("prove", "m.L5X", "m.L5X", "--may-differ", name), TAGS),
    "run tag": (lambda name: scanrack("run", "m.toml", *RECORDED_ANEW, "--tag", name), TAGS | BITS),
    "check": (recorded, TAGS | BITS),
}
"""By command and parameter: how it is asked about a tag, and about which."""

OTHERS = {
    "conform counter",
    "conform wire",
    "run server",
    "watch server",
    "watch text",
    "query limit",
    "rules bit",
    "tags tag",
    "l5x stand_in",
    "run retain",
    "why want",
    "export mcap",
    "export csv",
    "export bits",
    "l5x memory",
    "run memory",
    "watch memory",
}
"""Parameters of which the help speaks of tags, bits or signals, and that take no name."""


def parameters() -> Iterator[tuple[str, str]]:
    """All parameters, and what their help says."""
    command: Any = get_command(build())
    with command.make_context("scanrack", [], resilient_parsing=True) as context:
        for name in command.list_commands(context):
            found = command.get_command(context, name)
            for each in found.params if found is not None else ():
                said = f"{getattr(each, 'help', '')} {each.metavar} {each.name}"
                yield f"{name} {each.name}", said


def test_the_walk_knows_every_parameter_that_takes_a_name() -> None:
    takers = {name for name, said in parameters() if re.search(r"(?i)\btags?\b|signal|\bbit\b", said)}
    assert takers - OTHERS <= ASKED.keys(), "a command that takes the name of a tag is not walked here"


@pytest.mark.slow
@pytest.mark.parametrize("command", ASKED)
def test_all_ways_to_write_a_name_mean_the_same(place: Path, command: str) -> None:
    ask, names = ASKED[command]
    for own, others in names.items():
        expected = ask(own)
        assert expected.exit_code in (0, 1), expected.output
        for other in others:
            result = ask(other)
            assert result.exit_code == expected.exit_code, f"{command} {other}: {result.output}"
            if command not in ("why what", "why until"):  # these say the name as it was written
                assert result.output == expected.output, other


@pytest.mark.parametrize("command", ASKED)
def test_a_name_that_two_programs_have_is_ambiguous(place: Path, command: str) -> None:
    ask, names = ASKED[command]
    result = ask("Step" if r"\A.Step" in names else "Go")
    assert result.exit_code == (1 if command == "check" else 2)
    wanted = "Step" if r"\A.Step" in names else "Go"
    assert rf"{wanted} is ambiguous: it is \A.{wanted} or \C.{wanted}" in " ".join(result.output.split())


def test_tags_json_show_and_compare_have_the_programs_own_names(place: Path) -> None:
    with open_trace(place / "m.mcap") as trace, open_trace(place / "m.mcap") as other:
        (table,) = [each.data for each in trace.attachments() if each.name == "tags.json"]
        assert compare(trace, other).same
        assert report(compare(trace, other), ("a", "b"))
    rows = {row["name"]: row for row in json.loads(table)["tags"]}
    assert rows["Ps[0..2].Count"]["elements"] == ["Ps[0].Count", "Ps[1].Count", "Ps[2].Count"]
    assert rows["Ps[0..2].Count"]["field"] == "tags.ps_count"
    assert rows["Grid[0..1,0..2]"]["elements"][5] == "Grid[1,2]"
    assert rows["B"]["length"] == 40
    assert {r"\A.Step", r"\C.Step", r"\D.Alone", "Ps[1].Name"} <= rows.keys()
    shown = scanrack("show", "m.mcap", "--range", "5:5", "--every").output
    assert "Ps[1].Count 10 -> 12" in shown
    assert "Grid[1,2] 5 -> 6" in shown


def test_forces_go_by_the_programs_own_name(place: Path) -> None:
    with open_bench("m.toml", watched=True) as bench:
        bench.force("Program:A.Step", 9)
        bench.force("ps[1].count", 7)
        bench.force("alone", 5)
        assert isinstance(bench.program, Debugger)
        assert bench.program.forces == {r"\A.Step": 9, "Ps[1].Count": 7, r"\D.Alone": 5}
        bench.scan(3)
        assert (bench.program.tags["Alone"], bench.program.tags[r"\a.STEP"]) == (5, 9)
        assert "forced to 5" in bench.why("ALONE")
        bench.unforce(r"\D.Alone")
        with pytest.raises(ValueError, match=r"Step is ambiguous"):
            bench.force("Step", 1)
        with pytest.raises(ValueError, match=r"Ps\[2\].Count is not forced; current forces: .*Ps\[1\].Count"):
            bench.unforce("Ps[2].Count")


@pytest.mark.slow
def test_a_file_of_an_slc_has_its_own_addresses(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    rungs = ("XIC I:2/3 OTE B3/17", "ADD N7:3 1 N7:3", "TON T4:0 0.01 5 0")
    lines = ["SLOT 1 OTHER 3 10 25", 'LADDER 2 "MAIN"', *(f"SOR {each} EOR" for each in rungs)]
    Path("m.SLC").write_text("\n".join([*lines, "DATA N7:0", "0 0 0 0 0"]), encoding="utf-8")
    rack = RACK.replace("m.L5X", "m.SLC").replace("compactlogix", "micrologix").replace("1769", "1762")
    Path("m.toml").write_text(rack, encoding="utf-8")
    assert scanrack("run", "m.toml", "--record", "m.mcap", "--quiet").exit_code == 0
    with open_trace(Path("m.mcap")) as trace:
        assert trace.head.tags is not None
        names = {field.tag.name for field in trace.head.tags.fields}
    assert {"N7:0..4", "B3:0..1", "T4:0..0.ACC"} <= names
    for one, other in (("B3/17", "B3:1/1"), ("N7:3", "N7[3]"), ("T4:0/DN", "T4:0.DN")):
        found = [scanrack("query", "m.mcap", "scan == 8", "--show", name).output for name in (one, other)]
        assert found[0] == found[1]
        assert [scanrack("why", "m.mcap", name).exit_code for name in (one, other)] == [0, 0]
    assert (
        "ago" in scanrack("why", "m.mcap", "N7:3").output
        or "N7:3" in scanrack("why", "m.mcap", "N7:3").output
    )
    assert scanrack("query", "m.mcap", "rose(B3/17)").exit_code == 0
