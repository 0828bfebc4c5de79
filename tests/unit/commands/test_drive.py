"""`scanrack drive`: what it answers, what it refuses, and that it repeats itself byte for byte."""

from __future__ import annotations

import io
import json
import sys

import forked
import pytest
from scanrack.commands.wire.drive import respond_to_lines
from scanrack.jobs.drive.targets import BENCHES

CONFIGURE = [-31682, 63, 1, 0, 0, 0, 0, 0]
IDLE = [0] * 8
MOVE = [2, 0, 10, 0, 5, 0, 20, 10]


def session(*requests, target="amci3601"):
    """Return the exit status and the replies of a session."""
    out = io.StringIO()
    lines = [request if isinstance(request, str) else json.dumps(request) for request in requests]
    status = respond_to_lines(BENCHES[target](), [line + "\n" for line in lines], out)
    return status, [json.loads(line) for line in out.getvalue().splitlines()]


def test_the_documented_session():
    # chapter 2: 0.2 s up, 0.4 s down, 8,200 steps at 5,000/s are 1.64 s: 2.24 s after 40 ms
    status, replies = session(
        {"out": CONFIGURE, "for_ms": 20},
        {"out": IDLE, "for_ms": 20},
        {"out": MOVE, "for_ms": 5000, "until": {"set": ["MOVE_COMPLETE"]}},
    )
    assert status == 0
    assert replies[0]["bits"] == ["MODULE_OK", "MODE_CONFIG"]
    assert (replies[0]["position"], replies[0]["encoder"], replies[0]["captured"]) == (None, None, None)
    assert replies[2] == {
        "t_ms": 2280,
        "scan": 1140,
        "in": [0x4480, 0, 10, 0, 0, 0, 0, 0],
        "bits": ["MOVE_COMPLETE", "POSITION_INVALID", "MODULE_OK"],
        "position": 10_000,
        "encoder": 0,
        "captured": 0,
        "rules": [],
        "met": True,
    }


def test_before_the_first_scan_is_the_power_up_image():
    _, [reply] = session({})
    assert (reply["t_ms"], reply["scan"], reply["in"]) == (0, 0, [0x6400, 0, 0, 0, 0, 0, 0, 0])


def test_changes_come_at_the_end_of_their_scans():
    _, replies = session(
        {"new": {"scan_ms": 0.25}},
        {"out": CONFIGURE, "for_ms": 1, "changes": True},
        {"for_ms": 1, "changes": True},
    )
    assert replies[1]["changes"] == [[0.25, [0xC43E - 0x10000, 63, 1, 0, 0, 0, 4, 1]]]
    assert replies[2]["changes"] == []


def test_a_missed_until_runs_out_its_time():
    _, [reply] = session({"for_ms": 7, "until": {"set": ["MOVE_COMPLETE"]}})
    assert (reply["met"], reply["t_ms"], reply["scan"]) == (False, 8, 4)  # rounded up to whole scans of 2 ms


def test_rules_are_those_of_the_request():
    _, replies = session(
        {"out": CONFIGURE, "for_ms": 4},
        {"out": IDLE, "for_ms": 4},
        {"out": [1, 0, 10, 0, 5, 0, 20, 10], "for_ms": 4},
        {"for_ms": 4},
    )
    assert [reply["rules"] for reply in replies] == [["CER-01"], ["POS-01"], ["CMD-06"], []]


def test_a_power_cycle_keeps_clock_words_and_shaft():
    _, replies = session(
        {"new": {"machine": {"home": [5000, 20_000]}}},
        {"out": CONFIGURE, "for_ms": 4},
        {"out": IDLE, "for_ms": 4},
        {"out": MOVE, "for_ms": 3000},
        {"power_cycle": True},
        {"out": CONFIGURE, "for_ms": 4},
        {"out": IDLE, "for_ms": 4},
    )
    assert replies[3]["position"] == 10_000
    assert (replies[4]["t_ms"], replies[4]["in"][0]) == (3008, 0x6400)
    assert replies[6]["position"] == 0
    assert "IN_HOME" in replies[6]["bits"]  # the shaft is still at 10,000


def test_an_until_that_is_met_drops_the_rest_of_the_encoder_counts():
    encoder = [0x853E - 0x10000, 63, 1, 0, 0, 0, 0, 0]
    _, replies = session(
        {"out": encoder, "for_ms": 4},
        {"out": IDLE, "for_ms": 4},
        {"out": MOVE, "for_ms": 1000, "until": {"set": ["MOVING_CW"]}, "encoder": {"counts": 1000}},
        {"for_ms": 100},
    )
    # met after one scan of 2 ms, in which 1000 counts in 1000 ms are 2
    assert (replies[2]["encoder"], replies[3]["encoder"]) == (2, 2)


REFUSED = [
    ("not json", "not a JSON object"),
    ("[1]", "not a JSON object"),
    ({"foo": 1}, "foo: unknown key; choose from new, power_cycle, plc_mode"),
    ({"new": {"firmwre": "4.1"}}, "new.firmwre: unknown key; choose from firmware"),
    ({"new": {"firmware": "9.9"}}, 'new.firmware: "9.9" is not allowed'),
    ({"new": {"scan_ms": 0.3}}, "new.scan_ms: 0.3 is not allowed: must be a multiple of 0.25"),
    ({"new": {"machine": {"home": [5, 1]}}}, "new.machine.home: [5, 1] is not allowed"),
    ({"new": {"options": {"stoped_after_config": True}}}, "did you mean stopped_after_config"),
    ({"new": {"options": {"stopped_after_config": 1}}}, "1 is not true or false"),
    ({"out": [1, 2, 3]}, "out: [1, 2, 3] is not allowed"),
    ({"out": [70_000, 0, 0, 0, 0, 0, 0, 0]}, "out.0: 70000 is not allowed"),
    ({"out": [True, 0, 0, 0, 0, 0, 0, 0]}, "out.0: true is not allowed"),
    ({"inputs": {"home": 2}}, "inputs.home: 2 is not allowed"),
    (
        {"new": {"machine": {"home": [1, 5]}}, "inputs": {"home": 1}},
        "inputs.home: a switch of the machine operates this input: remove the key",
    ),
    ({"for_ms": -1}, "for_ms: -1 is not allowed"),
    ('{"for_ms": NaN}', "NaN is not a number"),
    ({"until": {"set": ["MOVE_COMPLET"]}}, "did you mean MOVE_COMPLETE"),
    ({"encoder": {"counts": 5}}, "for_ms must be above 0"),
    ({"encoder": {"markers_ms": [9]}, "for_ms": 5}, "9 is beyond for_ms = 5"),
    ({"plc_mode": "test"}, 'plc_mode: "test" is not allowed'),
    ({"link": "down"}, "link: unknown key"),
]


@pytest.mark.parametrize(("request_", "said"), REFUSED, ids=[said[:30] for _, said in REFUSED])
def test_what_can_not_be_taken_changes_nothing(request_, said):
    status, replies = session({"out": CONFIGURE, "for_ms": 4}, request_, {})
    assert status == 2
    assert said in replies[1]["error"]
    assert replies[1]["line"] == 2
    assert (replies[2]["t_ms"], replies[2]["in"]) == (4, replies[0]["in"])


@pytest.mark.parametrize("target", ["pcl601-adapter", "pmc006-adapter"])
def test_diagnostic_feedback_is_tried_by_the_same_requests_on_all_hardwares(target):
    home_stroke = {"home_stroke": 100_000} if target == "pmc006-adapter" else {}
    status, replies = session(
        {"new": {"wiring": "diagnostic", "options": {"diagnostic": "mirror"} | home_stroke}},
        {"out": [-31172, *CONFIGURE[1:]], "for_ms": 500},
        {"out": IDLE, "for_ms": 100},
        {"out": [2, 0, 1, 500, 5, 0, 20, 20], "for_ms": 5000, "until": {"set": ["MOVE_COMPLETE"]}},
        target=target,
    )
    assert status == 0
    assert (replies[-1]["position"], replies[-1]["encoder"]) == (1500, 1500)


def test_the_firmware_of_an_adapter_is_not_to_be_chosen():
    status, [reply] = session({"new": {"firmware": "3.1"}}, target="pmc006-adapter")
    assert (status, reply["line"]) == (2, 1)
    assert "firmware is for target amci3601 only" in reply["error"]


def test_two_processes_answer_byte_for_byte_the_same():
    lines = "\n".join(
        json.dumps(request)
        for request in (
            {"out": CONFIGURE, "for_ms": 4},
            {"out": IDLE, "for_ms": 4},
            {"out": MOVE, "for_ms": 500, "changes": True},
            {"inputs": {"estop": 1}, "for_ms": 10, "changes": True},
        )
    )
    command = [sys.executable, "-m", "scanrack", "drive", "amci3601"]
    runs = [
        forked.run(command, input=lines, capture_output=True, text=True, check=True, encoding="utf-8")
        for _ in range(2)
    ]
    assert runs[0].stdout == runs[1].stdout
    assert len(runs[0].stdout.splitlines()) == 4
