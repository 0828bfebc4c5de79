"""Why of a Python program: a process answers, in bounded time, and every question has one answer."""

import time

import numpy as np
import pytest
from live_sessions import LiveSession
from scanrack.commands import build
from scanrack.traces import open_trace
from scanrack.traces.read.arrays import column_chunks
from scanrack.traces.read.columns import Columns, join
from scanrack.watch.monitors import question_process
from scanrack.watch.monitors.page import Page
from scanrack.watch.monitors.question_process import QuestionProcesses, lines, why
from scanrack.watch.monitors.want_process import answer as answer_want
from typer.testing import CliRunner

SCANS = 1500


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    trace = tmp_path_factory.mktemp("why") / "run.mcap"
    words = ["run", "examples/three_stations/line.toml", "--record", str(trace), "--scans", str(SCANS)]
    assert CliRunner().invoke(build(), words).exit_code == 0
    return trace


@pytest.fixture(scope="module")
def columns(recording):
    with open_trace(recording) as trace:
        return join(list(column_chunks(trace)))


@pytest.fixture
def asked():
    made = QuestionProcesses()
    yield made
    made.close()


def answers(page):
    """The answers that a page has got so far."""
    return [message["answer"] for message in page.outbox]


def answered(asked, page, count=1):
    give_up = time.monotonic() + 60
    while len(page.outbox) < count:
        assert time.monotonic() < give_up
        asked.tick()
        time.sleep(0.02)
    return answers(page)


@pytest.mark.slow
def test_the_line_that_changed_a_value_is_named(asked, recording, columns):
    page = Page()
    asked.start(page, 7, why(str(recording), "line.step", columns))
    (answer,) = answered(asked, page)
    assert answer["id"] == 7
    assert answer["ok"]
    assert answer["scan"] == SCANS - 1
    assert "line.step is 'move' since 1.504 s" in answer["text"]


@pytest.mark.slow
def test_scans_that_are_not_written_yet_go_along(asked, recording, columns):
    page = Page()
    last = columns.rows(SCANS - 1, SCANS)
    more = Columns(last.scan + 1, last.time_ns + 2_000_000, last.flags, np.array(last.words))
    asked.start(page, 1, why(str(recording), "line.step", more))
    (answer,) = answered(asked, page)
    assert answer["scan"] == SCANS


def test_a_name_that_there_is_not_is_refused(asked, recording, columns):
    page = Page()
    asked.start(page, 1, why(str(recording), "line.nonsense", columns))
    (answer,) = answered(asked, page)
    assert "nonsense" in answer["refused"]


def test_another_question_ends_the_one_before_and_the_end_of_the_session_all(asked, recording, columns):
    page = Page()
    for number in (1, 2):
        asked.start(page, number, why(str(recording), "line.step", columns))
    asked.close()
    assert answers(page) == [
        {"id": 1, "refused": "another question was asked meanwhile"},
        {"id": 2, "refused": "the session has ended"},
    ]


@pytest.mark.slow
def test_lines_that_the_page_marks_end_no_question_of_a_person(asked, recording, columns):
    page = Page()
    asked.start(page, 1, why(str(recording), "line.step", columns))
    for number in (2, 3):
        asked.start(page, number, lines(str(recording), (1000, 1001), columns, ()))
    found = {each["id"]: each for each in answered(asked, page, 3)}
    assert found[2] == {"id": 2, "refused": "another question was asked meanwhile"}
    assert "line.step" in found[1]["text"]
    assert (found[3]["from"], found[3]["to"], found[3]["departs"]) == (1000, 1001, None)
    assert found[3]["ran"][0][0] == 1000


def test_an_answer_that_takes_too_long_is_given_up(asked, recording, columns, monkeypatch):
    monkeypatch.setattr(question_process, "PATIENCE_S", -1)
    page = Page()
    asked.start(page, 1, why(str(recording), "line.step", columns))
    asked.tick()
    (answer,) = answers(page)
    assert f"scanrack why {recording} line.step --at {SCANS - 1}" in answer["refused"]


@pytest.mark.slow
def test_what_it_would_take_counts_orders_of_the_recording_and_later_ones(tmp_path):
    trace, stop = tmp_path / "session.mcap", {"do": "press", "slot": 1, "name": "estop", "on": True}
    session = LiveSession([(1000, stop)], trace)
    session.play(1200)
    (pressed,) = answer_want(str(trace), "Feeding", True, 1190, [])["answers"]
    assert pressed["acts"] == ["open estop (slot 1)"]
    released = [(1180, '{"do":"press","slot":1,"name":"estop","on":false}')]
    (alone,) = answer_want(str(trace), "Feeding", True, 1190, released)["answers"]
    assert alone["acts"] == []
    assert alone["after_ns"] == pressed["after_ns"] - 20_000_000
