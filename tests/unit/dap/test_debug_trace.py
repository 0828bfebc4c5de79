"""`scanrack debug` over a recording: breakpoints forwards and backwards, against queries of it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from debug_client import DebugClient, RefusedError, connected
from scanrack.jobs import load_job
from scanrack.jobs.load.loading import with_tags
from scanrack.jobs.run.running import JobRun, RunOptions
from scanrack.traces.query import query
from scanrack.traces.read.reader import open_trace

pytestmark = pytest.mark.slow

FEEDER = Path(__file__).parents[3] / "examples/feeder"
SCANS = 5000


@pytest.fixture(scope="module")
def trace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("debugged") / "feeder.mcap"
    job = with_tags(load_job(str(FEEDER / "feeder.toml")), ["Feeding", "BackGo", "Strokes"])
    with ExitStack() as ports:
        JobRun(job, ports, RunOptions(trace=made)).run(SCANS)
    return made


@pytest.fixture
def client(trace: Path) -> Iterator[DebugClient]:
    with connected() as found:
        found.begin(trace)
        found.ask("configurationDone")
        assert found.stopped() == ("entry", 0)
        yield found


def scans_of(trace: Path, text: str) -> list[int]:
    """Return the scans of a query: the oracle, which knows nothing of programs."""
    with open_trace(trace) as opened:
        return [each.first for each in query(opened, text).occurrences]


def line_of(text: str) -> int:
    source = (FEEDER / "feeder.rung").read_text(encoding="utf-8")
    return source[: source.index(text)].count("\n") + 1


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("Feeding changes", "changed(Feeding)"),
        ("BackGo and Strokes.ACC >= 1", "BackGo and Strokes.ACC >= 1"),
        ("rose(slot1.status.MOVING_CW)", "rose(slot1.in.MOVING_CW)"),
    ],
)
def test_breakpoints_are_met_where_a_query_finds_them(
    client: DebugClient, trace: Path, name: str, text: str
) -> None:
    found = scans_of(trace, text)
    assert len(found) > 1
    client.ask("setFunctionBreakpoints", breakpoints=[{"name": name}])
    assert [client.go()[1] for _ in found] == found
    assert client.go() == ("pause", SCANS - 1)
    assert [client.go("reverseContinue")[1] for _ in found] == found[::-1]
    assert client.go("reverseContinue") == ("entry", 0)


def test_error_bits_and_rules_stop(client: DebugClient, trace: Path) -> None:
    client.ask("setExceptionBreakpoints", filters=["error"])
    found = scans_of(trace, "rose(slot1.in.INPUT_ERROR)")
    assert client.go() == ("exception", found[0])
    assert client.ask("exceptionInfo", threadId=1)["description"] == "slot 1: INPUT_ERROR"
    client.ask(
        "setExceptionBreakpoints", filters=[], filterOptions=[{"filterId": "scan", "condition": "scan == 9"}]
    )
    assert client.go("reverseContinue") == ("exception", 9)


def test_files_of_this_machine_take_the_place_of_copies(client: DebugClient) -> None:
    (answer,) = client.break_at(
        FEEDER / "feeder.rung", (line := line_of("XIC(Back.Done)CTU")), condition="becomes true"
    )
    assert answer["verified"]
    assert client.go()[0] == "breakpoint"
    frame = client.frames()[0]
    assert (frame["source"]["path"], frame["line"]) == (str(FEEDER / "feeder.rung"), line)


def test_a_recording_takes_no_values(client: DebugClient) -> None:
    with pytest.raises(RefusedError, match="this is a recording"):
        client.value("force Feeding = 1")


def test_a_branch_continues_from_a_recorded_scan(client: DebugClient) -> None:
    client.ask("setFunctionBreakpoints", breakpoints=[{"name": "scan == 900"}, {"name": "scan == 950"}])
    assert client.go() == ("function breakpoint", 900)
    before = client.value("Axis.Position")
    assert client.value("branch") == "a new session continues from scan 901"
    assert client.stopped() == ("pause", 900)
    assert client.value("Axis.Position") == before
    client.value("force Trouble = 1")
    assert client.go() == ("function breakpoint", 950)
    assert client.value("Trouble") == "1 (forced)"


def test_it_begins_with_a_scan(trace: Path) -> None:
    with connected() as client:
        client.begin(trace, scan=4321)
        client.ask("configurationDone")
        assert client.stopped() == ("entry", 4321)
        assert client.go("stepBack") == ("step", 4320)


@pytest.mark.parametrize("command", ["continue", "reverseContinue"])
def test_a_pause_breaks_off_a_search(client: DebugClient, command: str) -> None:
    """Requests are answered while it lasts; what needs a stop is refused."""
    client.go("continue")
    assert client.scan() == SCANS - 1
    client.ask("setFunctionBreakpoints", breakpoints=[{"name": "Strokes.ACC > 999"}])
    if command == "continue":
        client.go("reverseContinue")
        assert client.scan() == 0
    begun, numbers = (
        client.scan(),
        client.tell_all(
            (command, {"threadId": 1}),
            ("scopes", {"frameId": 1}),
            ("threads", {}),
            ("pause", {"threadId": 1}),
        ),
    )
    answers = [client.answer_to(each) for each in numbers]
    assert [each["success"] for each in answers] == [True, False, True, True]
    assert answers[1]["message"] == "scopes: scans run; pause first"
    reason, scan = client.stopped()
    assert reason == "pause"
    assert scan < SCANS - 1 if command == "continue" else scan > 0  # short of the end of the search
    assert client.go("stepBack") == ("step", scan)
    back = "reverseContinue" if command == "continue" else "continue"
    assert client.go(back) == (("entry", 0) if begun == 0 else ("pause", SCANS - 1))
