"""A recording of any length is shown at once: little of it is read before the first picture.

Broken on purpose: all events read at the start, values worked out from the first scan while a page waits,
values of another scan shown meanwhile, forces of a later scan: a test turns red.
"""

import pytest
import recordings
from made_traces import idle, record
from recordings import chunks_read, opened, recorded
from scanrack.traces import open_trace
from scanrack.watch.history.event_log import EventLog
from scanrack.watch.history.program_replica import MOST_REPEATED
from scanrack.watch.history.recorded_events import RecordedEvents
from scanrack.watch.monitors.questions import handle_message as ask

CHUNK = 50


def told(scan):
    """Return the event of a scan: a rule, a waiting sequence or the forces."""
    if scan % 700 == 0:
        return "/forces", {"Local:1:I.Data[0].3": scan % 3 % 2, "tags": {"Run": scan}}
    if scan % 60 == 0:
        return "/sequences", {"sequence": f"s{scan % 11 % 3}", "file": "a.py", "line": scan, "wait": "a move"}
    bit = f"BIT_{scan % 7}"
    return "/events", {
        "kind": "rule",
        "slot": 1,
        "name": f"R-{scan}",
        "bits": [bit],
        "text": bit,
        "section": "6",
    }


def made(folder, scans):
    """Record scans with an event in each chunk."""
    events = {scan: told(scan) for scan in range(0, scans, 20)}
    return record(folder / "made.mcap", idle(scans), events=events, chunk_scans=CHUNK, sequences=True)


def test_what_stood_in_a_scan_is_the_same_as_if_all_had_been_read(tmp_path):
    with open_trace(made(tmp_path, 3_000)) as trace:
        every, states = EventLog(), RecordedEvents(trace)
        every.take_all(trace.events())
        while states.tick():
            pass
        for scan in range(0, 3_000, 37):
            assert states.forces_at(scan) == every.forces_at(scan)
            assert states.lines_at(scan) == every.lines_at(scan)
            assert by_bit(states.rules_at(scan)) == by_bit(every.rules_at(scan))
            assert states.up_to(scan, 20) == up_to(every, scan)[-20:]


def by_bit(rules):
    return sorted(rules, key=lambda rule: rule["bit"])


def up_to(log, scan):
    return [each for each in log.since(0) if each["scan"] <= scan]


@pytest.mark.parametrize("scans", [3_000, 15_000])
def test_what_is_told_of_a_scan_at_once_is_true_and_takes_a_few_chunks(tmp_path, monkeypatch, scans):
    with open_trace(made(tmp_path, scans)) as trace:
        every = EventLog()
        every.take_all(trace.events())
        read = chunks_read(monkeypatch)
        for scan in (scans - 1, scans // 3, scans // 2 + 1):
            read.clear()
            states = RecordedEvents(trace)
            lines, rules, events = states.lines_at(scan), states.rules_at(scan), states.up_to(scan)
            assert states.forces_at(scan) == every.forces_at(scan)
            assert len(set(read)) <= 12
            assert lines.items() <= every.lines_at(scan).items()
            assert lines
            assert rules
            assert all(each in every.rules_at(scan) for each in rules)
            assert events
            assert events == up_to(every, scan)[-len(events) :]


SCANS = 3 * MOST_REPEATED


@pytest.fixture(scope="module")
def counted(tmp_path_factory):
    """A run of a program that counts."""
    return recorded(tmp_path_factory.mktemp("counted"), SCANS)


def test_the_first_picture_of_a_long_recording_does_not_wait_for_its_values(counted, tmp_path, monkeypatch):
    read = chunks_read(monkeypatch)
    with opened(counted, tmp_path) as seen:
        assert len(set(read)) <= 6
        assert (seen.frame["scan"], seen.frame["known"]) == (SCANS - 1, False)
        assert "power" not in seen.frame
        ask(seen.monitor, seen.page, {"id": 1, "do": "show", "routine": "Main"})
        ask(seen.monitor, seen.page, {"id": 2, "do": "watch", "tags": ["Count"]})
        assert not seen.hear()["known"]
        for scan in (SCANS - 1, 0, SCANS // 2, MOST_REPEATED + 1):
            frame = seen.settle() if scan == SCANS - 1 else seen.look(scan)
            assert (frame["scan"], frame["known"]) == (scan, True)
            assert frame["tags"]["Count"] == scan + 1
            assert frame["power"]["Main.1"][0] == str((scan + 1) % 2)


def test_values_of_another_scan_are_not_shown_for_one_whose_are_not_known(counted, tmp_path):
    with opened(counted, tmp_path, scan=3) as seen:
        ask(seen.monitor, seen.page, {"id": 1, "do": "show", "routine": "Main"})
        assert seen.monitor._indexer is not None
        while seen.monitor._indexer.next <= 10:
            seen.monitor.tick()
        assert seen.hear()["tags"]["Count"] == 4
        seen.frame.clear()
        late = seen.look(SCANS - 1)
        assert (late["known"], "tags" in late, "power" in late) == (False, False, False)
        assert seen.look(3)["tags"]["Count"] == 4


LINKED = """
PROGRAM count
SLOT card : 1
TAG Lost : DINT
ROUTINE Main
NEQ(card.I.Fault,0)ADD(Lost,1,Lost);
END
"""
INCIDENT = '[[incident]]\nat_s = 0.2\nwhat = "link-lost"\nfor_ms = 40\n'


def test_a_program_that_reads_the_link_is_shown_with_the_link_as_it_was(tmp_path):
    """Lost in scans 100 to 119."""
    with opened(recorded(tmp_path, 300, LINKED, more=INCIDENT), tmp_path) as seen:
        ask(seen.monitor, seen.page, {"id": 1, "do": "watch", "tags": ["Lost"]})
        seen.settle()
        assert [seen.look(scan)["tags"]["Lost"] for scan in (99, 100, 110, 119, 200)] == [0, 1, 11, 20, 20]


WRITTEN = """
PROGRAM count
TAG Seen : DINT
ROUTINE Main
MOV(Local:1:I.Data[6],Seen);
ADD(Local:1:I.Data[6],1,Local:1:I.Data[6]);
END
"""


def test_inputs_that_a_program_writes_stay_until_the_next_exchange(tmp_path, monkeypatch):
    """The RPI of 2 ms is two scans; with inputs of every scan, the tag is 0."""
    head = 'scan_ms = 1\ncontroller = "compactlogix"\n'
    monkeypatch.setattr(recordings, "RACK", head + recordings.RACK)
    with opened(recorded(tmp_path, 1200, WRITTEN), tmp_path) as seen:
        ask(seen.monitor, seen.page, {"id": 1, "do": "watch", "tags": ["Seen"]})
        seen.settle()
        assert [seen.look(scan)["tags"]["Seen"] for scan in (20, 21, 22, 23, 1023)] == [0, 1, 0, 1, 1]


@pytest.mark.slow
def test_a_recording_that_is_still_written_is_opened_and_followed(counted, tmp_path):
    content = counted.read_bytes()
    with open_trace(counted) as trace:
        ends = [each.span.end for each in trace.sections]
        begin = trace.sections[0].span.offset
        firsts = [trace.first_scan(place) for place in range(1, len(ends))]
    path = tmp_path / "growing.mcap"
    path.write_bytes(content[: begin + 100])
    with opened(path, tmp_path) as seen:
        assert "scan" not in seen.frame
        seen.monitor.tick()
        for last, end in zip([*firsts, SCANS], ends, strict=True):
            path.write_bytes(content[: end + 10])
            frame = seen.settle()
            assert frame["scan"] == frame["range"][1] == last - 1
            assert frame["known"]
        ask(seen.monitor, seen.page, {"id": 2, "do": "watch", "tags": ["Count"]})
        assert seen.look(SCANS - 1)["tags"]["Count"] == SCANS
        assert seen.look(12)["tags"]["Count"] == 13


def test_a_page_that_looks_back_stays_there_while_the_recording_grows(counted, tmp_path):
    content = counted.read_bytes()
    with open_trace(counted) as trace:
        first = trace.sections[0].span.end
    path = tmp_path / "growing.mcap"
    path.write_bytes(content[:first])
    with opened(path, tmp_path) as seen:
        seen.look(100)
        path.write_bytes(content)
        frame = seen.settle()
        assert (frame["scan"], frame["range"]) == (100, [0, SCANS - 1])
