"""A monitor beside a session: started again it shows it at once, and a pause comes with its scan.

Broken on purpose: all events of the recording read at the start; rows that are read before a pause only: a
test turns red.
"""

import socket
from multiprocessing.connection import Connection

import pytest
from live_sessions import FEEDER, LiveSession
from recordings import chunks_read
from scanrack.watch.monitors.monitor import SessionFacts
from scanrack.watch.monitors.page import Page
from scanrack.watch.monitors.session_monitor import SessionMonitor, Setup
from scanrack.watch.monitors.stretched import SessionProgram

PRESSED = 50


class ToldSession(LiveSession):
    """A session whose messages come to a monitor, too."""

    def tell(self, message):
        super().tell(message)
        self.tap.send(message)


def setup_of(session, trace, started):
    ran = SessionProgram(0, str(FEEDER.parent), "feeder.toml", "feeder.rung")
    about = SessionFacts("0", "feeder", str(FEEDER), "rack", False, False, None)
    return Setup(session.ring.shape, about, "", "", 0, (1,), str(trace), (ran,), started=started)


def test_a_pause_is_shown_with_the_last_scan_before_it(tmp_path, monkeypatch):
    """Also of a session that runs on while the monitor reads."""
    session = ToldSession([(PRESSED, {"do": "pause"})])
    take = session.ring.take

    def take_and_run_on(place):
        monkeypatch.undo()
        taken = take(place)
        session.play()
        return taken

    monkeypatch.setattr(session.ring, "take", take_and_run_on)
    mine, theirs = socket.socketpair()
    with theirs, Connection(mine.detach()) as pipe:
        monitor, page = (
            SessionMonitor(setup_of(session, tmp_path / "none.mcap", 0), session.ring, pipe),
            Page(),
        )
        monitor.join(page)
        monitor.tick()
        frame = monitor.frame(page)
    (answer,) = session.answers
    assert (frame["state"], frame["scan"]) == ("paused", answer["scan"] - 1)


@pytest.mark.slow
@pytest.mark.parametrize("scans", [6_000, 20_000])
def test_its_first_picture_takes_a_few_chunks(tmp_path, monkeypatch, scans):
    trace = tmp_path / "session.mcap"
    press = {"do": "press", "slot": 1, "name": "capture", "on": True}
    session = LiveSession([(PRESSED, press)], trace)
    session.play(scans)
    setup = setup_of(session, trace, 1)
    for _ in range(8):  # what the monitor before has read is overwritten
        session.ring.messages.write(b'{"values":{"scan":0,"values":{}}}' + b" " * (1 << 17))
    mine, theirs = socket.socketpair()
    with theirs, Connection(mine.detach()) as pipe:
        read = chunks_read(monkeypatch)
        monitor, page = SessionMonitor(setup, session.ring, pipe), Page()
        monitor.join(page)
        monitor.tick()
        assert monitor.frame(page)["scan"] == scans - 1
        assert len(read) <= 12
        assert monitor.log.earlier is not None
        earlier = monitor.log.earlier.up_to(PRESSED + 10, 100)
        assert any(each["scan"] == PRESSED + 1 for each in earlier)
        monitor.subject.timeline.close()
