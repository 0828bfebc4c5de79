"""`scanrack drive pcl601`: its keys, its pins, what it refuses, the line's time."""

from __future__ import annotations

import io
import json

import pytest
from scanrack.commands.wire.drive import respond_to_lines
from scanrack.jobs.drive.targets import BENCHES

IDENT = "01 11 c0 2c"
IDENTITY = "01 11 05 01 31 2e 30 30 c7 b2"
TO_ASCII = "00 06 00 00 00 0b c9 dc"


def session(*requests):
    """Return the exit status and the replies of a session."""
    out = io.StringIO()
    lines = [request if isinstance(request, str) else json.dumps(request) for request in requests]
    status = respond_to_lines(BENCHES["pcl601"](), [line + "\n" for line in lines], out)
    return status, [json.loads(line) for line in out.getvalue().splitlines()]


def test_bytes_take_the_line_s_time():
    status, [reply] = session({"tx": IDENT})
    # 4 characters of 286.458 µs, 3.5 of silence, 10 of the reply
    assert status == 0
    assert reply.pop("t_ms") == pytest.approx(17.5 * 11 / 38.4, abs=1e-5)
    assert reply == {"rx": IDENTITY, "rx_text": bytes.fromhex(IDENTITY).decode("latin-1")}


def test_silence_is_waited_for_from_the_last_byte_on():
    _, [reply] = session({"tx": TO_ASCII})
    assert reply == {"t_ms": pytest.approx(8 * 11 / 38.4 + 200, abs=1e-5), "rx": None, "rx_text": None}


def test_frames_are_kept_apart():
    _, replies = session({"tx": IDENT}, {"tx": IDENT})
    assert replies[1]["rx"] == IDENTITY
    assert replies[1]["t_ms"] == pytest.approx((2 * 17.5 + 3.5) * 11 / 38.4, abs=1e-4)


def test_text_in_ascii_mode_has_ten_bits():
    _, replies = session({"tx": TO_ASCII}, {"tx_text": "@%\r"}, {"tx_text": "@%\r", "char_gap_ms": 10})
    assert [reply["rx_text"] for reply in replies] == [None, "1\r\n", "1\r\n"]
    assert replies[1]["t_ms"] - replies[0]["t_ms"] == pytest.approx(6 * 10 / 38.4, abs=1e-5)
    assert replies[2]["t_ms"] - replies[1]["t_ms"] == pytest.approx(6 * 10 / 38.4 + 20, abs=1e-5)


def test_the_echo_of_the_switch_is_the_last_in_modbus_format():
    _, replies = session({"tx": "01 06 00 00 00 0b c8 0d"}, {"tx_text": "@%\r"})
    assert replies[0]["t_ms"] == pytest.approx(19.5 * 11 / 38.4, abs=1e-4)
    assert replies[1]["t_ms"] - replies[0]["t_ms"] == pytest.approx(6 * 10 / 38.4, abs=1e-4)


def test_for_ms_is_exact():
    _, replies = session({"for_ms": 0.25}, {"for_ms": 1e-6}, {})
    assert [reply["t_ms"] for reply in replies] == [0.25, 0.250001, 0.250001]


def test_pins_that_follow_the_motor_marks_and_signals():
    _, replies = session(
        {"env": {"jog_minus": "ground", "hard_minus": {"ground_when_pos_le": -250}}, "for_ms": 100},
        {"mark": "here", "for_ms": 1000, "observe": ["position", "position_minus_mark:here", "led"]},
        {"env": {"encoder_counts": 77}, "observe": ["encoder_counts", "output1", "driver_on_off"]},
        {"power_cycle": True, "observe": ["position", "position_minus_mark:here", "encoder_counts"]},
    )
    assert replies[1]["values"] == {"position": -250, "position_minus_mark:here": -200, "led": "green"}
    assert replies[2]["values"] == {"encoder_counts": 77, "output1": "off", "driver_on_off": "on"}
    assert replies[3]["values"] == {"position": -250, "position_minus_mark:here": -200, "encoder_counts": 0}


INPUT_1 = {
    "high": 0,
    "ground": 1,
    "open": 1,  # no pull-up: 0 V
}


@pytest.mark.parametrize(("level", "bit"), INPUT_1.items(), ids=INPUT_1)
def test_input_1(level, bit):
    read = {"tx": "01 02 00 00 00 01 b9 ca"}
    _, replies = session(
        {"env": {"in1": level}},
        read,
        {"env": {"in1_volts": 1.9}},
        read,
        {"env": {"in1_volts": 0, "in1": "high"}},
        read,
    )
    assert [int(reply["rx"].split()[3]) for reply in replies[1::2]] == [bit, 1, 0]


def test_options():
    program = "MOVE 100\nFINISH\nEND"
    _, replies = session(
        {"new": {"address": 9, "program": program, "encoder": {"ratio": 4}}},
        {"tx": "09 06 00 00 00 0c 88 87"},
        {"for_ms": 2000, "observe": ["position", "encoder_counts"]},
        {"new": {}, "observe": ["position"]},
    )
    assert replies[1]["rx"] == "09 06 00 00 00 0c 88 87"
    assert replies[2]["values"] == {"position": 100, "encoder_counts": 400}
    assert replies[3] == {"t_ms": 0, "values": {"position": 0}}


def test_the_reset_button():
    _, replies = session({"tx": TO_ASCII}, {"reset": True}, {"tx": IDENT})
    assert replies[2]["rx"] == IDENTITY


REFUSED = [
    ({"new": {"address": 100}}, "new.address: 100"),
    ({"new": {"program": "MOVE 1"}}, "new: "),
    ({"new": {"thumbwheel": "12"}}, 'new.thumbwheel: "12"'),
    ({"new": {"sw2": "IN"}}, 'new.sw2: "IN"'),
    ({"new": {"encoder": {"model": "x"}}}, 'new.encoder.model: "x"'),
    ({"new": {"encoder": {"teeth": 4}}}, "new.encoder.teeth: unknown key; choose from ratio, model, steps"),
    ({"env": {"in7": "open"}}, "env.in7: unknown key; choose from in1"),
    ({"env": {"in2": "low"}}, 'env.in2: "low" is not allowed'),
    ({"env": {"in2": {"ground_when_pos_ge": "a"}}}, "env.in2: must be"),
    ({"env": {"in1_volts": 5.1}}, "env.in1_volts: 5.1"),
    ({"observe": ["speed"]}, 'observe: "speed" is not a signal'),
    ({"observe": ["position_minus_mark:a"]}, "its mark is not set"),
    ({"tx": "0g"}, "bytes in hex"),
    ({"tx": ""}, "at least one byte"),
    ({"tx": "01", "tx_text": "a"}, "not both"),
    ({"tx": "01", "char_gap_ms": 1}, "char_gap_ms"),
    ({"tx_text": "\u20ac"}, "U+00FF"),
    ({"for_ms": -1}, "for_ms: -1"),
    ({"out": [0] * 8}, "out: unknown key"),
    ("[1]", "not a JSON object"),
]


@pytest.mark.parametrize(("request_", "text"), REFUSED, ids=[str(row[0]) for row in REFUSED])
def test_refused_and_nothing_has_changed(request_, text):
    if isinstance(request_, dict):
        request_ = {"for_ms": 7, "env": {"jog_plus": "ground"}} | request_
    status, replies = session(request_, {"observe": ["position"]})
    assert status == 2
    assert replies[0]["line"] == 1
    assert text in replies[0]["error"]
    assert replies[1] == {"t_ms": 0, "values": {"position": 0}}


def test_the_same_session_twice():
    requests = [{"env": {"jog_plus": "ground"}, "for_ms": 123.4}, {"tx": IDENT, "observe": ["position"]}]
    assert session(*requests) == session(*requests)
