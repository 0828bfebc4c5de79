"""Two things in one scan of the module, which looks at inputs, then words, then at what stops motion."""

from __future__ import annotations

import pytest
from bench3601 import CAPTURE, CONFIGURATION, IMMEDIATE_STOP, PRESET, RESET, Bench, configuration
from motions3601 import LONG, STEPS

EVERY_SCAN = pytest.mark.parametrize("scan_ms", [0.25, 2])


@EVERY_SCAN
@pytest.mark.rules("LIM-01", "MC-01")
@pytest.mark.parametrize("limit", [4_999, 5_000, 5_001])
def test_a_limit_switch_at_the_very_end_of_a_move(limit, scan_ms):
    """The last of 5000 steps ends the move at 1240 ms, the one before it comes 1 ms earlier."""
    bench = Bench.ready(scan_ms=scan_ms, machine={"cw_limit": (limit, None)}).relative(5_000).run(1_300)
    if limit == 4_999:
        assert bench.bits == {"MODULE_OK", "STOPPED", "POSITION_INVALID", "INPUT_ERROR", "IN_CW_LIMIT"}
    else:
        assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE"} | ({"IN_CW_LIMIT"} if limit == 5_000 else set())
    assert bench.position == min(limit, 5_000)


@EVERY_SCAN
@pytest.mark.rules("EST-02", "POS-03", "MC-01")
@pytest.mark.parametrize("at", [4_999, 5_000])
def test_the_emergency_stop_at_the_very_end_of_a_move(at, scan_ms):
    """With the last step the move is complete: an emergency stop then is one of the resting axis."""
    bench = Bench.ready(scan_ms=scan_ms, machine={"estop": (at, None)}).relative(5_000).run(1_300)
    ended = {"STOPPED", "POSITION_INVALID"} if at == 4_999 else {"MOVE_COMPLETE"}
    assert bench.bits == {"MODULE_OK", "INPUT_ERROR", "IN_ESTOP"} | ended
    assert bench.position == at


@EVERY_SCAN
@pytest.mark.rules("EST-02", "INP-01")
def test_the_emergency_stop_in_the_scan_of_the_start(scan_ms):
    """The move is refused (reading A-16): nothing has moved, and the position stays valid."""
    bench = Bench.ready(scan_ms=scan_ms).relative(LONG).inputs(estop=1).run(scan_ms)
    assert bench.bits == {"MODULE_OK", "INPUT_ERROR", "IN_ESTOP"}
    assert (bench.position, set(bench.fired)) == (0, {"INP-01"})


@EVERY_SCAN
@pytest.mark.rules("IST-01", "POS-02", "INP-01")
def test_immediate_stop_and_emergency_stop_together(scan_ms):
    bench = (
        Bench.ready(scan_ms=scan_ms).relative(LONG).run(400).out(IMMEDIATE_STOP).inputs(estop=1).run(scan_ms)
    )
    assert bench.bits == {"MODULE_OK", "STOPPED", "POSITION_INVALID", "INPUT_ERROR", "IN_ESTOP"}
    assert (bench.position, bench.fired) == (STEPS[400], ["POS-02", "INP-01"])


@EVERY_SCAN
@pytest.mark.rules("RST-04", "INP-01")
def test_reset_errors_and_a_new_emergency_stop_together(scan_ms):
    """What was is forgiven, what comes is not."""
    bench = Bench.ready(scan_ms=scan_ms).inputs(estop=1).run(2).inputs(estop=0).run(2)
    bench.out(RESET).inputs(estop=1).run(scan_ms)
    assert bench.bits == {"MODULE_OK", "INPUT_ERROR", "IN_ESTOP"}


@EVERY_SCAN
@pytest.mark.rules("CAP-01", "PST-01")
def test_capture_and_preset_together(scan_ms):
    """The capture comes first: it keeps the position before the preset."""
    bench = Bench.ready(scan_ms=scan_ms, config=configuration(add=CAPTURE), position=5)
    bench.out(PRESET, 0, 0, 9).inputs(capture=1).run(scan_ms)
    assert (bench.captured, bench.position) == (5, 9)


@EVERY_SCAN
@pytest.mark.rules("CFG-15", "CFG-17")
def test_an_input_and_the_end_of_configuration_mode_together(scan_ms):
    """What has become active before the first scan of command mode is not an event of it."""
    bench = Bench.ready(scan_ms=scan_ms).out(*CONFIGURATION).run(2).idle(0)
    bench.inputs(estop=1, cw_limit=1).run(scan_ms)
    assert bench.bits == {"MODULE_OK", "POSITION_INVALID", "IN_ESTOP", "IN_CW_LIMIT"}
    assert bench.fired == ["POS-01"]
