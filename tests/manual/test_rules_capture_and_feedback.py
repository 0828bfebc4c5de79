"""The capture input and diagnostic feedback [chapters 3, 4 and 6].

A relative move of the usual profile makes 600 steps in 200 ms and 5 a ms from then on.
"""

from __future__ import annotations

import pytest
from bench3601 import (
    CAPTURE,
    DIAGNOSTIC,
    ENCODER,
    HOME_CW,
    PRESET,
    PRESET_ENCODER,
    RESET,
    Bench,
    configuration,
)
from motions3601 import LONG, MOTIONS, STEPS, Motion

EVERY_SCAN = pytest.mark.parametrize("scan_ms", [0.25, 2])
ALONE = configuration(add=CAPTURE)
COUNTING = configuration(add=CAPTURE | ENCODER)
FEEDBACK = configuration(add=CAPTURE | DIAGNOSTIC)
UNDER_WAY = [motion for motion in MOTIONS if not motion.follows]
OWN_STEPS = [motion for motion in UNDER_WAY if "encoder" not in motion.name]

# -- capture --------------------------------------------------------------------------------------


@EVERY_SCAN
@pytest.mark.rules("CAP-01", "CAP-03", "IOM-14", "STS-L00")
@pytest.mark.parametrize("direction", [1, -1], ids=["CW", "CCW"])
@pytest.mark.parametrize("firmware", ["2.1", "4.1"])
def test_without_an_encoder_the_position_is_captured(firmware, direction, scan_ms):
    """As it was in the scan of the change, which is at 300 ms: 600 + 500 steps."""
    bench = Bench.ready(firmware, config=ALONE, scan_ms=scan_ms).relative(direction * LONG).run(300)
    assert (bench.captured, "IN_CAPTURE" in bench.bits) == (0, False)
    bench.inputs(capture=1).run(scan_ms)
    assert (bench.captured, "IN_CAPTURE" in bench.bits) == (direction * 1_100, True)
    bench.run(100)
    assert bench.captured == direction * 1_100  # its level captures nothing more
    bench.inputs(capture=0).run(100)
    assert (bench.captured, "IN_CAPTURE" in bench.bits) == (direction * 1_100, False)
    bench.run(100 - scan_ms).inputs(capture=1).run(2)
    assert bench.captured == direction * 2_600  # at 600 ms


@EVERY_SCAN
@pytest.mark.rules("CAP-02", "CAP-03", "IOM-14")
@pytest.mark.parametrize("firmware", ["2.0", "4.1"])
def test_with_an_encoder_its_value_is_captured(firmware, scan_ms):
    """Not the position: 40 counts and 5 steps."""
    bench = Bench.ready(firmware, config=COUNTING, scan_ms=scan_ms).relative(5, ms=50).idle()
    bench.turn_encoder(-40, 10).inputs(capture=1).run(scan_ms)
    bench.turn_encoder(-40, 10)
    assert (bench.captured, bench.encoder, bench.position) == (-40, -80, 5)


@pytest.mark.rules("CAP-01")
def test_diagnostic_feedback_is_no_encoder():
    """The position is captured, not the count (reading A-69)."""
    bench = Bench.ready(config=FEEDBACK).relative(5, ms=50).idle()
    assert (bench.position, bench.encoder) == (5, 0)  # not wired
    bench.inputs(capture=1).run(1)
    assert bench.captured == 5


@pytest.mark.rules("CAP-01", "CFG-19")
def test_an_active_low_capture_input_captures_when_it_goes_off():
    bench = Bench.ready(config=configuration(add=CAPTURE, levels=0x3E), position=7)
    assert "IN_CAPTURE" in bench.bits
    bench.inputs(capture=1).run(1)
    assert bench.captured == 0
    bench.inputs(capture=0).run(1)
    assert bench.captured == 7


@pytest.mark.rules("CAP-01")
def test_an_input_that_is_active_when_it_is_configured_makes_no_transition():
    """Nor one that becomes active in configuration mode (reading A-69)."""
    bench = Bench.ready(config=ALONE, position=7)
    bench.inputs(capture=1).run(1).inputs(capture=0).run(1).relative(5, ms=50)
    bench.out(*ALONE).run(1).inputs(capture=1).run(1).idle(1)
    assert (bench.captured, bench.bits) == (7, {"MODULE_OK", "POSITION_INVALID", "IN_CAPTURE"})
    bench.inputs(capture=0).run(1).inputs(capture=1).run(1)
    assert bench.captured == 0


@pytest.mark.rules("CAP-03", "CAP-04", "IOM-14")
def test_nothing_but_a_capture_and_homing_changes_the_captured_value():
    """Presets, Reset Errors, a configuration leave it; homing makes it 0 [chapter 6, Captured Data]."""
    bench = Bench.ready(config=ALONE, position=-12_345).inputs(capture=1).run(1).inputs(capture=0).run(1)
    assert bench.words[6:] == [-12, -345]
    for command in (PRESET, PRESET_ENCODER, RESET):
        bench.out(command).run(1).idle()
        assert bench.captured == -12_345
    bench.relative(50, ms=100).out(*ALONE).run(1).idle()
    assert bench.captured == -12_345
    bench.command(HOME_CW, ms=10).inputs(home=1).run(500).inputs(home=0).run(1_000).inputs(home=1)
    bench.until("AT_HOME")
    assert bench.captured == 0


@EVERY_SCAN
@pytest.mark.rules("CAP-01")
@pytest.mark.parametrize("motion", UNDER_WAY, ids=lambda motion: motion.name)
def test_capture_works_during_every_motion(motion, scan_ms):
    """At 200 ms, 600 steps; by then `motions3601` has a position of 0 at the start of each."""
    bench = Bench.ready(config=ALONE, scan_ms=scan_ms)
    if "encoder" in motion.name:
        bench = Bench.ready(config=COUNTING, scan_ms=scan_ms)
    motion.before(bench)
    motion.start(bench)
    bench.run(200).inputs(capture=1).run(20)
    assert bench.captured == (0 if "encoder" in motion.name else motion.direction * STEPS[200])


@pytest.mark.rules("CAP-02", "CAP-01")
def test_capture_goes_on_in_program_mode():
    bench = Bench.ready(config=COUNTING).plc("program").run(1)
    bench.turn_encoder(9, 10).inputs(capture=1).run(1)
    assert (bench.captured, "IN_CAPTURE" in bench.bits) == (9, True)


@pytest.mark.rules("IOM-23", "CAP-01")
@pytest.mark.parametrize(
    ("on_ms", "off_ms", "seen"),
    [
        (0.01, 0.25, False),  # 240 µs between the scans at 0 and 0.25 ms
        (0.01, 0.26, True),  # 250 µs always meet a scan
        (0.0, 0.01, True),  # 10 µs may
        (0.25, 0.26, True),
    ],
)
def test_an_input_is_looked_at_every_250_microseconds(on_ms, off_ms, seen):
    """Exchanges every 10 µs show pulses shorter than the module's own scan."""
    bench = Bench.ready(config=ALONE, position=3, scan_ms=0.01)
    assert bench.now_ns % 250_000 == 0
    bench.run(on_ms).inputs(capture=1).run(round(off_ms - on_ms, 2)).inputs(capture=0).run(1)
    assert bench.captured == (3 if seen else 0)


@pytest.mark.rules("IOM-23")
def test_switch_the_period_of_the_scan():
    """Option `input_scan_us` (reading A-01): 250 ms, as two lines of the manual have it."""
    bench = Bench(scan_ms=10, input_scan_us=250_000).out(*ALONE)
    assert bench.until("MODE_CONFIG") == 10  # the scan at 0
    bench.out(PRESET, 0, 0, 3)
    assert bench.until("MODULE_OK", clear=["MODE_CONFIG"]) == 250  # the scan at 250 ms, shown at 260
    bench.inputs(capture=1).run(100).inputs(capture=0).run(400)
    assert bench.captured == 0
    bench.inputs(capture=1).run(250).inputs(capture=0).run(260)
    assert bench.captured == 3


# -- diagnostic feedback --------------------------------------------------------------------------


@EVERY_SCAN
@pytest.mark.rules("DFB-01", "IOM-06")
@pytest.mark.parametrize("motion", OWN_STEPS, ids=lambda motion: motion.name)
def test_with_diagnostic_feedback_the_module_counts_its_own_steps(motion, scan_ms):
    """Words 4 and 5 follow words 2 and 3 through ramps and constant speed."""
    bench = Bench.ready(config=FEEDBACK, scan_ms=scan_ms, diagnostic_wiring=True)
    motion.before(bench)
    before = bench.encoder
    motion.start(bench)
    for _ in range(10):
        bench.run(40)
        assert bench.encoder - before == bench.position != 0
    assert bench.position == motion.direction * STEPS[400]


@pytest.mark.rules("DFB-01")
@pytest.mark.parametrize("add", [0, ENCODER], ids=["neither", "encoder"])
def test_without_diagnostic_feedback_the_wiring_counts_nothing(add):
    """Words 4 and 5 are 0 where neither is configured (reading A-89)."""
    bench = Bench.ready(config=configuration(add=add), diagnostic_wiring=True).relative(50, ms=100)
    assert (bench.position, bench.encoder) == (50, 0)
    bench.turn_encoder(9, 10)
    assert bench.encoder == (9 if add else 0)


@pytest.mark.rules("DFB-01")
def test_the_count_goes_on_after_a_configuration():
    bench = Bench.ready(config=FEEDBACK, diagnostic_wiring=True).relative(50, ms=100)
    bench.out(*FEEDBACK).run(1).idle().relative(-20, ms=100)
    assert (bench.position, bench.encoder) == (-20, 30)


@pytest.mark.rules("DFB-01")
def test_the_wiring_counts_nothing_by_hand():
    bench = Bench.ready(config=FEEDBACK, diagnostic_wiring=True)
    motion = Motion.of("relative cw")
    motion.start(bench)
    bench.turn_encoder(999, 200)
    assert (bench.position, bench.encoder) == (600, 600)
