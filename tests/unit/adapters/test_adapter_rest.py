"""What an adapter claims of its motor, and when; and that no command edge is lost before it can act.

STOPPED, MOVE_COMPLETE, AT_HOME and HOLD_STATE need a read of the controller at rest, after the reply to the
stop or the start. `AdapterBench.lies` has the scans in which a claim was false.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import pytest
from adapterbench import CONFIGURE_006, AdapterBench, AdapterBench006, move
from scanrack.io_images import Image
from scanrack.io_images.amci3601 import InputBit
from scanrack.runtime import LineFormat
from scanrack.runtime.line.liveport import LiveLine
from scanrack.runtime.line.wire import Device
from scanrack.runtime.machine import Switch
from scanrack.runtime.machine.contacts import GROUND
from scanrack.runtime.modules.adapters import module
from scanrack.runtime.modules.adapters.exchanges import BIAS
from scanrack.runtime.modules.adapters.live import LiveAdapter
from scanrack.runtime.modules.adapters.pcl601.module import PCL601

FAR = tuple(move(100_000))
JOG = (128, 0, 0, 0, 5, 0, 20, 20)
STOP, PRESET, SHORT, RESET = (16,), (512,), tuple(move(100, 2000)), (2048,)
BOTH = pytest.mark.parametrize("make", [AdapterBench, AdapterBench006])
MOVING = {"MOVING_CW", "MOVING_CCW"}


def in_motion(make: type[AdapterBench], words: tuple[int, ...] = FAR, **options: object) -> AdapterBench:
    """Return an adapter whose motor has turned for most of a second."""
    bench = make(**options).configured(*CONFIGURE_006)  # type: ignore[arg-type]
    bench.give(*words, ms=700)
    assert bench.device.motor_turns
    return bench


def immediate_stop(bench: AdapterBench) -> None:
    """Give an Immediate Stop."""
    bench.put(*STOP)


def program_mode(bench: AdapterBench) -> None:
    """Let the PLC leave run mode."""
    bench.module.plc_run(False)


def emergency_stop(bench: AdapterBench) -> None:
    """Press the emergency stop, for so long that it is read."""
    bench.level(InputBit.ESTOP, True)


def emergency_stop_let_go(bench: AdapterBench) -> None:
    """Press the emergency stop, and let it go as soon as it has been read."""
    emergency_stop(bench)
    bench.run(100, until="IN_ESTOP")
    bench.level(InputBit.ESTOP, False)


STOPS = [immediate_stop, program_mode, emergency_stop, emergency_stop_let_go]
FAULTS = {"good": (0, 0), "one lost": (1, 0), "two damaged": (0, 2), "lost and damaged": (1, 1)}


@BOTH
@pytest.mark.parametrize("stop", STOPS)
def test_stopped_shows_once_the_motor_has_been_read_at_rest(
    make: type[AdapterBench], stop: Callable[[AdapterBench], None]
) -> None:
    check_stop(make, FAR, stop, "two damaged")


@pytest.mark.slow
@BOTH
@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("words", [FAR, JOG], ids=["move", "jog"])
@pytest.mark.parametrize("stop", STOPS)
def test_stopped_shows_once_the_motor_has_been_read_at_rest_whatever_the_line_does(
    make: type[AdapterBench], fault: str, words: tuple[int, ...], stop: Callable[[AdapterBench], None]
) -> None:
    check_stop(make, words, stop, fault)


def check_stop(
    make: type[AdapterBench], words: tuple[int, ...], stop: Callable[[AdapterBench], None], fault: str
) -> None:
    """Stop a motion while replies are lost and damaged."""
    bench = in_motion(make, words)
    faults = bench.module.controller.line.faults
    stop(bench)
    faults.drop_next, faults.corrupt_next = FAULTS[fault]
    bench.run(900, until="STOPPED")
    assert not bench.device.motor_turns
    assert bench.position == bench.motor
    assert {"STOPPED", "POSITION_INVALID"} <= bench.bits
    assert bench.bits.isdisjoint(MOVING)
    assert bench.lies == []


@BOTH
def test_the_motion_shows_until_then(make: type[AdapterBench]) -> None:
    bench = in_motion(make)
    bench.give(*STOP, ms=2)  # neither line can have answered
    assert bench.bits == {"MODULE_OK", "MOVING_CW", "POSITION_INVALID"}


@BOTH
@pytest.mark.parametrize("stop", STOPS[:2])
def test_without_a_link_nothing_claims_rest(
    make: type[AdapterBench], stop: Callable[[AdapterBench], None]
) -> None:
    bench = in_motion(make)
    line = bench.module.controller.line
    stop(bench)
    line.take_down()
    for _ in range(400):
        bench.run(2)
        assert bench.bits.isdisjoint({"STOPPED", "MOVE_COMPLETE", "AT_HOME", "HOLD_STATE"})
    assert bench.bits == {"POSITION_INVALID"}
    assert bench.device.motor_turns
    line.put_up()
    bench.run(3000, until="STOPPED")
    assert bench.bits == {"MODULE_OK", "POSITION_INVALID", "STOPPED"}
    assert (bench.position, bench.device.motor_turns) == (bench.motor, False)


@BOTH
def test_what_has_moved_by_itself_is_no_longer_said_to_rest(make: type[AdapterBench]) -> None:
    bench = make().configured(*CONFIGURE_006)
    bench.give(*SHORT, ms=600, until="MOVE_COMPLETE").release(100)
    if make is AdapterBench:
        bench.device.controller.pins.connect("jog_plus", GROUND)
        bench.device.controller.settle(bench.now_ns)
    else:
        controller = bench.device.controller
        controller.axis.position = BIAS + 5000  # as if another master had moved it
    bench.run(300)
    assert "POSITION_INVALID" in bench.bits
    assert "MOVE_COMPLETE" not in bench.bits


def test_a_search_that_was_never_begun_has_not_found_home() -> None:
    # code 3 in 4x1 is Home Type 1; its last byte is damaged on the way, twice
    bench = AdapterBench(Switch(InputBit.HOME, 3000, 3500)).configured()
    faults = bench.module.controller.line.faults
    start = bytes.fromhex("01 06 00 00 00 03")
    inner, lost = faults.device, [2]

    class Deaf(Device):
        """Loses the two requests that start the search."""

        line_format = inner.line_format
        heard = b""

        @property
        def next_wake_ns(self) -> int | None:
            return inner.next_wake_ns

        def receive(self, now_ns: int, data: bytes) -> None:
            self.heard = (self.heard + data)[-len(start) :]
            if self.heard == start and lost[0]:
                lost[0] -= 1
                data = b"\\xff"
            inner.receive(now_ns, data)

        def advance(self, now_ns: int) -> bytes:
            return inner.advance(now_ns)

    faults.device = Deaf()
    bench.give(32, 0, 0, 0, 5, 0, 20, 20, ms=1000)
    assert lost == [0]
    assert bench.motor == 0
    assert bench.bits == {"MODULE_OK", "HOME_INVALID", "INPUT_ERROR", "POSITION_INVALID"}


# ---- edges


@BOTH
@pytest.mark.parametrize("gap_scans", [1, 20])
@pytest.mark.parametrize("scan_ms", [2, *[pytest.param(ms, marks=pytest.mark.slow) for ms in (1, 5, 10)]])
def test_pulses_after_a_stop_act_in_their_order(
    make: type[AdapterBench], scan_ms: int, gap_scans: int
) -> None:
    bench = in_motion(make, scan_ms=scan_ms)
    bench.give(*STOP, ms=scan_ms)
    for words in (PRESET, SHORT):
        bench.release(gap_scans * scan_ms).give(*words, ms=scan_ms)
    bench.release(800)
    assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE"}
    assert bench.position == 100


@BOTH
def test_pulses_during_a_configuration_act_after_it(make: type[AdapterBench]) -> None:
    bench = make()
    bench.run(100)
    bench.give(*CONFIGURE_006, ms=10).release(4)
    bench.give(*PRESET, ms=2).release(4).give(*SHORT, ms=2).release(4)
    assert {"MODE_CONFIG", "CONFIG_ERROR"} <= bench.bits
    bench.release(1000)
    assert bench.bits == {"MODULE_OK", "MOVE_COMPLETE"}
    assert bench.position == bench.motor == 100


@BOTH
def test_a_single_step_is_made_before_the_next_command(make: type[AdapterBench]) -> None:
    bench = make().configured(*CONFIGURE_006)
    bench.give(128, ms=2).release(2).give(*PRESET, ms=2).release(500)
    assert (bench.motor, bench.position) == (1, 0)


@BOTH
def test_commands_that_wait_when_the_plc_leaves_run_mode_are_refused(make: type[AdapterBench]) -> None:
    bench = in_motion(make)
    bench.give(*STOP, ms=2).release(2).give(*SHORT, ms=2)
    bench.module.plc_run(False)
    at = bench.run(300).motor
    assert bench.bits == {"MODULE_OK", "STOPPED", "POSITION_INVALID", "COMMAND_ERROR"}
    assert bench.reasons == ["missed"]
    bench.module.plc_run(True)
    bench.release(300)
    assert bench.motor == at


def test_more_words_than_can_wait_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "WAITING_MAX", 5)
    bench = AdapterBench(scan_ms=1)
    bench.run(100)
    bench.give(*CONFIGURE_006, ms=10)
    for _ in range(5):
        bench.give(*PRESET, ms=1).release(1)
    bench.release(300)
    assert "COMMAND_ERROR" in bench.bits
    assert bench.reasons == ["missed"]


@BOTH
def test_after_a_loss_a_command_is_refused_until_all_bits_were_low(make: type[AdapterBench]) -> None:
    bench = in_motion(make)
    line = bench.module.controller.line
    line.take_down()
    bench.run(700)
    bench.give(*SHORT, ms=50)  # nobody hears it
    line.put_up()
    bench.run(800, until="MODULE_OK").run(100)
    assert bench.bits == {"MODULE_OK", "POSITION_INVALID", "STOPPED"}
    at = bench.motor
    bench.give(*PRESET, ms=2)
    assert bench.bits == {"MODULE_OK", "POSITION_INVALID", "STOPPED", "COMMAND_ERROR"}
    bench.release(20).give(*RESET, ms=20).release(20).give(*SHORT, ms=600)
    assert bench.bits == {"MODULE_OK", "POSITION_INVALID", "MOVE_COMPLETE"}
    assert bench.motor == at + 100


@BOTH
def test_a_configuration_that_came_without_the_link_is_the_one_in_force(make: type[AdapterBench]) -> None:
    bench = make().configured(*CONFIGURE_006)
    bench.give(*CONFIGURE_006, ms=500)
    line = bench.module.controller.line
    line.take_down()
    bench.run(700)
    slower = (*CONFIGURE_006[:2], 0, 500)
    bench.give(*slower, ms=50)
    line.put_up()
    bench.run(2500)
    assert list(bench.image)[2:4] == [0, 500]  # the starting speed of the mirror
    assert "CONFIG_ERROR" not in bench.bits


class SilentLine:
    """A real line on which nothing is heard."""

    def take_losses(self) -> list[str]:
        return []

    def next_event_ns(self) -> int | None:
        return None

    def take(self) -> bytes:
        return b""

    def send(self, data: bytes, line_format: LineFormat) -> None:
        """Send nothing."""


def test_on_a_real_port_words_act_however_close_two_scans_are(monkeypatch: pytest.MonkeyPatch) -> None:
    # after a scan that is late the next one may begin at once: within the 250 µs of a 3601's own scan
    kind = PCL601
    adapter: Any = LiveAdapter(cast(LiveLine, SilentLine()), kind, kind.options.of(None), 1)
    present_us = iter(range(10_000, 20_000, 40))
    monkeypatch.setattr(adapter._clock, "now_ns", lambda: 1000 * next(present_us))
    obeyed: list[int] = []
    monkeypatch.setattr(adapter, "_tick", lambda now_ns, outputs: obeyed.append(outputs[0]))
    for scan, word in enumerate((1, 2, 4, 8)):
        adapter.update(scan, Image((word,)))
    assert [word for at, word in enumerate(obeyed) if word not in obeyed[:at]] == [1, 2, 4, 8]
