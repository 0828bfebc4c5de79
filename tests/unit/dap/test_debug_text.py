"""`scanrack debug` on programs without rungs: sequences, plain Python, lists of steps; live and recorded.

Broken on purpose: the run without the orders of the session, the values of a line taken after it: red.
"""

from __future__ import annotations

import sys
from contextlib import ExitStack
from pathlib import Path
from typing import NoReturn

import pytest
from debug_client import DebugClient, RefusedError
from scanrack.dap.recorded import recorded_subject
from scanrack.dap.text_subject import WINDOW_MOST
from scanrack.jobs import load_job
from scanrack.jobs.bench.opening import open_bench
from scanrack.jobs.load.program import lines_marked
from scanrack.jobs.run.running import JobRun, RunOptions
from scanrack.jobs.why.program_rerun import ProgramRerun
from scanrack.watch.recorded_session import open_to_read

pytestmark = pytest.mark.slow

RACK = """
name = "counting"
program = "{}"
scan_ms = 2
[[slot]]
number = 1
module = "1762-IQ8"
"""
SEQUENCES = '''"""Counts, and waits between."""

from scanrack import Input, Logic, dwell, sequence


class Counting(Logic):
    """Counts to three, again and again."""

    start = Input("Local:1:I.Data.0")
    number = 0
    rounds = 0
    scans = 0

    @sequence
    async def cycle(self) -> None:
        """Count."""
        while True:
            for step in range(1, 4):
                await self.add(step)
            self.rounds += 1

    async def add(self, step: int) -> None:
        """Add a step, then wait."""
        before = self.number
        self.number = before + step
        await dwell("10 ms")

    def every_scan(self) -> None:
        """Count the scans."""
        self.scans += 1
'''
PLAIN = '''"""Counts in each scan."""


class State:
    """What is kept."""

    number: int = 0
    big: bool = False


state = State()


def twice(value):
    result = 2 * value
    return result


def logic(scan):
    state.number += 1
    double = twice(state.number)
    state.big = double > 20
'''
HELPED = """from doubling import twice
from parts.thirds import third

number = 0


def logic(scan):
    global number
    number += 1
    twice(number)
    third(number)
"""
STEPS = """# Two words in turn.
SLOT 1
words 1 2        for 10 ms
zero             for 10 ms
words 3          for 20 ms
same
"""
STEPS_RACK = """
name = "steps"
program = "line.steps"
scan_ms = 2
[[slot]]
number = 1
module = "amci3601"
"""


def line_of(text: str, part: str) -> int:
    return text[: text.index(part)].count("\n") + 1


def made(folder: Path, name: str, program: str, rack: str = RACK) -> Path:
    (folder / name).write_text(program, encoding="utf-8")
    path = folder / "rack.toml"
    path.write_text(rack.format(name), encoding="utf-8")
    return path


@pytest.fixture
def sequences(tmp_path: Path) -> Path:
    return made(tmp_path, "counting.py", SEQUENCES)


@pytest.fixture
def plain(tmp_path: Path) -> Path:
    return made(tmp_path, "plain.py", PLAIN)


@pytest.fixture
def steps(tmp_path: Path) -> Path:
    return made(tmp_path, "line.steps", STEPS, STEPS_RACK)


def begin(client: DebugClient, rack: Path) -> None:
    """Stand before the first line of scan 0."""
    client.begin(rack, speed="max")
    client.ask("configurationDone")
    assert client.stopped() == ("step", 0)


def never(*_: object) -> NoReturn:
    raise AssertionError("a scan that is prepared does not run again")


def where(client: DebugClient) -> tuple[int, str]:
    return client.scan(), client.at()


def test_lines_are_stepped_over_into_functions_and_scans(client: DebugClient, plain: Path) -> None:
    begin(client, plain)
    first = line_of(PLAIN, "state.number += 1")
    places = [where(client)]
    for command in ("next", "stepIn", "next", "next", "next", "stepIn", "stepOut", "stepOut"):
        client.go(command)
        places.append(where(client))
    inside = line_of(PLAIN, "result = 2")
    assert places == [
        (0, f"logic, line {first}"),
        (0, f"logic, line {first + 1}"),
        (0, f"twice, line {inside}"),
        (0, f"twice, line {inside + 1}"),
        (0, f"logic, line {first + 2}"),
        (1, f"logic, line {first}"),
        (1, f"logic, line {first + 1}"),
        (2, f"logic, line {first}"),
        (3, f"logic, line {first}"),
    ]
    assert client.frames()[0]["source"]["path"] == str(plain.with_name("plain.py"))


def test_values_are_those_before_the_line_and_locals_are_a_scope(client: DebugClient, plain: Path) -> None:
    begin(client, plain)
    assert client.value("state.number") == "0"
    client.go("next")
    assert client.value("state.number") == "1"
    client.go("stepIn")
    client.go("next")
    assert {name: each["value"] for name, each in client.scope("Locals").items()} == {
        "value": "1",
        "result": "2",
    }
    frames = client.frames()
    assert [each["name"].partition(",")[0] for each in frames] == ["twice", "logic", "scan 0"]
    assert "scan" in client.scope("Locals", frame=2)
    assert client.value("result", frameId=1) == "2"
    assert client.value("state.number * 3 == 3 and not state.big") == "1"


def test_a_step_back_is_the_line_before(client: DebugClient, plain: Path) -> None:
    begin(client, plain)
    places = []
    for _ in range(8):
        places.append((*where(client), client.value("state.number"), client.value("state.big")))
        client.go("next")
    for before in reversed(places):
        client.go("stepBack")
        assert (*where(client), client.value("state.number"), client.value("state.big")) == before
    with pytest.raises(RefusedError, match="scan 0 is the first scan"):
        client.go("stepBack")


def test_breakpoints_of_lines_take_python_of_the_frame(client: DebugClient, plain: Path) -> None:
    begin(client, plain)
    file, line = plain.with_name("plain.py"), line_of(PLAIN, "return result")
    (answer,) = client.break_at(file, line, condition="result == 14 and value == 7")
    assert answer["verified"]
    assert client.go() == ("breakpoint", 6)
    assert client.at() == f"twice, line {line}"
    client.break_at(file, line, hitCondition="% 5", condition="result > 0")
    assert client.go() == ("breakpoint", 11)
    client.break_at(file, line, logMessage="{value} is doubled")
    client.ask("setFunctionBreakpoints", breakpoints=[{"name": "scan == 14"}])
    assert client.go() == ("function breakpoint", 14)
    outputs = [each["body"]["output"] for each in client.skipped if each.get("event") == "output"]
    assert outputs == ["13 is doubled\n", "14 is doubled\n", "15 is doubled\n"]
    (bad,) = client.break_at(file, line, condition="result ==")
    assert (bad["verified"], "not an expression of Python" in bad["message"]) == (False, True)
    (none,) = client.break_at(file, 999)
    assert "no instruction from this line" in none["message"]


def test_backwards_meets_what_forwards_has_met(client: DebugClient, plain: Path) -> None:
    begin(client, plain)
    file, line = plain.with_name("plain.py"), line_of(PLAIN, "return result")
    client.break_at(file, line, condition="value in (3, 80, 200)")
    client.ask("setFunctionBreakpoints", breakpoints=[{"name": "state.big changes"}])
    met = [(client.go(), client.at()) for _ in range(4)]
    assert [stop for (_reason, stop), _at in met] == [2, 10, 79, 199]
    back = [(client.go("reverseContinue"), client.at().removesuffix(" (past)")) for _ in range(3)]
    assert back == met[-2::-1]
    assert client.go("reverseContinue") == ("entry", 0)


def test_the_awaiting_line_of_a_sequence_is_a_scope(client: DebugClient, sequences: Path) -> None:
    begin(client, sequences)
    file = sequences.with_name("counting.py")
    client.break_at(file, line_of(SEQUENCES, "self.number = before"))
    assert client.go() == ("breakpoint", 0)
    assert [each["name"].partition(",")[0] for each in client.frames()] == ["add", "cycle", "scan 0"]
    assert client.scope("Locals")["step"]["value"] == "1"
    assert client.go() == ("breakpoint", 5)
    assert client.scope("Locals")["step"]["value"] == "2"
    client.ask("setFunctionBreakpoints", breakpoints=[{"name": "scan == 7"}])
    client.break_at(file)
    client.go()
    waits = client.scope("Waits", frame=client.frames()[-1]["id"])["cycle"]["value"]
    assert waits == f"line {line_of(SEQUENCES, 'await dwell')}: dwell 10 ms"
    assert client.value("counting.number") == "3"
    client.go("stepBack")
    assert client.scan() == 7


def test_values_are_set_and_forced_and_the_way_back_knows_it(client: DebugClient, sequences: Path) -> None:
    begin(client, sequences)
    client.ask("setFunctionBreakpoints", breakpoints=[{"name": "scan == 7"}])
    client.go()
    client.value("set counting.number = 50")
    client.value("set counting.number = 100")
    assert client.value("counting.number") == "100"
    client.ask("setFunctionBreakpoints", breakpoints=[{"name": "scan == 12"}])
    client.go()
    assert client.value("counting.number") == "103"
    client.value("force counting.number = 7")
    client.ask("setFunctionBreakpoints", breakpoints=[{"name": "scan == 300"}])
    client.go()
    assert client.value("counting.number") == "7 (forced)"
    client.ask("setFunctionBreakpoints", breakpoints=[{"name": "scan == 11"}])
    assert client.go("reverseContinue") == ("function breakpoint", 11)
    assert client.value("counting.number") == "103 (forced)"  # it is now
    client.ask("setFunctionBreakpoints", breakpoints=[{"name": "scan == 6"}])
    client.go("reverseContinue")
    assert client.value("counting.number") == "3 (forced)"
    body = client.ask("dataBreakpointInfo", name="counting.number")
    assert body["description"] == "counting.number changed last in scan 5"


def test_a_question_runs_scans_again_and_meets_no_breakpoint(client: DebugClient, sequences: Path) -> None:
    begin(client, sequences)
    client.break_at(sequences.with_name("counting.py"), line_of(SEQUENCES, "self.number = before"))
    client.go()
    assert client.go() == ("breakpoint", 5)
    assert "self.number = before + step" in client.value("why counting.number")
    assert client.go() == ("breakpoint", 10)


def test_from_a_past_scan_a_branch_continues(client: DebugClient, sequences: Path) -> None:
    begin(client, sequences)
    client.ask("setFunctionBreakpoints", breakpoints=[{"name": "scan == 60"}, {"name": "scan == 20"}])
    client.go()
    client.go()
    client.go("reverseContinue")
    assert client.scan() == 20
    with pytest.raises(RefusedError, match="this is scan 20, and the rack is at scan 60"):
        client.go()
    before = client.value("counting.number")
    assert client.value("branch") == "a new session continues from scan 21"
    assert client.stopped() == ("pause", 20)
    assert client.value("counting.number") == before


def test_a_list_of_steps_stops_where_a_step_begins(client: DebugClient, steps: Path) -> None:
    begin(client, steps)
    lines = [line_of(STEPS, each) for each in ("words 1", "zero", "words 3", "same")]
    places = [where(client)]
    for _ in range(3):
        client.go("next")
        places.append(where(client))
    assert places == [(scan, f"step, line {line}") for scan, line in zip((0, 5, 10, 20), lines, strict=True)]
    assert client.scope("Waits")["step"]["value"] == f"line {lines[3]}"
    client.break_at(steps.with_name("line.steps"), lines[1])
    assert client.go("reverseContinue") == ("breakpoint", 5)
    client.go("stepBack")
    while client.scan():
        client.go("stepBack")
    assert client.at() == f"step, line {lines[0]}"


def test_fields_that_a_test_has_set_are_known_in_its_recording(
    client: DebugClient, sequences: Path, tmp_path: Path
) -> None:
    trace = tmp_path / "test.mcap"
    with open_bench(sequences, record=trace) as bench:
        bench.scan(5)
        bench["counting.number"] = 70
        bench["counting.number"] = 100
        bench.scan(20)
        assert bench["counting.number"] == 108  # 2 in scan 5, 3 in scan 10, 1 in scan 15, 2 in scan 20
    client.begin(trace, trust=True, scan=24)
    client.ask("configurationDone")
    client.stopped()
    assert client.value("counting.number") == "108"
    client.ask("setFunctionBreakpoints", breakpoints=[{"name": "scan == 5"}])
    assert client.go("reverseContinue") == ("function breakpoint", 5)
    assert client.value("counting.number") == "102"
    while client.scan() == 5:
        client.go("stepBack")
    assert client.value("counting.number") == "1"
    assert client.value("branch") == "a new session continues from scan 5"


def forget_helpers() -> None:
    """Let modules beside a program be imported again, as in another process."""
    for name in ("doubling", "parts", "parts.thirds"):
        sys.modules.pop(name, None)


@pytest.mark.parametrize("recorded", [False, True])
def test_breakpoints_are_set_in_modules_beside_the_program(
    client: DebugClient, tmp_path: Path, recorded: bool
) -> None:
    forget_helpers()
    rack = made(tmp_path, "plain.py", HELPED)
    (tmp_path / "doubling.py").write_text("def twice(value):\n    return 2 * value\n", encoding="utf-8")
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts/__init__.py").write_text("", encoding="utf-8")
    (tmp_path / "parts/thirds.py").write_text("def third(value):\n    return value / 3\n", encoding="utf-8")
    if recorded:
        with ExitStack() as ports:
            JobRun(load_job(str(rack)), ports, RunOptions(trace=tmp_path / "run.mcap")).run(100)
        forget_helpers()
        client.begin(tmp_path / "run.mcap", trust=True)
    else:
        client.begin(rack, speed="max")
    client.ask("configurationDone")
    client.stopped()
    for name, condition, scan in (("doubling.py", "value == 8", 7), ("parts/thirds.py", "value == 12", 11)):
        (answer,) = client.break_at(tmp_path / name, 2, condition=condition)
        assert answer["verified"], answer
        assert client.go() == ("breakpoint", scan)
        assert client.frames()[0]["source"]["path"] == str(tmp_path / name)
        client.break_at(tmp_path / name)
    client.break_at(tmp_path / "doubling.py", 2, condition="value == 2")
    assert client.go("reverseContinue") == ("breakpoint", 1)


@pytest.mark.parametrize("name", ["sequences", "plain", "steps"])
def test_a_recording_is_debugged_as_the_session(
    client: DebugClient, tmp_path: Path, name: str, request: pytest.FixtureRequest
) -> None:
    rack: Path = request.getfixturevalue(name)
    trace = tmp_path / "run.mcap"
    with ExitStack() as ports:
        JobRun(load_job(str(rack)), ports, RunOptions(trace=trace)).run(400)
    file, text, part, stops = {
        "sequences": ("counting.py", SEQUENCES, "self.number = before", [0, 5, 10, 15]),
        "plain": ("plain.py", PLAIN, "return result", [0, 1, 2, 3]),
        "steps": ("line.steps", STEPS, "zero", [5]),
    }[name]
    client.begin(trace, trust=True)
    client.ask("configurationDone")
    assert client.stopped() == ("entry", 0)
    (answer,) = client.break_at(rack.with_name(file), line_of(text, part))
    assert answer["verified"]
    found = [client.go()[1] for _ in stops] if stops[0] else []
    found = found or [client.go()[1] for _ in stops]
    assert found == stops
    assert client.frames()[0]["source"]["path"] == str(rack.with_name(file))
    back = [client.go("reverseContinue")[1] for _ in stops[1:]]
    assert back == stops[-2::-1]


def test_scans_before_the_one_shown_are_prepared_while_the_client_is_silent(
    plain: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    trace = tmp_path / "run.mcap"
    with ExitStack() as stack:
        JobRun(load_job(str(plain)), stack, RunOptions(trace=trace)).run(6000)
        stack.enter_context(lines_marked())
        subject = recorded_subject(open_to_read(stack, trace, trust=True), trace)
        subject.view(5900)
        slices = sum(1 for _ in iter(subject.prepare, False))
        assert slices > 10  # requests are answered between them
        monkeypatch.setattr(ProgramRerun, "walk", never)
        for scan in range(5900, 5900 - WINDOW_MOST, -1):
            assert subject.view(scan).tags["state.number"] == scan + 1


def test_a_pause_breaks_off_a_search_of_the_past(
    client: DebugClient, tmp_path: Path, sequences: Path
) -> None:
    trace = tmp_path / "run.mcap"
    with ExitStack() as ports:
        JobRun(load_job(str(sequences)), ports, RunOptions(trace=trace)).run(8000)
    client.begin(trace, trust=True, scan=7999)
    client.ask("configurationDone")
    assert client.stopped() == ("entry", 7999)
    client.ask("setFunctionBreakpoints", breakpoints=[{"name": "counting.rounds < 0"}])
    for each in client.tell_all(("reverseContinue", {"threadId": 1}), ("pause", {"threadId": 1})):
        client.answer_to(each)
    reason, scan = client.stopped()
    assert (reason, 0 <= scan < 7999) == ("pause", True)
    assert client.go("reverseContinue") == ("entry", 0)
