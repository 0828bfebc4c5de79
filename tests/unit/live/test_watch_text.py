"""`scanrack watch --text`: what the terminal shows."""

from io import StringIO

from live_sessions import LiveSession
from rich.console import Console
from scanrack.runtime.loop.pace import AdjustablePace
from scanrack.watch.text import TextView


def shown(orders, scans):
    session = LiveSession(orders)
    view = TextView("feeder", session.run.rack, session.session, AdjustablePace(None))
    session.run.cpu.add_listener(view)
    session.play(scans)
    console = Console(width=200, record=True, file=StringIO())
    console.print(view.shown())
    return console.export_text()


def test_mode_scan_words_bits_and_events_are_shown():
    text = shown([], 700)
    assert "feeder  run max  scan 699  1.398 s" in text
    assert "slot 1  amci3601" in text
    assert "MODULE_OK" in text


def test_forces_and_a_pause_are_in_sight():
    text = shown([(10, {"do": "force", "tag": "Homing", "value": 1}), (20, {"do": "pause"})], 40)
    assert "PAUSED" in text
    assert "FORCED" in text


def test_control_characters_of_a_name_cannot_act_on_the_terminal():
    session = LiveSession()
    view = TextView("fee\x1b[2Jder", session.run.rack, session.session, AdjustablePace(1.0))
    view.event(1, 0, "/events", {"text": "line\nnote: all is well"})
    console = Console(width=200, record=True, file=StringIO())
    console.print(view.shown())
    text = console.export_text()
    assert "\x1b" not in text
    assert "line\\nnote" in text
    session.ports.close()
