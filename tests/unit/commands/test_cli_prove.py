"""`scanrack prove`: lines, statuses, scenarios that fuzz, why and the rack replay, refusals by name."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from l5x_files import document, ladder, program, rung, tag, task
from scanrack.commands import build
from scanrack.commands.programs import prove as prove_command
from scanrack.jobs.load.loading import SCENARIO_TRACE
from scanrack.jobs.prove import checking, proving
from scanrack.ladder.prove import ProgramSystem
from scanrack.ladder.prove.questions import Answers, QuestionLimits
from typer.testing import CliRunner

LINE = """\
PROGRAM line
TAG A : BOOL
TAG B : BOOL
TAG Fwd : BOOL
TAG Rev : BOOL
TAG Limit : DINT := 5
TAG Count : DINT
TAG Dwell : TIMER
SLOT axis : 1
ROUTINE Main
XIC(A)TON(Dwell,500,0);
XIC(Dwell.DN)OTE(Fwd);
XIC(B)XIC(axis.status.IN_ESTOP)OTE(Rev);
LES(Count,Limit)ADD(Count,1,Count);
END
"""
SLOT = '[[slot]]\nnumber = 1\nmodule = "amci3601"\n'
RACK = 'program = "line.rung"\nscan_ms = 10\n[prove]\nscan_ms = [1, 100]\n{properties}' + SLOT


def claim(name: str, *keys: str) -> str:
    return "\n".join(["[[prove.property]]", f'name = "{name}"', *keys, ""])


HOLDS = claim("bounded", 'never = "Count > 5"')
BROKEN = claim("one direction", 'never = "Fwd AND Rev"')
ASSUMED = claim("with B off", 'never = "Fwd AND Rev"', 'assume = ["NOT B"]')


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "line.rung").write_text(LINE, encoding="utf-8")
    return tmp_path


def scanrack(*words: str) -> tuple[int, str]:
    done = CliRunner().invoke(build(), list(words))
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exc_info
    return done.exit_code, done.output


def proved(properties: str, *words: str) -> tuple[int, str]:
    Path("line.toml").write_text(RACK.format(properties=properties), encoding="utf-8")
    return scanrack("prove", "line.toml", *words)


@pytest.mark.slow
def test_what_holds_is_proved_with_its_assumptions(place: Path) -> None:
    status, said = proved(HOLDS + ASSUMED)
    assert status == 0
    assert [line.split("  ")[0] for line in said.splitlines()[:2]] == ["bounded", "with B off"]
    assert said.count("  proved  ") == 2
    assert "scans are 1 to 100 ms apart, in whole ms" in said
    assert "the key stays in run" not in said  # it is turned in some runs
    assert "    runs begin with power-up and initial values" in said
    assert 'happens = ["program mode", "lost link"]' in said
    assert "    NOT B\n" in said
    assert "constant, because nothing writes them: Dwell.PRE = 500, Limit = 5" in said
    assert sorted(each.name for each in (place / "line-prove" / "bounded").iterdir()) == [
        "proof.json",
        "proof.smt2",
    ]


@pytest.mark.slow
def test_other_solvers_check_each_proof(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = checking.solvers()
    if not found:
        pytest.skip("neither z3 nor cvc5 is there")
    status, said = proved(HOLDS, "--check")
    assert status == 0
    for each in found:
        assert f"{each.name} confirms it" in said
    doubtful = checking.Solver("z9 1.0", lambda _script: "sat")
    monkeypatch.setattr(prove_command, "find_solvers", lambda: [doubtful])
    status, said = proved(HOLDS, "--check")
    assert status == 3
    assert re.search(r"bounded +unknown +z9 1.0 refuses the proof, \w+.*: sat", said)
    monkeypatch.setattr(prove_command, "find_solvers", list)
    status, said = proved(HOLDS, "--check")
    assert status == 2
    assert "--check needs another solver, z3 or cvc5: pip install" in said


@pytest.mark.slow
def test_a_refuted_property_has_a_scenario_that_others_replay(place: Path) -> None:
    status, said = proved(BROKEN)
    assert status == 1
    scenario = "line-prove/one_direction/scenario.json"
    # 500 ms in scans of at most 100 ms: the sixth scan; on the rack scan 50 at 10 ms
    assert said.splitlines()[0] == f"one direction  refuted   scan 6   {scenario}"
    assert "on the rack: scan 50 with Local:1:I.Data[1] forced" in said
    assert "A = 1" in said
    status, said = scanrack("fuzz", "line.toml", "--scenario", scenario)
    assert status == 1
    assert "broken: never Fwd AND Rev [one direction]: scan 50, 0.5 s" in said
    assert "Local:1:I.Data[1] = 8 (IN_ESTOP)" in proved(BROKEN)[1]
    status, said = scanrack("why", scenario, "Fwd", "--at", "50")
    assert status == 0
    assert "Fwd is on since 0.5 s (scan 50)" in said


@pytest.mark.slow
def test_two_runs_say_the_same_but_for_times(place: Path) -> None:
    first, second = (json.loads(proved(BROKEN + HOLDS, "--json")[1]) for _ in range(2))
    for each in (first, second):
        for row in each["properties"]:
            assert row.pop("spent_ns") > 0
    assert first == second
    row = first["properties"][0]
    assert any("runs begin with power-up" in each for each in row["assumed"])
    assert any("runs begin with power-up" in each for each in first["assumed"])
    assert (row["verdict"], row["claim"], row["k"]) == ("refuted", "never Fwd AND Rev", 6)
    assert row["rack"]["forced"] == ["Local:1:I.Data[1]"]
    assert sum(each["ms"] for each in row["scans"]) >= 500
    assert first["properties"][1]["held"] == {"Limit": 5}


@pytest.mark.slow
def test_a_state_is_reached_or_not(place: Path) -> None:
    status, said = proved(claim("done", 'reachable = "Dwell.DN"'))
    assert (status, said.split()[:4]) == (0, ["done", "reached", "scan", "6"])
    assert "on the rack: scan 50, without forced inputs" in said
    status, said = proved(claim("more", 'reachable = "Count = 6"'))
    assert (status, said.split()[:6]) == (1, ["more", "refuted", "no", "run", "reaches", "it"])


def test_a_program_without_a_rack_has_the_claims_of_its_comments(place: Path) -> None:
    (place / "line.rung").write_text(
        LINE.replace("XIC(Dwell.DN)", "// prove: never Fwd AND NOT A\nXIC(Dwell.DN)"), encoding="utf-8"
    )
    status, said = scanrack("prove", "line.rung")
    assert status == 0
    assert said.startswith("never Fwd AND NOT A  proved")


def test_comments_of_exports_are_claims(place: Path) -> None:
    rungs = (
        rung("XIC(A)OTE(Fwd);", number=0, comment="forward\nprove: never Fwd AND Own"),
        rung("XIO(A)OTE(Own);", number=1, comment="PROVE: always Own <> Fwd;"),
    )
    main = program("Main", ladder("Go", *rungs), tags=[tag("Own", "BOOL")])
    exported = document(
        tags=[tag("A", "BOOL"), tag("Fwd", "BOOL")], programs=[main], tasks=[task("T", "Main")]
    )
    (place / "line.L5X").write_text(exported, encoding="utf-8")
    status, said = scanrack("prove", "line.L5X")
    assert (status, said.count("  proved  ")) == (0, 2)
    lines = ["SLOT 1 OTHER 3 10 25", 'LADDER 2 "MAIN"', "% prove: never B3/1 AND B3:0/2 %"]
    lines += ["SOR XIC I:2/3 OTE B3/1 EOR", "SOR XIC I:2/4 OTE B3/2 EOR"]
    (place / "line.SLC").write_text("\n".join(lines), encoding="utf-8")
    status, said = scanrack("prove", "line.SLC")
    assert (status, said.split("  ")[:2]) == (
        1,
        ["never B3:0/1 AND B3:0/2".replace("B3:0/1", "B3/1"), "refuted"],
    )


@pytest.mark.slow
def test_a_fault_stops_the_rack(place: Path) -> None:
    text = LINE.replace("TAG Count", "TAG List : DINT[4]\nTAG Count").replace(
        "END\n", "MOV(1,List[Count]);\nEND\n"
    )
    (place / "line.rung").write_text(text, encoding="utf-8")
    status, said = proved("")
    assert status == 1
    # Count is 1 after the first scan, and 4 after the fourth, number 3
    assert "on the rack: the controller faults in scan 3" in said


@pytest.mark.slow
def test_numbers_that_change_from_outside_are_free(place: Path) -> None:
    changing = HOLDS.replace("[[", 'free = ["Limit"]\n[[', 1)
    status, said = proved(changing)
    assert status == 1
    assert "Limit = " in said


@pytest.mark.parametrize(
    ("program", "says"),
    [
        ("line.py", "the program is in Python; proofs cover only ladder logic and structured text"),
        ("twice.rung", "routine \\Main.Fault"),
    ],
)
def test_what_no_proof_covers_is_refused_by_name(place: Path, program: str, says: str) -> None:
    (place / "line.py").write_text("def logic(scan):\n    pass\n", encoding="utf-8")
    (place / "twice.rung").write_text(
        "CONTROLLER two\nPROGRAM Main MAIN Go FAULT Fault\nTAG A : BOOL\n"
        "ROUTINE Go\nOTE(A);\nEND\nROUTINE Fault\nNOP();\nEND\nEND PROGRAM\n",
        encoding="utf-8",
    )
    (place / "rack.toml").write_text(f'program = "{program}"\n{SLOT}', encoding="utf-8")
    status, said = scanrack("prove", "rack.toml")
    assert status == 2
    assert says.upper() in said.upper()


def test_nothing_to_prove_says_what_to_write(place: Path) -> None:
    status, said = proved("")
    assert status == 0
    assert "questions about rungs, contacts, coils and faults" in said
    assert "no properties: a rack file has [[prove.property]]" in said


def test_built_in_questions_find_what_is_dead_and_what_faults(place: Path) -> None:
    more = "XIC(A)XIO(A)OTE(Rev);\nDIV(Count,Divisor,Count);\nEND\n"
    text = LINE.replace("END\n", more).replace("TAG Count", "TAG Divisor : DINT\nTAG Count")
    (place / "line.rung").write_text(text, encoding="utf-8")
    status, said = proved("")
    assert status == 1
    assert "dead-rung   line.rung:16: routine Main, rung 4: no output of rung 4 ever has power" in said
    assert "conflict" in said  # rung 2 sets Rev, rung 4 clears it
    fault = next(line for line in said.splitlines() if line.startswith("fault "))
    assert "rung 5" in fault
    scenario = fault.rpartition("   ")[2]
    assert json.loads((place / scenario).read_text(encoding="utf-8"))["orders"] == []


def test_a_mistake_in_a_property_names_it(place: Path) -> None:
    status, said = proved(claim("typo", 'never = "Fdw"'))
    assert status == 2
    assert "property 'typo': Fdw: no tag Fdw (did you mean Fwd?)" in said


def test_two_programs_differ_where_the_edit_reaches(place: Path) -> None:
    (place / "new.rung").write_text(LINE.replace("XIC(B)XIC(axis", "XIO(B)XIC(axis"), encoding="utf-8")
    status, said = scanrack("prove", "line.rung", "line.rung")
    # Fwd, Rev, Count and the EN, TT, DN and ACC of the timer
    assert (status, said.splitlines()[0][:49]) == (0, "0 of 7 bits and numbers can differ, 0 in one scan")
    status, said = scanrack("prove", "line.rung", "new.rung")
    assert status == 1
    assert said.splitlines()[1] == "Rev  now    scan 1   new-prove/Rev/scenario.json"
    assert "depends on B, Local:1:I.Data[1]" in said
    status, said = scanrack("prove", "line.rung", "new.rung", "--may-differ", "rev", "--json")
    assert status == 0
    assert json.loads(said)["changed"][0]["tag"] == "Rev"
    status, said = scanrack("prove", "line.rung", "new.rung", "--may-differ", "Fwd,Dwell")
    assert status == 1
    status, said = scanrack("prove", "line.rung", "new.rung", "--outputs", "Fwd,Dwell")
    assert (status, said.splitlines()[0][:49]) == (0, "0 of 5 bits and numbers can differ, 0 in one scan")
    status, said = scanrack("prove", "line.rung", "new.rung", "--outputs", "Rev")
    assert (status, said.splitlines()[0][:49]) == (1, "1 of 1 bits and numbers can differ, 1 in one scan")


def test_a_bit_that_only_one_program_writes_is_no_input_of_the_other(place: Path) -> None:
    """Run is 0 in the old program, whatever the new one makes of Start: only its own copy can differ."""
    head = "PROGRAM line\nTAG Start : BOOL\nTAG Run : BOOL\nTAG Lamp : BOOL\nROUTINE Main\n"
    (place / "old.rung").write_text(f"{head}XIC(Run)OTE(Lamp);\nEND\n", encoding="utf-8")
    (place / "new.rung").write_text(
        f"{head}XIC(Start)XIO(Start)OTE(Run);\nXIC(Run)OTE(Lamp);\nEND\n", encoding="utf-8"
    )
    status, said = scanrack("prove", "old.rung", "new.rung")
    assert (status, said.splitlines()[0][:49]) == (0, "0 of 2 bits and numbers can differ, 0 in one scan")


def test_mistakes_of_a_comparison_are_named(place: Path) -> None:
    assert scanrack("prove", "line.rung", "--may-differ", "Rev") == (
        2,
        "scanrack: --may-differ needs two programs: scanrack prove OLD NEW --may-differ TAGS\n",
    )
    status, said = scanrack("prove", "line.rung", "line.rung", "--may-differ", "Revv")
    assert (status, "--may-differ Revv: no tag Revv (did you mean Rev?)" in said) == (2, True)
    status, said = scanrack("prove", "line.rung", "line.rung", "--may-differ", "Count.3")
    assert (status, "only whole numbers are compared, not their bits" in said) == (2, True)


@pytest.mark.slow
def test_the_page_draws_the_rungs_that_decide_with_their_power(place: Path) -> None:
    status, _ = proved(BROKEN + claim("<b>", 'never = "Count > 5"'), "--html", "page.html")
    assert status == 1
    page = Path("page.html").read_text(encoding="utf-8")
    assert page.startswith("<!doctype html>")
    assert "&lt;b&gt;" in page
    assert "<b>" not in page.replace('<b class="', "")
    # the timer, both coils; not the counter
    assert [name in page for name in (">Dwell<", ">Fwd<", ">Rev<", ">Count<")] == [True, True, True, False]
    assert "live" in page.partition("<svg")[2]
    assert scanrack("prove", "line.rung", "line.rung", "--html", "two.html")[0] == 0
    assert "0 of 7 bits and numbers can differ" in Path("two.html").read_text(encoding="utf-8")


COILS = (
    LINE.replace("TAG Count", "TAG Jog : BOOL\nTAG Count")
    .replace("PROGRAM line", "PROGRAM line\nALLOW repeated coils")
    .replace("END\n", "XIC(Dwell.DN)XIC(Jog)OTE(Rev);\nEND\n")
)


@pytest.mark.slow
def test_coils_that_disagree_do_so_on_the_rack(place: Path) -> None:
    """B and Jog: the two rungs of Rev write different values."""
    (place / "line.rung").write_text(COILS, encoding="utf-8")
    status, said = proved("", "--json")
    (found,) = [each for each in json.loads(said)["found"] if each["rule"] == "conflict"]
    assert status == 1
    assert re.match(r"on the rack: scan \d+ with Local:1:I", found["rack"])
    assert Path(found["scenario"]).with_name(SCENARIO_TRACE).exists()


@pytest.mark.slow
def test_what_differs_does_so_on_the_rack(place: Path) -> None:
    """The dwell is 200 ms less: both racks have the same orders, and Fwd comes earlier on one of them."""
    Path("other.rung").write_text(LINE, encoding="utf-8")
    Path("line.toml").write_text(RACK.format(properties=""), encoding="utf-8")
    Path("line.rung").write_text(LINE.replace("TON(Dwell,500,0)", "TON(Dwell,300,0)"), encoding="utf-8")
    status, said = scanrack("prove", "other.rung", "line.toml", "--json")
    changed = {each["tag"]: each["rack"] for each in json.loads(said)["changed"]}
    assert status == 1
    assert changed["Fwd"] == {"confirmed": True, "scan": 30, "forced": [], "why": ""}


def test_nothing_is_asked_about_the_inside_of_shipped_blocks(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = []

    def ask(problem: ProgramSystem, routines: set[str], **_others: object) -> Answers:
        asked.append((routines, "MC_HOME.LOGIC" in problem.lowered.routines))
        return Answers()

    monkeypatch.setattr(proving, "ask", ask)
    block = "USE axis3601\nTAG Drive : AXIS_3601\nTAG Home : MC_Home\n"
    call = "XIC(A)MC_Home(Home,Drive,A,-1,2000,10,10);\nEND\n"
    (place / "line.rung").write_text(
        LINE.replace("TAG A ", block + "TAG A ").replace("END\n", call), encoding="utf-8"
    )
    proved("")
    assert asked == [({"MAIN"}, True)]


LATCH = """\
PROGRAM line
TAG Start : BOOL
TAG Run : BOOL
TAG Valve : BOOL
TAG Lost : BOOL
TAG Count : DINT
SLOT axis : 1
ROUTINE Main
XIC(Valve)XIO(Run)OTE(Lost);
[XIC(Start),XIC(Run)]OTE(Run);
XIC(Run)OTL(Valve);
XIO(Run)OTU(Valve);
END
"""


@pytest.mark.slow
def test_a_scenario_turns_the_key_and_the_rack_does_it(place: Path) -> None:
    (place / "line.rung").write_text(LATCH, encoding="utf-8")
    claims = claim("valve", 'never = "Lost"')
    status, said = proved(claims)
    assert status == 1
    assert said.startswith("valve  refuted   scan 2 ")
    assert "the key was turned to program and back to run" in said
    assert re.search(r"on the rack: scan \d+, without forced inputs", said)
    scenario = place / "line-prove" / "valve" / "scenario.json"
    modes = re.findall(r'"mode": "(\w+)"', scenario.read_text(encoding="utf-8"))
    assert modes == ["program", "run"]
    status, said = scanrack("fuzz", "line.toml", "--scenario", str(scenario))
    assert status == 1, said
    assert proved("happens = []\n" + claims)[0] == 0


SLOW = """\
PROGRAM line
TAG Go : BOOL
TAG T : TIMER
TAG Over : BOOL
SLOT axis : 1
ROUTINE Main
XIC(Go)TON(T,100,0);
GRT(T.ACC,150)OTE(Over);
END
"""


@pytest.mark.slow
def test_what_only_longer_scans_than_the_racks_break_says_so_first(place: Path) -> None:
    (place / "line.rung").write_text(SLOW, encoding="utf-8")
    status, said = proved(claim("over", 'never = "Over"'))
    assert status == 1
    assert "over  refuted   only with scans longer than the rack's: with scans of 10 ms it is proved" in said


@pytest.mark.slow
def test_what_the_rack_does_on_its_own_is_no_finding(place: Path) -> None:
    """Thirty seconds of a timer are three thousand scans: no search goes as far."""
    late = LINE.replace("XIC(A)TON(Dwell,500,0);", "TON(Dwell,1000,0)XIC(Dwell.DN)CTU(Long,3,0);")
    late = late.replace("TAG A :", "TAG Long : COUNTER\nTAG A :").replace(
        "END\n", "XIC(Long.DN)OTE(A);\nEND\n"
    )
    late = late.replace("TON(Dwell", "XIO(Dwell.DN)TON(Dwell")
    (place / "line.rung").write_text(late, encoding="utf-8")
    status, said = proved("")
    assert status == 0
    assert "Long is never done" not in said
    assert "are open" not in said


def test_work_multiplies_the_limits(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (place / "rack.toml").write_text(RACK.format(properties=HOLDS), encoding="utf-8")
    used = []

    def ask(*_args: object, limits: QuestionLimits, **_named: object) -> Answers:
        used.append(limits)
        return Answers()

    monkeypatch.setattr(proving, "ask", ask)
    for words in ((), ("--work", "7")):
        assert scanrack("prove", "rack.toml", *words)[0] == 0
    plain, more = used
    assert (more.each.work, more.each.fuse) == (7 * plain.each.work, 7 * plain.each.fuse)
    assert (more.rule, more.states) == (7 * plain.rule, 7 * plain.states)
    status, said = scanrack("prove", "rack.toml", "--work", "0")
    assert status == 2
    assert "--work" in said
