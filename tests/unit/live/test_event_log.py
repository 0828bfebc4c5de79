"""The events of a session: what is kept, and what stood in a scan."""

import pytest
from scanrack.runtime.live.actions import RECORDED, Store, action_of, parsed, text_of
from scanrack.runtime.live.operator_actions import sentence
from scanrack.runtime.loop.faults import Cause, Fault
from scanrack.watch.history.event_log import FIRST, KEPT, NAMES_MOST, STATES, STORED, EventLog
from scanrack.watch.history.python_source import PythonSource


def event(scan, topic="/events", **fields):
    return {"scan": scan, "t": scan * 10, "topic": topic, **fields}


def test_the_latest_events_are_kept_and_numbered_on():
    log = EventLog()
    for scan in range(3 * KEPT):
        log.take(event(scan, text=f"event {scan}"))
    assert log.end == 3 * KEPT
    assert log.since(log.end - 2)[0]["text"] == f"event {3 * KEPT - 2}"
    assert len(log.since(0)) == log.end - log.begin >= KEPT
    assert log.end - log.first_of_page == FIRST


def test_the_latest_events_up_to_a_scan_are_found_also_those_of_an_earlier_log():
    log, earlier = EventLog(), EventLog()
    for scan in (40, 40, 50):
        log.take(event(scan))
    for scan in (10, 20, 40):
        earlier.take(event(scan))
    log.earlier = earlier
    found = [
        [each["scan"] for each in log.up_to(scan, most)]
        for scan, most in ((50, 9), (45, 3), (15, 9), (60, 1))
    ]
    assert found == [[10, 20, 40, 40, 50], [20, 40, 40], [10], [50]]


def test_a_fault_is_known_from_its_scan_on():
    log = EventLog()
    log.take(event(7, "/faults", cause="program", where="line.py:62", text="ValueError: no"))
    assert log.faults_at(6) == []
    assert list(map(str, log.faults_at(7))) == [
        "scan 7 (t = 0.00000007 s): the program raised ValueError: no [line.py:62]"
    ]


def test_who_has_written_a_tag_is_known_of_clients_too():
    log = EventLog()
    store = Store("Recipe", 8, "01", "fe", "ann (127.0.0.1:5000)", ".Steps[2].Valve")
    assert action_of(parsed(text_of(store)), RECORDED) == store
    log.take(event(3, "/orders", kind="store", text=sentence(store), order=text_of(store)))
    log.take(
        event(5, "/orders", kind="write", text="?", order='{"do":"write","tag":"Run","value":1,"by":"x"}')
    )
    assert log.up_to(3, 1)[0]["text"] == "ann (127.0.0.1:5000) writes Recipe.Steps[2].Valve."
    assert log.pressed_at(4) == {"Recipe.Steps[2].Valve": [None, "ann (127.0.0.1:5000)"]}
    assert log.pressed_at(5) == log.pressed_at(4) | {"Run": [1, "x"]}


def test_clients_that_write_a_lot_take_no_room():
    """A client that writes its tags again changes nothing; of many tags the latest are known; people stay."""
    log, kept = EventLog(), []
    log.take(
        event(1, "/orders", kind="write", text="?", order='{"do":"write","tag":"Run","value":1,"by":"x"}')
    )
    for scan in range(2, 3 * STORED):
        store = Store(f"Tag{scan % (NAMES_MOST + 5)}", 0, "00", client="here")
        log.take(event(scan, "/orders", kind="store", text="?", order=text_of(store)))
        kept.append(len(log.pressed_at(None)))
    assert kept[:2] == [2, 3]
    assert max(kept) == NAMES_MOST + 1
    assert log.pressed_at(None)["Run"] == [1, "x"]
    again = [Store("Run", 0, "00", client="here"), Store("Run", 0, "01", client="here")]
    for store in again:
        log.take(event(9000, "/orders", kind="store", text="?", order=text_of(store)))
    assert log.pressed_at(None)["Run"] == [None, "here"]
    log.take(
        event(9001, "/orders", kind="write", text="?", order='{"do":"write","tag":"Tag7","value":1,"by":"x"}')
    )
    assert log.pressed_at(None)["Tag7"] == [1, "x"]
    assert len(log._stored._states) <= 2 * STORED
    once = EventLog()
    for scan in range(50):
        order = text_of(Store("Run", 0, f"{scan:02x}", client="here"))
        once.take(event(scan, "/orders", kind="store", text="?", order=order))
    assert len(once._stored._states) == 1


@pytest.mark.parametrize(("file", "at"), [("/tmp/x/line.py", "line.py.62"), ("/tmp/x/other.py", None)])
def test_the_line_of_a_fault_is_in_the_program_that_is_shown(tmp_path, file, at):
    fault = Fault(7, 1_000_000_000, Cause.PROGRAM, f"{file}:62", "IndexError: [1, 2]")
    assert PythonSource(tmp_path / "line.py").place_of_fault(fault) == at


def test_forces_lines_and_rules_are_those_of_the_scan_that_is_asked_for():
    log = EventLog()
    log.take(event(10, "/forces", **{"Local:1:I.Data[0].3": 1}))
    log.take(event(20, "/forces", tags={"Run": True}))
    log.take(event(15, "/sequences", sequence="cycle", file="line.py", line=14, wait="a move"))
    for scan, rule in ((12, "CMD-06"), (18, "CMD-07")):
        log.take(event(scan, kind="rule", slot=1, name=rule, bits=["COMMAND_ERROR"], text=rule, section="6"))
    assert log.forces_at(9) == {}
    assert log.forces_at(10) == {"Local:1:I.Data[0].3": 1}
    assert log.forces_at(None) == {"Run": True}
    assert log.lines_at(14) == {}
    assert log.lines_at(15)["cycle"]["line"] == 14
    assert [each["rule"] for each in log.rules_at(17)] == ["CMD-06"]
    assert [each["rule"] for each in log.rules_at(None)] == ["CMD-07"]


def test_what_stood_long_ago_is_forgotten():
    log = EventLog()
    for scan in range(3 * STATES):
        log.take(event(scan, "/forces", **{"Local:1:I.Data[0].3": scan % 2}))
    assert log.forces_at(3 * STATES - 1) == {"Local:1:I.Data[0].3": 1}
    assert log.forces_at(0) == {}


def test_forces_have_words():
    log = EventLog()
    log.take(event(10, "/forces", tags={"Run": True, "Level": 7}))
    log.take(event(20, "/forces", tags={}))
    assert [each["text"] for each in log.since(0)] == ["Forced: Run 1, Level 7", "Nothing is forced."]
