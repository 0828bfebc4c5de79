"""`scanrack drive pmc006`: the bench of the simulated controller, request by request."""

from __future__ import annotations

import io
import json
from typing import Any

import pytest
from scanrack.commands.wire.drive import respond_to_lines
from scanrack.jobs.drive.targets import BENCHES


def driven(*requests: dict[str, Any]) -> list[dict[str, Any]]:
    out = io.StringIO()
    respond_to_lines(BENCHES["pmc006"](), (json.dumps(request) for request in requests), out)
    return [json.loads(line) for line in out.getvalue().splitlines()]


def test_an_exchange_takes_its_time_on_the_line() -> None:
    fresh, answer = driven({"new": {"address": 1}}, {"tx": "a5 01 6b 00 00 00 00 11"})
    assert fresh == {"t_ms": 0}
    assert answer["rx"] == "a5 7a 01 10 00 00 00 30"
    assert answer["t_ms"] == pytest.approx(2 * 8 * 10 / 9.6, abs=1e-3)  # 2 frames of 8 characters of 10 bits


def test_silence_lasts_300_ms_after_the_last_byte() -> None:
    [answer] = driven({"tx": "a5 01 6b 00 00 00 00 11"})  # 255 listens
    assert (answer["rx"], answer["rx_text"]) == (None, None)
    assert answer["t_ms"] == pytest.approx(300 + 8 * 10 / 9.6, abs=1e-3)


def test_signals_marks_and_a_switch_on_the_way() -> None:
    replies = driven(
        {"new": {"address": 1}, "env": {"ext1": "high", "ext2": {"high_when_pos_le": 499, "else": "low"}}},
        {"tx": "a5 01 66 02 00 00 00 0e"},  # f 2
        {"tx": "a5 01 34 1e 00 00 00 f8"},  # 4 30
        {"mark": "before", "tx": "a5 01 73 e8 03 00 00 04", "for_ms": 2000},  # s 1000
        {"observe": ["physical_position", "gpio8", "coil_duty", "position_minus_mark:before"]},
    )
    assert replies[-1]["values"] == {
        "physical_position": 500,
        "gpio8": "high",
        "coil_duty": 30,
        "position_minus_mark:before": 500,
    }


def test_power_off_keeps_the_shaft_and_the_pins_and_forgets_the_register() -> None:
    replies = driven(
        {"new": {"address": 1}, "env": {"ext1": "low"}},
        {"tx": "a5 01 73 c8 00 00 00 e1", "for_ms": 1000},  # s 200
        {"power_cycle": True, "tx": "a5 01 63 00 00 00 00 09"},  # c
        {"tx": "a5 01 78 00 00 00 00 1e", "observe": ["physical_position"]},  # x
    )
    assert replies[2]["rx"] == "a5 7a 01 00 00 00 00 20"
    assert replies[3]["rx"] == "a5 7a 01 0b 00 00 00 2b"  # EXT2, GPIO8, FSET
    assert replies[3]["values"] == {"physical_position": 200}


def test_a_program_runs_when_it_is_told_to() -> None:
    replies = driven(
        {"new": {"address": 1, "program": "OUT 1 0\n"}, "for_ms": 10, "observe": ["gpio8"]},
        {"tx": "a5 01 5a 00 00 00 00 00", "for_ms": 10, "observe": ["gpio8"]},
    )
    assert [reply["values"]["gpio8"] for reply in replies] == ["high", "low"]


@pytest.mark.parametrize(
    ("request_", "said"),
    [
        ({"new": {"address": 121}}, "new: address 121: must be 1 to 120, or 255 (factory setting)"),
        ({"new": {"program": "RIT 0 1"}}, "new: program: line 1: RIT is not a user instruction"),
        ({"new": {"speed": 1}}, "new.speed: unknown key; choose from address, program"),
        ({"env": {"ext1": "up"}}, 'env.ext1: "up" is not allowed: must be "low", "high"'),
        ({"env": {"ext1": {"else": "low"}}}, 'env.ext1: must be "low", "high"'),
        ({"env": {"fset": {"high_when_pos_le": 1.5}}}, 'env.fset: must be "low", "high"'),
        ({"env": {"ext2": {"high_when_pos_le": 1, "else": "high"}}}, 'env.ext2: must be "low"'),
        ({"reset": True}, "no reset button"),
        ({"observe": ["position"]}, "choose from physical_position, gpio8, coil_duty"),
        ({"tx": "a5 0"}, "bytes in hex"),
    ],
)
def test_a_request_that_cannot_be_taken_says_why_and_changes_nothing(
    request_: dict[str, Any], said: str
) -> None:
    refused, after = driven(request_, {})
    assert said in refused["error"]
    assert after == {"t_ms": 0}
