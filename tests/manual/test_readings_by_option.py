"""Options of the model: each reading that can be chosen, the default beside the other way.

What the default does is proved with the rules; here both ways stand side by side.
"""

from __future__ import annotations

import ast
import json
import re
from inspect import getdoc
from pathlib import Path

import pytest
from bench3601 import CAPTURE, ENCODER, HOLD, RELATIVE, RESUME, Bench, configuration
from scanrack.io_images.amci3601 import RULES
from scanrack.runtime.modules.amci3601 import Amci3601Options

ROOT = Path(__file__).parents[2]


def rows():
    """Return reading, name and default of each option in the table of docs/readings.md."""
    page = (ROOT / "docs" / "readings.md").read_text(encoding="utf-8")
    table = page[page.index("## Options") : page.index("## Timing")]
    for reading, names, _, default in re.findall(
        r"^\| (A-\w+) \| (.+) \| (.+) \| (.+) \|$", table, re.MULTILINE
    ):
        ticked = (re.findall(r"`(\w+)`", cell) for cell in (names, default))
        yield from ((reading, name, value) for name, value in zip(*ticked, strict=True))


def test_every_option_stands_in_the_table_of_readings_with_its_default():
    defaults = {name: json.dumps(field.default) for name, field in Amci3601Options.model_fields.items()}
    assert {name: default for _, name, default in rows()} == defaults


def test_every_option_is_described_with_its_reading():
    described = re.findall(r"^ {4}(\w+): ((?:.|\n {8})*)", getdoc(Amci3601Options) or "", re.MULTILINE)
    told = {name: re.findall(r"A-\w+", text) for name, text in described}
    assert told == {name: [reading] for reading, name, _ in rows()}


def test_a_rule_follows_every_reading_that_has_an_option():
    named = {reading for rule in RULES.values() for reading in rule.reading}
    assert {name: reading for reading, name, _ in rows() if reading not in named} == {}


def test_every_option_is_chosen_by_a_parameter_of_a_test_here():
    calls = [
        node for node in ast.walk(ast.parse(Path(__file__).read_text("utf-8"))) if isinstance(node, ast.Call)
    ]
    chosen = {key.arg for call in calls for key in call.keywords if isinstance(key.value, ast.Name)}
    assert set(Amci3601Options.model_fields) - chosen == set()


@pytest.mark.parametrize(("chosen", "position"), [(True, 1), (False, 0)])
def test_a_move_under_the_input_that_has_held_the_axis(chosen, position):
    bench = Bench.configured(one_step_under_external=chosen).relative(10_000).run(200)
    bench.inputs(external=1).until("HOLD_STATE")
    held_at = bench.position
    bench.idle().relative(500).run(50)
    assert bench.position - held_at == position  # one step in the commanded direction, or none
    assert ("COMMAND_ERROR" in bench.bits, "HOLD_STATE" in bench.bits) == (not chosen, True)
    bench.inputs(external=0)
    bench.reset_errors()
    bench.relative(500).until("MOVE_COMPLETE")
    assert bench.position - held_at == position + 500


@pytest.mark.parametrize(("chosen", "position"), [(False, 600 + 4_000 + 1_200), (True, 600 + 4_000)])
def test_a_fault_in_the_words_of_a_manual_move(chosen, position):
    # 0.2 s up are 600 steps, 0.8 s at 5,000/s are 4,000; the ramp down would be 1,200 more
    bench = Bench.ready(registration_fault_cuts=chosen).manual().run(1_000)
    bench.manual(1, 50).until("STOPPED")
    assert bench.position == position
    assert {"COMMAND_ERROR", "INVALID_PROFILE"} < bench.bits
    assert "POSITION_INVALID" not in bench.bits


@pytest.mark.parametrize("chosen", [False, True])
def test_acceleration_type_10_of_a_blend_segment(chosen):
    bench = Bench.ready(blend_type_10_invalid=chosen)
    bench.out(0, 0x300, 2, 0, 0b0010, 10).run(1)
    assert ("INVALID_PROFILE" in bench.bits) is chosen
    assert {"BLEND_ACK"} < bench.bits
    assert "COMMAND_ERROR" not in bench.bits


@pytest.mark.parametrize("words", [(2, 0, 0, 10, 1, 0), (2, 0, 0, 10, 0, 1)])
@pytest.mark.parametrize("chosen", [False, True])
def test_data_in_unused_words_of_the_first_block(chosen, words):
    bench = Bench.ready(blend_reserved_words_checked=chosen)
    assert "INVALID_PROFILE" not in bench.out(0, 0x300, *words[:4]).run(1).bits
    bench.out(0, 0x100).run(1).out().run(1)
    bench.out(0, 0x300, *words).run(1)
    assert ("INVALID_PROFILE" in bench.bits) is chosen


@pytest.mark.parametrize("chosen", [False, True])
def test_data_in_the_unused_word_of_a_segment_block(chosen):
    bench = Bench.ready(blend_reserved_words_checked=chosen)
    bench.out(0, 0x300, 2, 0, 0, 10).run(1).out(0, 0x100).run(1)
    bench.out(0, 0x300, 3, 0, 3, 0, 20, 1).run(1)
    assert ("INVALID_PROFILE" in bench.bits) is chosen


@pytest.mark.parametrize(("pause_ms", "at_rest_ms"), [(0, 0), (2_000, 2_000)])
def test_a_pause_at_the_reversal_of_home_switch_homing(pause_ms, at_rest_ms):
    bench = Bench.configured(machine={"home": (3_000, 3_500)}, home_reversal_dwell_ms=pause_ms)
    bench.command(0x20)
    bench.until("DECELERATING")
    bench.until(clear=["MOVING_CW"])
    took = 0.0 if "MOVING_CCW" in bench.bits else bench.until("MOVING_CCW")
    assert at_rest_ms <= took + 0.25 <= at_rest_ms + 1


@pytest.mark.parametrize("chosen", [False, True])
def test_stopped_after_configuration(chosen):
    assert ("STOPPED" in Bench.configured(stopped_after_config=chosen).bits) is chosen


@pytest.mark.parametrize(("chosen", "mirror"), [(False, 0), (True, 0x003E)])
def test_the_mirror_of_a_rejected_configuration(chosen, mirror):
    bench = Bench(mirror_rejected_config=chosen).out(0x803E, 0x3F, 0, 0).run(1)  # starting speed 0
    assert "CONFIG_ERROR" in bench.bits
    assert bench.words[0] & 0x1FFF == mirror


@pytest.mark.parametrize("chosen", [False, True])
def test_status_of_an_input_that_is_not_used(chosen):
    bench = Bench.ready(report_unused_inputs=chosen).inputs(capture=1).run(1)
    assert ("IN_CAPTURE" in bench.bits) is chosen
    assert bench.captured == 0


@pytest.mark.parametrize("chosen", [True, False])
def test_move_complete_after_an_error_during_the_move(chosen):
    bench = Bench.ready(complete_after_error=chosen).relative(10_000).run(100)
    bench.idle().relative(10_000).run(1)
    assert "COMMAND_ERROR" in bench.bits
    bench.until(clear=["MOVING_CW"])
    assert bench.position == 10_000
    assert ("MOVE_COMPLETE" in bench.bits) is chosen


@pytest.mark.parametrize("chosen", [True, False])
def test_hold_in_an_encoder_move(chosen):
    bench = Bench.ready(config=configuration(add=ENCODER), hold_error_in_encoder_move=chosen)
    bench.command(RELATIVE, 4_000, lsw=4).run(100)
    bench.out(HOLD, 4).run(10)
    assert ("COMMAND_ERROR" in bench.bits) is chosen
    assert "MOVING_CW" in bench.bits


@pytest.mark.parametrize(("invalid", "stopped"), [(True, True), (False, True), (True, False)])
def test_leaving_run_mode_during_a_motion(invalid, stopped):
    bench = Bench.ready(invalid_after_program_mode=invalid, stopped_after_program_mode=stopped)
    bench.relative(10_000).run(100).plc("program").run(1)
    assert ("POSITION_INVALID" in bench.bits, "STOPPED" in bench.bits) == (invalid, stopped)
    assert "MOVING_CW" not in bench.bits


@pytest.mark.parametrize("chosen", [True, False])
def test_status_bits_when_configuration_mode_is_left(chosen):
    bench = Bench.ready(clear_status_after_config=chosen).relative(100)
    bench.until("MOVE_COMPLETE")
    bench.out(*configuration()).run(1).idle(1)
    assert ("MOVE_COMPLETE" in bench.bits) is not chosen
    assert "POSITION_INVALID" in bench.bits


@pytest.mark.parametrize(("period_us", "seen"), [(250, True), (250_000, False)])
def test_the_input_scan_decides_which_pulse_is_seen(period_us, seen):
    bench = Bench(scan_ms=0.25, input_scan_us=period_us)
    bench.out(*configuration(add=CAPTURE)).run(500)
    bench.out().run(500)
    bench.out(0x0200, 0, 0, 55).run(500).idle(500)
    bench.run(100).inputs(capture=1).run(1).inputs(capture=0).run(500)  # a pulse of 1 ms
    assert bench.captured == (55 if seen else 0)


def test_resume_is_allowed_once_the_external_input_is_off():
    bench = Bench.configured(one_step_under_external=False).relative(10_000).run(200)
    bench.inputs(external=1).until("HOLD_STATE")
    bench.inputs(external=0).idle().command(RESUME).until("MOVE_COMPLETE")
    assert bench.position == 10_000
