"""`scanrack debug` on a rack that runs: steps, breakpoints, values, and backwards."""

from __future__ import annotations

from pathlib import Path

import pytest
from debug_client import DebugClient, RefusedError
from scanrack.jobs import load_job
from scanrack.ladder.debug import Debugger

pytestmark = pytest.mark.slow

RACK = """
name = "counting"
program = "counting.rung"
scan_ms = 2
[[slot]]
number = 1
module = "1762-IQ8"
"""
PROGRAM = """PROGRAM counting
SLOT card : 1
INSTRUCTION Twice
INPUT In : DINT REQUIRED
OUTPUT Out : DINT REQUIRED
LOCAL Sum : DINT
ROUTINE Logic
ADD(In,In,Sum);
MOV(Sum,Out);
END
END INSTRUCTION
TAG Number : DINT
TAG Double : Twice
TAG Result : DINT
TAG Big : BOOL
TAG Table : INT[4] := [1, 2, 3, 4]
TAG Slow : TIMER
ROUTINE Main
ADD(Number,1,Number);
Twice(Double,Number,Result);
GRT(Result,10)OTE(Big);
JSR(Sub);
XIC(Big)TON(Slow,20,0);
END
ROUTINE Sub
MOV(Result,Table[0])MOV(Number,Table[1]);
END
"""
"""One scan counts by one; after scan n `Number` is n + 1 and `Result` 2 n + 2. `Big` is on from scan 5 on."""


def line_of(text: str) -> int:
    return PROGRAM[: PROGRAM.index(text)].count("\n") + 1


@pytest.fixture
def rack(tmp_path: Path) -> Path:
    (tmp_path / "counting.toml").write_text(RACK, encoding="utf-8")
    (tmp_path / "counting.rung").write_text(PROGRAM, encoding="utf-8")
    return tmp_path / "counting.toml"


@pytest.fixture
def program(rack: Path) -> Path:
    return rack.with_suffix(".rung")


def begin(client: DebugClient, rack: Path) -> None:
    """Stand before the first rung of scan 0."""
    client.begin(rack, speed="max")
    client.ask("configurationDone")
    assert client.stopped() == ("step", 0)


def test_steps_over_rungs_into_routines_and_scans(client: DebugClient, rack: Path) -> None:
    begin(client, rack)
    places = [client.at()]
    for command in ("next", "stepIn", "next", "stepOut", "next", "stepIn", "stepOut", "next"):
        client.go(command)
        places.append(client.at())
    assert places == [
        "Main, rung 0",
        "Main, rung 1",
        "Twice.Logic, rung 0 of Double",
        "Twice.Logic, rung 1 of Double",
        "Main, rung 2",
        "Main, rung 3",
        "Sub, rung 0",
        "Main, rung 4",
        "Main, rung 0",
    ]
    assert client.scan() == 1


def test_frames_are_rung_callers_and_scan(client: DebugClient, rack: Path, program: Path) -> None:
    begin(client, rack)
    client.go("next")
    client.go("stepIn")
    frames = client.frames()
    assert [each["name"] for each in frames] == [
        "Twice.Logic, rung 0 of Double",
        "Main, rung 1",
        "scan 0, 0 s",
    ]
    assert [each["line"] for each in frames[:2]] == [line_of("ADD(In"), line_of("Twice(Double")]
    assert frames[0]["source"]["path"] == str(program)


def test_values_are_those_before_the_rung(client: DebugClient, rack: Path) -> None:
    begin(client, rack)
    assert client.value("Number") == "0"
    client.go("next")
    assert (client.value("Number"), client.value("Result")) == ("1", "0")
    client.go("next")
    assert client.value("Result") == "2"
    client.go("next", granularity="instruction")
    assert client.value("Big") == "0"


def test_an_instruction_is_a_step(client: DebugClient, rack: Path) -> None:
    begin(client, rack)
    for _ in range(3):
        client.go("next")
    client.go("stepIn")
    assert client.at() == "Sub, rung 0"
    client.go("stepIn", granularity="instruction")
    assert (client.at(), client.value("Table[0]"), client.value("Table[1]")) == ("Sub, rung 0", "2", "2")
    client.go("stepBack", granularity="instruction")
    assert client.value("Table[0]") == "1"


def test_going_back_repeats_the_way_forwards(client: DebugClient, rack: Path) -> None:
    begin(client, rack)
    places = []
    for _ in range(12):
        places.append((client.scan(), client.at(), client.value("Result")))
        client.go("next")
    for before in reversed(places):
        client.go("stepBack")
        assert (client.scan(), client.at(), client.value("Result")) == before
    with pytest.raises(RefusedError, match="scan 0 is the first scan"):
        client.go("stepBack")


def test_breakpoints_of_lines_with_conditions_and_hit_counts(
    client: DebugClient, rack: Path, program: Path
) -> None:
    client.begin(rack, speed="max")
    client.ask("configurationDone")
    client.stopped()
    (answer,) = client.break_at(program, line_of("MOV(Sum"))
    assert answer["verified"]
    assert client.go() == ("breakpoint", 0)
    assert client.at() == "Twice.Logic, rung 1 of Double"
    client.break_at(program, line_of("MOV(Sum"), condition="Result > 40")
    assert client.go() == ("breakpoint", 20)
    client.break_at(program, line_of("MOV(Sum"), hitCondition="% 7")
    assert client.go() == ("breakpoint", 27)
    client.break_at(program, line_of("MOV(Sum"), hitCondition="3")
    assert client.go() == ("breakpoint", 30)


def test_power_of_a_rung_is_a_condition(client: DebugClient, rack: Path, program: Path) -> None:
    begin(client, rack)
    client.break_at(program, line_of("GRT("), condition="becomes true")
    assert client.go() == ("breakpoint", 5)
    assert client.at() == "Main, rung 2"


def test_a_comment_moves_to_the_next_rung_and_no_rung_is_refused(
    client: DebugClient, rack: Path, program: Path, tmp_path: Path
) -> None:
    begin(client, rack)
    first, last = client.break_at(program, line_of("ROUTINE Main"), 999)
    assert first["line"] == line_of("ADD(Number")
    assert (last["verified"], "no instruction" in last["message"]) == (False, True)
    other = tmp_path / "other.rung"
    other.write_text("PROGRAM other", encoding="utf-8")
    (refused,) = client.break_at(other, 1)
    assert "other.rung is not a file of the program, which has counting.rung" in refused["message"]


def test_log_points_print_and_do_not_stop(client: DebugClient, rack: Path, program: Path) -> None:
    begin(client, rack)
    client.break_at(
        program, line_of("GRT("), logMessage="n = {Number}, twice {Result}", condition="Number <= 4"
    )
    client.ask("setFunctionBreakpoints", breakpoints=[{"name": "scan == 9"}])
    assert client.go() == ("function breakpoint", 9)
    printed = [each["body"]["output"] for each in client.events if each.get("event") == "output"]
    printed += [each["body"]["output"] for each in client.skipped if each.get("event") == "output"]
    assert printed == ["n = 2, twice 4\n", "n = 3, twice 6\n", "n = 4, twice 8\n"]


@pytest.mark.parametrize(
    ("name", "stops"),
    [
        ("Big changes", [5]),
        ("Number changes", [1, 2, 3]),
        ("Result > 20 and not Slow.DN", [10]),
        ("rose(Big)", [5]),
        ("Main.3", [0, 1, 2]),
        ("Sub", [0, 1, 2]),
        ("time >= 30 ms", [15]),
    ],
)
def test_function_breakpoints(client: DebugClient, rack: Path, name: str, stops: list[int]) -> None:
    begin(client, rack)
    answer = client.ask("setFunctionBreakpoints", breakpoints=[{"name": name}])
    assert answer["breakpoints"][0]["verified"]
    assert [client.go() for _ in stops] == [("function breakpoint", each) for each in stops]


def test_a_change_stands_after_its_write(client: DebugClient, rack: Path) -> None:
    begin(client, rack)
    body = client.ask("dataBreakpointInfo", name="Result")
    assert body["dataId"] == "Result"
    client.ask("setDataBreakpoints", breakpoints=[{"dataId": "Result"}])
    assert client.go() == ("data breakpoint", 1)
    assert (client.at(), client.value("Number"), client.value("Result")) == ("Main, rung 1", "2", "4")
    client.go("stepBack")
    assert (client.at(), client.value("Result")) == ("Main, rung 1", "2")


def test_backwards_meets_what_forwards_has_met(client: DebugClient, rack: Path, program: Path) -> None:
    begin(client, rack)
    client.break_at(program, line_of("GRT("), condition="Number == 3 or Number == 150 or Number == 290")
    client.ask(
        "setFunctionBreakpoints",
        breakpoints=[{"name": "Big changes"}, {"name": "Sub", "condition": "Number == 150"}],
    )
    met = [(client.go(), client.at(), client.value("Result")) for _ in range(5)]
    assert [stop[1] for stop, _at, _value in met] == [2, 5, 149, 149, 289]
    back = [(client.go("reverseContinue"), client.at(), client.value("Result")) for _ in range(4)]
    assert back == met[-2::-1]
    assert client.go("reverseContinue") == ("entry", 0)


def test_from_a_past_scan_continuing_is_refused_once(client: DebugClient, rack: Path) -> None:
    begin(client, rack)
    client.ask("setFunctionBreakpoints", breakpoints=[{"name": "scan == 20"}])
    client.go()
    for _ in range(8):
        client.go("stepBack")
    scan = client.scan()
    assert scan < 20
    assert client.frames()[-1]["name"].endswith("(past)")
    with pytest.raises(RefusedError, match=f"this is scan {scan}, and the rack is at scan 20"):
        client.go()
    assert client.value("return") == "back at scan 20"
    assert client.stopped() == ("pause", 20)
    client.ask("setFunctionBreakpoints", breakpoints=[{"name": "scan == 22"}])
    assert client.go() == ("function breakpoint", 22)


def test_a_branch_continues_from_a_past_scan(client: DebugClient, rack: Path) -> None:
    begin(client, rack)
    client.ask("setFunctionBreakpoints", breakpoints=[{"name": "scan == 20"}])
    client.go()
    client.value("set Number = 1000")
    client.ask("setFunctionBreakpoints", breakpoints=[{"name": "scan == 30"}])
    client.go()
    assert client.value("Number") == "1010"
    for _ in range(40):
        client.go("stepBack")
    scan = client.scan()
    before = client.value("Number")
    with pytest.raises(RefusedError, match="past"):
        client.value("set Number = 5")
    assert client.value("branch") == f"a new session continues from scan {scan + 1}"
    assert client.stopped() == ("pause", scan)
    assert int(client.value("Number")) == int(before) + (client.value("Number") != before)
    client.value("set Number = 5")
    assert client.go("next") == ("step", scan + 1)
    client.go("next")
    assert client.value("Number") == "6"


def test_values_are_set_forced_and_released(client: DebugClient, rack: Path) -> None:
    begin(client, rack)
    tags = next(each for each in client.ask("scopes", frameId=1)["scopes"] if each["name"] == "Tags")
    reference = tags["variablesReference"]
    assert (
        client.ask("setVariable", variablesReference=reference, name="Number", value="16#64")["value"]
        == "100"
    )
    assert client.value("Number") == "100"
    client.value("force Result = 7")
    client.ask("setFunctionBreakpoints", breakpoints=[{"name": "scan == 3"}])
    client.go()
    assert (client.value("Number"), client.value("Result")) == ("103", "7 (forced)")
    client.value("release Result")
    client.ask("setFunctionBreakpoints", breakpoints=[{"name": "scan == 4"}])
    client.go()
    assert client.value("Result") == "208"


def test_structures_and_arrays_open_lazily(client: DebugClient, rack: Path) -> None:
    begin(client, rack)
    tags = client.scope("Tags")
    assert tags["Table"]["indexedVariables"] == 4
    elements = client.opened(tags["Table"]["variablesReference"], start=2, count=1)
    assert {name: each["value"] for name, each in elements.items()} == {"[2]": "3"}
    assert set(client.scope("Timers")) == {"Slow"}
    timer = client.opened(client.scope("Timers")["Slow"]["variablesReference"])
    assert timer["PRE"]["value"] == "20"
    client.go("next")
    client.go("stepIn")
    assert {"In", "Out", "Sum"} <= set(client.scope("Locals"))
    assert {"Double", "Number", "Result"} <= set(client.scope("Rung", frame=2))
    slot = client.scope("Inputs")["slot 1"]
    words = client.opened(slot["variablesReference"])
    assert words
    assert client.opened(next(iter(words.values()))["variablesReference"])


def test_expressions_hover_and_why(client: DebugClient, rack: Path, program: Path) -> None:
    begin(client, rack)
    client.ask("setFunctionBreakpoints", breakpoints=[{"name": "scan == 8"}])
    client.go()
    assert client.value("Number * 2 == Result and not Slow.DN") == "1"
    assert client.value("Big", context="hover") == "Big = 1; since scan 5"
    assert client.value("why Big").startswith("Big on (0.01 s, Main rung 2: GRT(Result,10)")
    links = [each["body"] for each in client.events if each.get("event") == "output"]
    assert [(each["source"]["path"], each["line"]) for each in links] == [
        (str(program), line_of("Twice(Double")),
        (str(program), line_of("ADD(Number")),
    ]
    with pytest.raises(RefusedError, match="no tag, word or bit Nothing"):
        client.value("Nothing + 1")
    for each in ("count(Big)", "Big for 20 ms", "Big then Slow.DN within 1 s"):
        with pytest.raises(RefusedError, match="several scans: use scanrack query"):
            client.value(each)


def test_the_same_scan_as_a_debugger_of_python(client: DebugClient, rack: Path) -> None:
    debugger = Debugger(load_job(str(rack)).logic)  # type: ignore[arg-type]  # it is a ladder program
    debugger.scan(7, ms=2)
    begin(client, rack)
    client.ask("setFunctionBreakpoints", breakpoints=[{"name": "scan == 6"}])
    client.go()
    assert [client.value(each) for each in ("Number", "Result", "Slow.ACC")] == [
        str(debugger.tags[each]) for each in ("Number", "Result", "Slow.ACC")
    ]


def test_a_pause_stops_after_a_scan(client: DebugClient, rack: Path) -> None:
    begin(client, rack)
    client.ask("continue", threadId=1)
    with pytest.raises(RefusedError, match="scans run; pause first"):
        client.frames()
    client.ask("pause", threadId=1)
    reason, scan = client.stopped()
    assert reason == "pause"
    assert client.value("Number") == str(scan + 1)
