"""The events of a session: what is kept, and what stood in a scan."""

from scanrack.runtime.cli.watch.event_log import FIRST, KEPT, STATES, EventLog


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
