"""Labels of marks: what happened, and that it is over."""

import pytest
from scanrack.traces import TraceEvent
from scanrack.traces.plot.marks import marks


def label(topic, fields):
    (mark,) = marks([TraceEvent(topic=topic, scan=1, now_ns=5, fields={"slot": 1, **fields})], 0, 10)
    return mark.label


@pytest.mark.parametrize(
    ("name", "outcome", "told"),
    [
        ("home", "home", "home found"),
        ("home", "found no home", "home found no home"),
        ("absolute", "complete", "absolute complete"),
    ],
)
def test_moves(name, outcome, told):
    assert label("/events", {"kind": "move", "name": name, "outcome": outcome}) == told


@pytest.mark.parametrize(
    ("name", "begins", "told"),
    [
        ("link-lost", True, "link-lost"),
        ("link-lost", False, "link back"),
        ("asic-lost", False, "link back"),
        ("removed", False, "inserted"),
        ("line-down", False, "line back"),
        ("replies-lost", False, "replies-lost over"),
    ],
)
def test_incidents_begin_and_end(name, begins, told):
    assert label("/stimuli", {"kind": "stimulus", "name": name, "begins": begins}) == told


def test_inputs_go_on_and_off():
    assert label("/stimuli", {"kind": "stimulus", "name": "estop", "energized": False}) == "estop off"
