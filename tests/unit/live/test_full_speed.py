"""A session at full speed does what a run does, and little more.

Broken on purpose: a paced CPU that never runs its modules ahead, a journal of every scan, a message before
the rows of a batch, a batch with the times of another one: a test turns red.
"""

from contextlib import ExitStack

import numpy as np
import pytest
from live_sessions import FEEDER, LiveSession
from scanrack.jobs import JobRun, RunOptions, load_job
from scanrack.ladder import LadderLogic
from scanrack.ladder.debug import Debugger
from scanrack.runtime.loop.listeners import QuietListener
from scanrack.traces import open_trace, read_columns

SCANS = 3000


@pytest.mark.slow
def test_modules_are_run_ahead_at_full_speed_and_the_images_are_those_of_a_run(tmp_path, monkeypatch):
    with ExitStack() as ports:
        JobRun(load_job(str(FEEDER)), ports, RunOptions(trace=tmp_path / "run.mcap")).run(SCANS)
    session = LiveSession(trace=tmp_path / "session.mcap")
    exchange, foreseen = session.run.cpu._ahead._exchange, []
    foresee = exchange.foresee

    def counted(self, now_ns, period_ns, count, most_rows):
        foreseen.append(count)
        return foresee(now_ns, period_ns, count, most_rows)

    monkeypatch.setattr(type(exchange), "foresee", counted)
    session.play(SCANS)
    assert foreseen
    with open_trace(tmp_path / "run.mcap") as run, open_trace(tmp_path / "session.mcap") as live:
        one, other = read_columns(run), read_columns(live)
    assert (one.scan == other.scan).all()
    assert (one.words == other.words).all()
    assert (one.flags == other.flags).all()


def rows_of(monkeypatch, at_once=None):
    """Return the rows of a session, and how often several were written at once."""
    orders = [
        (700, {"do": "force", "tag": "Trouble", "value": False}),
        (901, {"do": "unforce", "tag": "Trouble"}),
    ]
    session, batches = LiveSession(orders), []
    ring, put_all = session.ring, session.ring.put_all
    ring.at_once = at_once or ring.at_once

    def counted(*row, **steps):
        batches.append(len(row[-1]))
        put_all(*row, **steps)

    monkeypatch.setattr(ring, "put_all", counted)
    session.play(SCANS)
    return ring.take(0).rows, batches


def test_rows_of_a_batch_are_those_of_scans_written_one_by_one(monkeypatch):
    (rows, batches), (single, none) = rows_of(monkeypatch), rows_of(monkeypatch, at_once=1)
    assert batches
    assert not none
    assert set(np.flatnonzero(np.diff(rows["flags"]))) == {
        0,
        700,
        902,
    }  # held from scan 701 on, released before scan 902
    assert rows["scan"].tolist() == list(range(SCANS))
    for name in ("scan", "again", "flags", "now_ns", "words"):
        assert (rows[name] == single[name]).all(), name
    assert (np.diff(rows["wall_ns"]) >= 0).all()


def test_a_message_follows_the_rows_of_the_scans_before_it():
    session, written = LiveSession(), {}

    class Teller(QuietListener):
        def scan(self, scan, now_ns, flags):
            if scan in (0, 77, 1500):
                session.tap.send({"note": "here"})
                written[scan] = session.ring.written

    session.run.cpu.add_listener(Teller())
    session.play(SCANS)
    assert written == {0: 1, 77: 78, 1500: 1501}
    assert session.ring.written == SCANS


def ends_of_batches(monkeypatch, *, telling=False, wall_of=None):
    """Return the scans that ended a batch."""
    session, ends = LiveSession(), []
    end_batch = session.tap._end_batch

    def noted():
        ends.append(session.tap._scan)
        end_batch()

    class Teller(QuietListener):
        def scan(self, scan, now_ns, flags):
            if telling and scan % 3 == 0:
                session.tap.send({"note": "here"})

    session.run.cpu.add_listener(Teller())
    monkeypatch.setattr(session.tap, "_end_batch", noted)
    if wall_of is not None:
        monkeypatch.setattr("scanrack.runtime.live.tap.wall_ns", lambda: wall_of(max(session.tap._scan, 0)))
    session.play(SCANS)
    return np.array(ends)


def test_a_batch_ends_however_many_messages_write_its_rows(monkeypatch):
    ends = ends_of_batches(monkeypatch, telling=True, wall_of=lambda scan: 1000 * scan)
    assert SCANS // 256 <= len(ends) < SCANS // 32  # 1, 2, 4 ... 256 scans long
    assert np.diff(ends).max() == 256


def test_a_batch_of_scans_that_have_become_slow_ends_by_its_time(monkeypatch):
    slow = 1000
    ends = ends_of_batches(monkeypatch, wall_of=lambda scan: 1000 * scan + 5_000_000 * max(0, scan - slow))
    assert np.diff(ends[ends <= slow]).max() == 256
    assert ends[ends > slow][0] <= slow + 16  # looked at
    first, *rest = np.diff(ends[ends > slow])
    assert first <= 16
    assert set(rest) == {1}  # of 8 ms; a scan takes 5


def test_another_speed_than_the_fullest_waits_for_the_clock_from_the_next_scan_on():
    session = LiveSession([(100, {"do": "speed", "factor": 1000})])
    session.play(300)
    assert session.run.cpu.pacer.late[0] + sum(session.run.cpu.pacer.late[1:]) >= 190


def test_scans_are_remembered_only_while_there_are_breakpoints_on_rungs():
    program, other = (load_job(str(FEEDER)).logic for _ in range(2))
    assert isinstance(program, LadderLogic)
    assert isinstance(other, LadderLogic)
    bare, whole = Debugger(program, remembered=0), Debugger(other)
    for debugger in (bare, whole):
        debugger.scan(10)
        debugger.break_at("Main", 0)
    assert bare.latest is None
    assert [str(each) for each in bare.scan(5)] == [str(each) for each in whole.scan(5)]
    assert bare.truth("Main") == whole.truth("Main")
