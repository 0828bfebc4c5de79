"""Options of the PCL601 adapter that say how it is wired, and what it may take over.

Limits read one by one (`limit_sense`), the backplane home proximity (`proximity`), and a controller
that was found running a program of its own (`takeover`).
"""

from __future__ import annotations

from itertools import pairwise

import pytest
from adapterbench import AdapterBench, move
from scanrack.io_images.amci3601 import InputBit
from scanrack.io_images.pcl601 import Code, Register
from scanrack.io_images.pcl601.program import parse_program
from scanrack.runtime.controllers.pcl601.program import ProgramMachine
from scanrack.runtime.machine import Switch

CW, CCW, HOME = InputBit.CW_LIMIT, InputBit.CCW_LIMIT, InputBit.HOME
NORMALLY_CLOSED = (0x843E, 0x3F & ~(CW | CCW), 1, 0)
"""The usual configuration, but both limits active when they are not energized."""

CW_AT_4000 = Switch(CW, 4000, None, normally_closed=True)
CCW_AT_4000 = Switch(CCW, None, -4000, normally_closed=True)

PROXIMITY = 1 << 12
WITH_PROXIMITY = (0x847E, 63, 1, 0)
HOME_CW = (32, 0, 0, 0, 5, 0, 20, 20)
INVALID_HOME = {"MODULE_OK", "HOME_INVALID", "INPUT_ERROR", "POSITION_INVALID"}


# ---- limit_sense


@pytest.mark.parametrize(("sign", "side"), [(1, "IN_CW_LIMIT"), (-1, "IN_CCW_LIMIT")])
def test_a_normally_closed_limit_on_an_input_stops_a_move_when_it_has_been_read(sign, side):
    bench = AdapterBench(CW_AT_4000, CCW_AT_4000, limit_sense="inputs").configured(*NORMALLY_CLOSED)
    bench.give(*move(sign * 10_000), ms=3000, until="STOPPED")
    assert bench.bits == {"MODULE_OK", "INPUT_ERROR", "POSITION_INVALID", "STOPPED", side}
    bench.run(50)
    assert 4000 < sign * bench.motor <= 4000 + 5000 * 0.03  # a look at the inputs, and a stop behind it
    assert bench.position == bench.motor


def test_a_normally_open_limit_on_an_input_stops_the_motor_by_itself_too():
    bench = AdapterBench(Switch(CW, 4000, None), limit_sense="inputs").configured()
    bench.give(*move(10_000), ms=3000, until="STOPPED")
    assert bench.run(50).position == bench.motor == 4000


@pytest.mark.parametrize("bit", [CW, CCW])
def test_each_limit_has_its_own_bit_at_rest(bit):
    """By the hard limits alone a limit met at rest, before any motion, shows on both sides."""
    sides = {CW: "IN_CW_LIMIT", CCW: "IN_CCW_LIMIT"}
    for sense, shown in (("inputs", {sides[bit]}), ("hard_limits", set(sides.values()))):
        bench = AdapterBench(limit_sense=sense).configured()
        bench.level(bit, True)
        assert bench.run(50).bits == {"MODULE_OK"} | shown


def test_both_limits_show_and_forbid_both_directions():
    bench = AdapterBench(limit_sense="inputs").configured()
    bench.level(CW, True)
    bench.level(CCW, True)
    bench.run(100)
    for bit in (128, 256):
        bench.give(bit, 0, 0, 0, 5, 0, 20, 20).release()
        assert bench.bits == {"MODULE_OK", "IN_CW_LIMIT", "IN_CCW_LIMIT", "INPUT_ERROR"}
        bench.give(2048).release()
    assert bench.motor == 0


@pytest.mark.slow
def test_home_is_found_behind_a_normally_closed_limit():
    """The search turns round at 4000 or a poll later, and leaves 1000..1500 downward at 999."""
    bench = AdapterBench(
        CW_AT_4000, CCW_AT_4000, Switch(HOME, -1500, -1000), limit_sense="inputs"
    ).configured(*NORMALLY_CLOSED)
    bench.give(*HOME_CW, ms=15_000, until="AT_HOME")
    assert bench.bits == {"MODULE_OK", "AT_HOME"}
    assert (bench.position, bench.motor) == (0, -999)


def test_an_input_that_is_a_limit_captures_nothing():
    bench = AdapterBench(limit_sense="inputs").give(0x843F, 63, 1, 0)
    assert bench.bits == {"MODULE_OK", "CONFIG_ERROR", "MODE_CONFIG"}
    assert bench.reasons == ["capture input"]


# ---- proximity


def proximity_bench(*switches: Switch) -> AdapterBench:
    return AdapterBench(*switches, proximity="jumper").configured(*WITH_PROXIMITY)


def seek(bench: AdapterBench, on: int, off: int, ms: int = 20_000) -> list[tuple[int, set[str]]]:
    """Search for home CW with the proximity bit set while the motor stands in a range, as a PLC would.

    Returns:
        Where the motor was every 2 ms, and the status bits.
    """
    end_ns, trail = bench.now_ns + ms * 1_000_000, []
    while bench.now_ns < end_ns and not bench.bits & {"AT_HOME", "HOME_INVALID"}:
        near = PROXIMITY if on <= bench.motor <= off else 0
        bench.give(HOME_CW[0], HOME_CW[1] | near, *HOME_CW[2:], ms=2)
        trail.append((bench.motor, bench.bits))
    return trail


def test_the_proximity_slows_the_search_down_and_the_switch_ends_it():
    bench = proximity_bench(Switch(HOME, 6000, 6100))
    before = bench.now_ns
    trail = seek(bench, 4000, 7000)
    assert bench.bits == {"MODULE_OK", "AT_HOME", "IN_HOME", "HOME_PROX_ECHO"}
    assert (bench.position, bench.motor) == (0, 6000)
    slowing = [at for at, bits in trail if "DECELERATING" in bits]
    assert 4000 < slowing[0] < slowing[-1] < 4900  # the ramp is 600 steps long, and a write late
    # 4,000 steps less a ramp of 600 at 5,000/s and 0.2 s, 600 steps in 0.2 s, about 1,300 at 1,000/s
    assert 2.2e9 < bench.now_ns - before < 2.6e9


def test_outside_a_search_the_proximity_is_an_echo_and_slows_nothing():
    bench = proximity_bench()
    before = bench.now_ns
    bench.give(2, PROXIMITY, 10, 0, 5, 0, 20, 20, ms=4000, until="MOVE_COMPLETE")
    assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE", "HOME_PROX_ECHO"}
    assert bench.now_ns - before < 2.4e9  # 8,800 steps at 5,000/s, and 0.4 s


def test_a_switch_met_before_the_proximity_is_no_home():
    """The caveat of home type 0: it takes the switch for a hard limit, which a 3601 would pass over."""
    bench = proximity_bench(Switch(HOME, 2000, 2100))
    seek(bench, 4000, 7000)
    assert bench.bits == INVALID_HOME | {"IN_HOME"}
    assert bench.motor == 2000
    assert bench.reasons == ["home before proximity"]


@pytest.mark.slow
def test_a_proximity_that_is_on_at_the_start_is_left_first():
    bench = proximity_bench(Switch(HOME, 1500, 1600))
    places = [at for at, _ in seek(bench, -1000, 3000)]
    assert bench.bits == {"MODULE_OK", "AT_HOME", "IN_HOME", "HOME_PROX_ECHO"}
    assert bench.motor == 1500
    back = places[places.index(min(places)) :]
    assert max(after - before for before, after in pairwise(back)) <= 3  # 1,000 steps/s, 2 ms


@pytest.mark.parametrize("lsw", [0, PROXIMITY], ids=["seeking", "slowed down"])
def test_a_search_that_somebody_else_stops_has_found_no_home(lsw):
    bench = proximity_bench()
    bench.give(*HOME_CW, ms=500)
    bench.give(32, lsw, *HOME_CW[2:], ms=500)
    bench.device.controller.stop_everything()
    bench.run(100)
    assert bench.bits - {"HOME_PROX_ECHO"} == INVALID_HOME
    assert bench.reasons == ["stopped elsewhere"]


@pytest.mark.slow
def test_behind_an_end_limit_home_is_approached_from_the_commanded_side():
    """Off at 3000 after the limit, back over the range -3000..-1000, and CW from there."""
    bench = proximity_bench(Switch(CW, 3000, None), Switch(HOME, -1500, -1400))
    seek(bench, -3000, -1000)
    assert bench.bits == {"MODULE_OK", "AT_HOME", "IN_HOME", "HOME_PROX_ECHO"}
    assert bench.motor == -1500


def test_a_search_that_is_stopped_leaves_no_proximity_behind():
    """It would slow the next move down."""
    bench = proximity_bench(Switch(HOME, 60_000, 60_100))
    bench.give(32, 0, 0, 0, 5, 0, 20, 20, ms=500)
    bench.give(32, PROXIMITY, 0, 0, 5, 0, 20, 20, ms=500)
    assert bench.device.controller.outputs == 1 << 5
    bench.give(16).release()
    assert bench.device.controller.outputs == 0


# ---- a mark that was left behind


def test_a_registration_move_that_is_stopped_leaves_no_mark_behind():
    bench = AdapterBench().configured()
    bench.give(128, 0, 3, 0, 5, 0, 20, 20, ms=500)
    bench.give(0, 0, 3, 0, 5, 0, 20, 20, ms=100)  # released: the mark is set
    assert bench.device.controller.outputs == 1 << 6
    bench.give(16).release()
    assert bench.device.controller.outputs == 0


# ---- takeover

ENDLESS = """
LABEL AGAIN
WAIT 100
GOTO AGAIN
END
"""


def with_program(**options: object) -> AdapterBench:
    """Return a bench whose controller runs a program of its own, and starts it at power-up."""
    bench = AdapterBench(**options)  # type: ignore[arg-type]
    controller = bench.device.controller
    controller.runner = ProgramMachine(parse_program(ENDLESS))
    controller.autorun = True
    bench.device.power_cycle(0)
    assert controller.program_running
    return bench


@pytest.mark.parametrize("takeover", [False, True])
def test_a_program_that_runs_is_stopped_and_by_option_does_not_start_again(takeover):
    bench = with_program(takeover=takeover)
    controller = bench.device.controller
    bench.run(100)
    assert bench.bits == {"MODULE_OK", "CONFIG_ERROR", "POSITION_INVALID"}
    assert not controller.program_running
    assert controller.autorun is not takeover
    said = [event.text for event in bench.module.events if event.kind == "adapter"]
    assert said == ["a program was running in the device, and was stopped"]
    bench.configured()


def test_autorun_is_not_touched_where_no_program_runs():
    bench = AdapterBench(takeover=True)
    bench.device.controller.autorun = True
    bench.configured()
    assert bench.device.controller.autorun


def test_a_program_started_by_a_loss_of_power_is_stopped_too():
    bench = with_program(takeover=True).configured()
    controller = bench.device.controller
    controller.autorun = True
    bench.module.cycle_device()
    assert controller.program_running
    bench.run(200)
    assert bench.bits == {"MODULE_OK", "CONFIG_ERROR", "POSITION_INVALID"}
    assert not controller.program_running
    assert not controller.autorun
    bench.configured()


def test_a_controller_that_does_not_stop_its_program_is_none(monkeypatch):
    bench = with_program(takeover=True)
    controller = bench.device.controller
    with monkeypatch.context() as patch:
        patch.setattr(controller, "do", lambda code: code == Code.STOP_MOTION)
        assert bench.run(2000).bits == {"POSITION_INVALID"}
        assert controller.program_running
        assert controller.autorun
    said = [event.text for event in bench.module.events if event.kind == "adapter"]
    assert said == ["the device refuses writes, even after a stop"]
    bench.run(400)
    assert bench.bits == {"MODULE_OK", "CONFIG_ERROR", "POSITION_INVALID"}
    assert not controller.autorun


# ---- registration


@pytest.mark.parametrize("external", [True, False])
def test_a_polled_registration_stops_and_indexes_the_rest(external):
    """3,000 steps behind 6000, or where the bit was released, and what is made until that is read."""
    switches = (Switch(InputBit.EXTERNAL, 6000, 6400),) if external else ()
    bench = AdapterBench(*switches, registration="polled").configured()
    bench.give(128, 0, 3, 0, 5, 0, 20, 20, ms=1000)
    controller = bench.device.controller
    assert not controller.values[Register.INDEX_ON_FLY]  # nothing on input 2 counts
    at = 6000 if external else bench.motor
    bench.give(128 if external else 0, 0, 3, 0, 5, 0, 20, 20, ms=5000, until="STOPPED")
    assert bench.bits == {"MODULE_OK", "STOPPED"}
    assert 3000 < bench.motor - at <= 3000 + 5000 * 0.03
    assert bench.position == bench.motor
    assert not controller.outputs


TOO_SHORT = {"INVALID_PROFILE", "COMMAND_ERROR"}


@pytest.mark.parametrize("polled", ["by option", "below a minimum distance"])
def test_a_polled_registration_is_longer_than_its_ramp_down_and_its_delay(polled):
    # 5,000 to 1,000 steps/s at 20 steps/ms/s: 600 steps; 30 ms at 5,000 steps/s: 150
    for distance, bits in ((750, {"MOVING_CW", "ACCELERATING"}), (749, TOO_SHORT)):
        if polled == "by option":
            bench = AdapterBench(registration="polled").configured()
        else:
            bench = with_minimum(AdapterBench().configured(), 8)
        bench.give(128, 0, 0, distance, 5, 0, 20, 20, ms=100)
        assert bench.bits - {"MIN_REG_NONZERO"} == {"MODULE_OK"} | bits


def with_minimum(bench, thousands):
    """A minimum registration distance is stored."""
    return bench.give(0, 1024, thousands, ms=20).release(20)


@pytest.mark.parametrize("options", [{}, {"registration": "jumper"}])
def test_an_external_input_below_the_minimum_distance_counts_for_nothing(options):
    """Passed at 3000, 5000 steps too early; the one at 10,000 counts, at the latest 30 ms later."""
    early, right = Switch(InputBit.EXTERNAL, 3000, 3400), Switch(InputBit.EXTERNAL, 10_000, 10_400)
    bench = with_minimum(AdapterBench(early, right, **options).configured(), 8)
    bench.give(128, 0, 3, 0, 5, 0, 20, 20, ms=6000, until="STOPPED")
    assert bench.bits == {"MODULE_OK", "STOPPED", "MIN_REG_NONZERO"}
    assert 13_000 <= bench.position == bench.motor <= 13_000 + 5000 * 0.03
    assert ("minimum registration distance" in bench.told("substitution")) is not bool(options)


@pytest.mark.parametrize(
    ("thousands", "configuration", "on_the_fly"),
    [
        pytest.param(8, (), 0, id="external and minimum: polled"),
        pytest.param(0, (), 1, id="external, no minimum"),
        pytest.param(8, (0x843C, 63, 1, 0), 1, id="minimum, no external"),
        pytest.param(8, (0x843E, 61, 1, 0), 1, id="minimum, external normally closed"),
    ],
)
def test_the_controller_counts_from_its_input_where_nothing_can_come_too_early(
    thousands, configuration, on_the_fly
):
    bench = AdapterBench()
    bench.level(InputBit.EXTERNAL, configuration[1:2] == (61,))
    with_minimum(bench.configured(*configuration), thousands)
    bench.give(128, 0, 3, 0, 5, 0, 20, 20, ms=1000)
    assert bench.bits & {"MOVING_CW", "COMMAND_ERROR"} == {"MOVING_CW"}
    assert bench.device.controller.values[Register.INDEX_ON_FLY] == on_the_fly


def test_a_move_without_a_minimum_counts_on_its_way_again():
    """After one with a minimum: the option of the one move is not that of the next."""
    bench = with_minimum(AdapterBench().configured(), 8)
    bench.give(128, 0, 3, 0, 5, 0, 20, 20, ms=600).give(0, 0, 3, 0, 5, 0, 20, 20, ms=9000, until="STOPPED")
    with_minimum(bench, 0).give(128, 0, 3, 0, 5, 0, 20, 20, ms=600)
    assert bench.device.controller.values[Register.INDEX_ON_FLY] == 1
