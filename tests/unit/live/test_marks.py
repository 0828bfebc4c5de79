"""Marks of a recording, its complete list of events, and since when a value holds in all of it.

The oracle is the recording read scan by scan. Broken on purpose: the first row of a piece left out, an error
bit told twice beside its rule, a mark at the scan itself as the next one, a hidden kind counted, a question
that ends after one stretch: each turns a test red.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from recordings import Opened, opened
from scanrack.commands import build
from scanrack.runtime.loop.scan import ScanFlag
from scanrack.traces import open_trace
from scanrack.watch.history.event_log import EventLog
from scanrack.watch.history.event_table import piece_of, table_of
from scanrack.watch.monitors import marks as marks_module
from scanrack.watch.monitors import since as since_module
from scanrack.watch.monitors.questions import handle_message as ask
from typer.testing import CliRunner

pytestmark = pytest.mark.slow

FEEDER = Path(__file__).parents[3] / "examples" / "feeder" / "feeder.toml"
SCANS = 5200
INPUT_ERROR = "Local:1:I.Data[0].11"


@pytest.fixture(scope="module")
def trace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The feeder, whose emergency stop comes at 8 s, and is reset."""
    path = tmp_path_factory.mktemp("marked") / "run.mcap"
    done = CliRunner().invoke(
        build(), ["run", str(FEEDER), "--scans", str(SCANS), "--record", str(path), "-q"]
    )
    assert done.exit_code == 0, done.output
    return path


@pytest.fixture
def seen(trace: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Opened]:
    monkeypatch.setattr(marks_module, "PIECE", 1000)
    monkeypatch.setattr(since_module, "BACK", 700)
    with opened(trace, tmp_path / "files") as found:
        found.settle()
        yield found


def asked(seen: Opened, what: str, **fields: Any) -> Any:
    """Ask; return the answer."""
    seen.page.outbox.clear()
    ask(seen.monitor, seen.page, {"id": 1, "do": what, **fields})
    return seen.page.outbox[-1]["answer"]


def levels(trace: Path, bit: int) -> list[bool]:
    with open_trace(trace) as read:
        return [bool(scan.inputs(1)[0] >> bit & 1) for scan in read.scans()]


def test_every_rule_is_a_mark_and_an_error_bit_with_a_rule_is_one(seen: Opened, trace: Path) -> None:
    with open_trace(trace) as read:
        rules = [
            (each.scan, each.fields["name"]) for each in read.events() if each.fields.get("kind") == "rule"
        ]
    found = seen.monitor.marks.all
    assert sorted((each.scan, each.text.rsplit("[", 1)[1][:-1]) for each in found) == sorted(rules)
    on = levels(trace, 11)
    rises = [scan for scan in range(1, SCANS) if on[scan] and not on[scan - 1]]
    errors = [each for each in found if each.kind == "error"]
    assert [(each.name, each.tag) for each in errors] == [("INPUT_ERROR", INPUT_ERROR)] * len(rises)
    assert all(
        0 <= rise - each.scan <= marks_module.SAME_SCANS for rise, each in zip(rises, errors, strict=True)
    )


def test_the_next_and_the_previous_mark_and_the_failure(seen: Opened) -> None:
    scans = sorted({each.scan for each in seen.monitor.marks.all})
    for one, other in pairwise(scans):
        assert asked(seen, "mark", **{"from": one, "way": 1})["mark"]["scan"] == other
        assert asked(seen, "mark", **{"from": other, "way": -1})["mark"]["scan"] == one
    assert asked(seen, "mark", **{"from": scans[-1], "way": 1})["mark"] is None
    answer = asked(seen, "marks")
    assert (answer["whole"], answer["total"]) == (True, len(seen.monitor.marks.all))
    assert answer["failure"]["name"] == "INPUT_ERROR"
    assert "from must be a scan number" in asked(seen, "mark", **{"from": "x", "way": 1})["refused"]


def test_modes_restarts_and_bits_without_a_rule_are_marks(seen: Opened) -> None:
    marks = seen.monitor.marks
    rows = seen.monitor.subject.timeline.apart(0, 9).copy()
    marks._row_marks.clear()
    marks._errors.clear()
    marks._last_row = None
    rows["flags"] = [1, 1, 0, 0, 1 | ScanFlag.FIRST_SCAN, 1, 1, 1 | ScanFlag.FIRST_SCAN, 1, 1]
    rows["words"][:] = 0
    rows["words"][5:, 8] = 1 << 12  # COMMAND_ERROR, in the first word of the inputs
    for part in (rows[:5], rows[5:]):
        marks._take(part)
    found = [(each.scan, each.kind, each.text) for each in marks._row_marks]
    assert sorted(found) == [
        (2, "mode", "Mode program, before that run"),
        (4, "mode", "Mode run, before that program"),
        (5, "error", "COMMAND_ERROR came on"),
        (7, "restart", "The program starts again: a first scan"),
    ]


def test_many_marks_are_thinned_and_the_gravest_stay(seen: Opened, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(marks_module, "SHOWN_MOST", 2)
    shown = asked(seen, "marks")["marks"]
    assert len(shown) <= 2
    assert sum(each[2] for each in shown) == len(seen.monitor.marks.all)
    assert "error" in [each[1] for each in shown]


def test_pieces_of_the_events_make_up_all_of_them(seen: Opened, trace: Path) -> None:
    with open_trace(trace) as read:
        every = [each for each in read.events() if each.scan <= 5000 and each.topic != "/cpu"]
    found: list[Any] = []
    while True:
        answer = asked(seen, "events", to=5000, skip=len(found), most=7, hide=["cpu"])
        assert answer["whole"]
        if not answer["events"]:
            break
        found[:0] = answer["events"]
    assert answer["total"] == len(found) == len(every)
    assert [(each["scan"], each["name"]) for each in found] == [
        (each.scan, each.fields["name"]) for each in every
    ]
    moves = asked(seen, "events", to=5000, hide=["indicator", "stimulus", "cpu", "rule", "error"])
    assert {each["kind"] for each in moves["events"]} == {"move"}
    errors = asked(seen, "events", to=5000, hide=["indicator", "stimulus", "cpu", "rule", "move"])["events"]
    assert {bit for each in errors for bit in each["bits"]} == {"CONFIG_ERROR", "INPUT_ERROR"}
    for wrong in ({"to": "x"}, {"to": 1, "skip": -1}, {"to": 1, "most": 201}, {"to": 1, "hide": "rule"}):
        assert "must be" in asked(seen, "events", **wrong)["refused"]


def test_a_piece_is_counted_from_the_latest_event_back() -> None:
    log = EventLog()
    for scan, kind in enumerate(["move", "indicator", "move", "rule", "move"]):
        log.take({"scan": scan, "t": scan, "topic": "/events", "kind": kind, "text": str(scan), "slot": 1})
    table = table_of(log.version, log.up_to(9, 99), {})

    def texts(scan: int, hidden: list[str], skip: int, most: int) -> tuple[list[str], int]:
        events, total = piece_of(table, scan, hidden, skip, most)
        return [each["text"] for each in events], total

    assert texts(9, [], 0, 2) == (["3", "4"], 5)
    assert texts(9, ["indicator"], 1, 2) == (["2", "3"], 4)
    assert texts(3, ["indicator"], 0, 9) == (["0", "2", "3"], 3)
    assert texts(9, [], 5, 2) == ([], 5)


@pytest.mark.parametrize("tag", [INPUT_ERROR, "Local:1:I.Data[0].15", "Homing"])
def test_since_goes_on_until_the_change_or_the_first_scan(seen: Opened, trace: Path, tag: str) -> None:
    scan, asks, begin = SCANS - 1, 0, SCANS - 1
    seen.look(scan)
    while True:
        answer = asked(seen, "since", tag=tag, **{"from": begin})
        asks += 1
        if answer["since"] or answer["from"] is None:
            break
        assert answer["from"] < begin
        begin = answer["from"]
    if tag.startswith("Local"):
        on = levels(trace, int(tag.rpartition(".")[2]))
        changes = [scan for scan in range(1, SCANS) if on[scan] != on[scan - 1]]
        assert (answer["since"] or {}).get("scan") == (changes[-1] if changes else None)
        assert asks > 1 or changes[-1:] > [SCANS - 700]
    else:
        found = answer["since"]["scan"]
        asked(seen, "show", routine="Main", columns=88)

        def value(at: int) -> Any:
            seen.look(at)
            return seen.monitor.picture(seen.page)["tags"][tag]

        values = [value(each) for each in (found - 1, found, (found + scan) // 2, scan)]
        assert values == [answer["since"]["before"], *[not answer["since"]["before"]] * 3]
