"""The PMC006 client against the simulated one, on a bad line in virtual time and on a pseudo-terminal."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from faultyline import BusLink, Fault, FaultyDevice, dropped, served_on_pty
from scanrack.commands import build
from scanrack.io_images.pmc006.instructions import BY_CODE, BY_NAME, Kind
from scanrack.io_images.pmc006.status import Status1, Status2
from scanrack.runtime import Contact
from scanrack.runtime.controllers.pmc006.controller import Pmc006Controller
from scanrack.runtime.controllers.pmc006.line import Pmc006
from scanrack.runtime.controllers.pmc006.pins import Pin
from scanrack.runtime.line.clients.link import (
    BadResponseError,
    NoAnswerError,
    RefusedError,
    SerialLink,
    StoppedError,
    UnconfirmedMotionError,
)
from scanrack.runtime.line.clients.pmc006 import BY_ZERO, SETTABLE, Pmc006Client
from scanrack.runtime.line.clients.watching import MonitoringLostError
from scanrack.runtime.line.pmc006_frames import LINE_FORMAT
from typer.testing import CliRunner, Result

STEP = 0x73


def client_of(
    controller: Pmc006Controller,
    answers: dict[int, Fault] | None = None,
    questions: dict[int, Fault] | None = None,
) -> tuple[Pmc006Client, BusLink]:
    """Return a client of a controller, and its line."""
    link = BusLink(FaultyDevice(Pmc006(controller), answers or {}), questions)
    return Pmc006Client(link, controller.address), link


def steps_sent(link: BusLink) -> int:
    return sum(question[2] == STEP for question in link.questions)


def test_everything_that_can_be_read_is_read() -> None:
    client, link = client_of(Pmc006Controller(address=9))
    values = {name: client.read(name) for name in client.readable}
    assert values["device_address"] == 9
    assert values["microstepping"] == 16
    assert values["status2"] == Status2.DIR
    assert {BY_CODE[question[2]].kind for question in link.questions} == {Kind.READ}


def test_a_setting_instruction_with_data_0_is_sent_on_request_only() -> None:
    client, link = client_of(Pmc006Controller())
    for name in BY_ZERO:
        with pytest.raises(ValueError, match=rf"{name} has no read instruction.* \[4\.1\.1\]"):
            client.read(name)
    assert link.questions == []
    asking = Pmc006Client(link, by_zero=True)
    values = {name: asking.read(name) for name in BY_ZERO}
    assert values == {name: BY_NAME[name].default for name in BY_ZERO}
    assert {BY_CODE[question[2]].name for question in link.questions} == set(BY_ZERO)


def test_the_address_is_never_set_to_0_nor_asked_for_so() -> None:
    client, link = client_of(Pmc006Controller(address=9), questions={0: Fault.DROPPED})
    with pytest.raises(NoAnswerError):
        client.set("device_address", 33)
    assert client.address == client.read("device_address") == 9
    sent = [int.from_bytes(question[3:7], "little") for question in link.questions if question[2] == ord("w")]
    assert sent == [33]


def test_what_is_set_is_read_back() -> None:
    controller = Pmc006Controller(address=9)
    client, _ = client_of(controller)
    for name, row in SETTABLE.items():
        value = row.values[-1] if row.values else row.high
        assert value is not None
        if name != "device_address":
            client.set(name, value)
            assert name == "set_position" or controller.memory[name] == value
    assert client.position == 0x7FFFFFFF


def test_a_new_address_is_followed() -> None:
    controller = Pmc006Controller(address=9)
    client, _ = client_of(controller)
    client.set("device_address", 33)
    client.save()
    assert (client.address, client.read("device_address")) == (33, 33)
    controller.power_cycle()
    assert client.read("microstepping") == 16


@pytest.mark.parametrize("fault", Fault)
def test_a_new_address_is_followed_even_if_that_exchange_fails(fault: Fault) -> None:
    either_way: list[tuple[dict[int, Fault], dict[int, Fault]]] = [({0: fault}, {}), ({}, {0: fault})]
    for plans in either_way:
        controller = Pmc006Controller(address=9)
        client, _ = client_of(controller, *plans)
        try:
            client.set("device_address", 33)
        except NoAnswerError:
            assert controller.address == 9
        assert client.address == client.read("device_address") == controller.address


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("start_speed", 64, "start_speed 64: must be 65 to 30000"),
        ("microstepping", 3, "microstepping 3: must be 0, 2, 4"),
        ("nothing", 3, "nothing can't be set; choose from accel_coefficient"),
    ],
)
def test_mistakes_are_told_before_anything_is_sent(name: str, value: int, said: str) -> None:
    client, link = client_of(Pmc006Controller())
    with pytest.raises(ValueError, match=said):
        client.set(name, value)
    with pytest.raises(ValueError, match="accel_coefficient can't be read; choose from"):
        client.read("accel_coefficient")
    with pytest.raises(ValueError, match="0 steps: must be 1"):
        client.start_move(0)
    with pytest.raises(ValueError, match="not an action that may be repeated"):
        client.do("step", 5)
    assert link.questions == []


def test_a_move_with_progress() -> None:
    client, _ = client_of(Pmc006Controller())
    seen: list[int] = []
    assert client.move(-3000, seen.append) == -3000
    assert seen == sorted(seen, reverse=True)
    assert len(seen) > 5
    assert client.faults == 0


def test_six_and_seven_are_values_where_they_were_set() -> None:
    client, _ = client_of(Pmc006Controller())
    client.set("decel_coefficient", 6)
    client.set("accel_coefficient", 7)


def test_a_refusal_is_told() -> None:
    controller = Pmc006Controller()
    client, _ = client_of(controller)
    client.set("free_run", 1)
    message = "step is refused with error 6: wrong state, or value out of range"
    with pytest.raises(RefusedError, match=message):
        client.move(100)
    client.set("free_run", 0)
    controller.set_pin(Pin.EXT2, False)
    client.set("ext_stop_enable", 2)
    with pytest.raises(RefusedError, match=r"error 7: .* limit in this direction is active"):
        client.move(100)


def test_a_move_that_ends_early_says_why() -> None:
    controller = Pmc006Controller()
    controller.set_pin(Pin.EXT2, Contact(low=500))
    client, _ = client_of(controller)
    client.set("ext_stop_enable", 2)
    with pytest.raises(StoppedError, match="ended at 500, not at 2000: EXT2"):
        client.move(2000)
    assert client.status1 == Status1.EXT2


def test_home_finds_the_switch_or_says_that_it_did_not() -> None:
    controller = Pmc006Controller()
    controller.set_pin(Pin.EXT1, Contact(high=-301))
    client, _ = client_of(controller)
    client.set("zero_back_speed", 2000)
    assert client.home(1000) == 0
    assert controller.axis.physical == -301
    client.move(2000)
    with pytest.raises(StoppedError, match="zero-back ended at 1000 without the switch"):
        client.home(1000)


@pytest.mark.parametrize("start", [0, -500, -1054])
def test_a_switch_that_is_stuck_is_not_home(start: int) -> None:
    controller = Pmc006Controller()
    controller.set_pin(Pin.EXT1, False)
    controller.axis.position = start
    client, _ = client_of(controller)
    # 17 retreats of 1000 // 16 steps: the stroke is used up within the last one
    end = start + 17 * 62
    with pytest.raises(StoppedError, match=f"zero-back ended at {end} with the switch active all the time"):
        client.home(1000)


@pytest.mark.parametrize("start", [0, 5000, -5000])
def test_home_from_on_the_switch(start: int) -> None:
    controller = Pmc006Controller()
    controller.axis.position = start
    controller.set_pin(Pin.EXT1, Contact(high=100))
    client, _ = client_of(controller)
    assert client.home(4000) == 0  # a retreat of 250, back to 100
    assert controller.axis.physical == 100


def test_home_ended_by_the_other_stop_is_not_home() -> None:
    controller = Pmc006Controller()
    controller.set_pin(Pin.EXT1, Contact(high=100))
    controller.set_pin(Pin.EXT2, Contact(low=51))
    client, _ = client_of(controller)
    client.set("ext_stop_enable", 2)
    with pytest.raises(StoppedError, match="zero-back ended at 51 without the switch: EXT2"):
        client.home(4000)


def test_a_stall_on_the_last_step_is_no_success() -> None:
    controller = Pmc006Controller()
    client, _ = client_of(controller)

    def stall_at_the_end(position: int) -> None:
        if position == 700:
            controller.axis.stalled = True

    with pytest.raises(StoppedError, match="the move ended at 700 with an error: STALL"):
        client.move(700, stall_at_the_end)


@pytest.mark.parametrize("seen", ["before the start", "at the first look"])
def test_a_stall_in_the_status_at_the_end_is_no_success(seen: str) -> None:
    """As for `home`: the manual does not say when a controller clears the bit [status register 1, bit 4]."""
    controller = Pmc006Controller()
    client, _ = client_of(controller)
    controller.axis.stalled = seen == "before the start"
    begin = controller.axis._begin

    def begins(*motion: Any) -> None:
        begin(*motion)
        controller.axis.stalled = True

    controller.axis._begin = begins  # type: ignore[method-assign, assignment]
    with pytest.raises(StoppedError, match="the move ended at 700 with an error: STALL"):
        client.move(700)


@pytest.mark.parametrize("asked", [14, 40])
@pytest.mark.parametrize("home", [False, True])
def test_a_motion_that_can_no_longer_be_watched_is_stopped(asked: int, home: bool) -> None:
    controller = Pmc006Controller()
    client, link = client_of(controller, questions=dropped(asked, 3))
    with pytest.raises(
        MonitoringLostError, match=r"does not answer within 0\.2 s; the motor was stopped"
    ) as lost:
        client.home(100_000) if home else client.move(100_000)
    assert lost.value.stopped
    # a stop, a look, and three more for the answers that may be late
    assert "".join(chr(question[2]) for question in link.questions[-9:]) == "Ijcjcjcjc"
    assert not controller.axis.moving


def test_a_motion_that_can_neither_be_watched_nor_stopped_may_go_on() -> None:
    controller = Pmc006Controller()
    client, link = client_of(controller, questions=dropped(14, 1000))
    with pytest.raises(
        MonitoringLostError, match="a stop was not confirmed: THE MOTOR MAY STILL BE MOVING"
    ) as lost:
        client.move(100_000)
    assert not lost.value.stopped
    assert [question[2] for question in link.questions[-3:]] == [ord("I")] * 3
    assert controller.axis.moving


def test_a_line_that_dies_right_after_the_start_is_stopped() -> None:
    controller = Pmc006Controller()
    # direction, status 1, position, step; its answer and three status 1 are lost
    client, _ = client_of(controller, answers=dropped(3, 4))
    with pytest.raises(MonitoringLostError, match="the motor was stopped"):
        client.move(100_000)
    assert not controller.axis.moving


def test_an_answer_may_take_longer() -> None:
    faulty = FaultyDevice(Pmc006(Pmc006Controller()), {0: Fault.DELAYED, 1: Fault.DELAYED})  # 0.26 s
    client = Pmc006Client(BusLink(faulty), answer_s=0.4)
    assert (client.position, client.position, client.faults) == (0, 0, 0)
    with pytest.raises(ValueError, match=r"timeout 0 s: must be 0\.01 to 60"):
        Pmc006Client(BusLink(faulty), answer_s=0)


def test_the_firmware_is_text() -> None:
    client, _ = client_of(Pmc006Controller())
    assert client.firmware == "V0.1.0 (00010000h)"  # readings.md: 00010000h for V0.1.0


def test_speed_mode_and_its_ways_out() -> None:
    client, link = client_of(Pmc006Controller())
    client.run()
    with pytest.raises(RefusedError, match="a motion is already running"):
        client.move(5)
    client.slow_down()
    link.pause(1)
    assert not client.status1
    client.run()
    client.stop()
    assert not client.status1


@pytest.mark.parametrize("fault", Fault)
@pytest.mark.parametrize("at", range(8))
@pytest.mark.parametrize("question", [False, True])
def test_one_bad_frame_never_repeats_a_motion_nor_spoils_a_result(
    fault: Fault, at: int, question: bool
) -> None:
    controller = Pmc006Controller()
    plans = ({}, {at: fault}) if question else ({at: fault}, {})
    client, link = client_of(controller, *plans)
    try:
        assert client.move(700) == 700
    except UnconfirmedMotionError:
        assert controller.axis.physical == 0  # the question itself was lost
        assert question
    assert steps_sent(link) == 1
    assert controller.axis.physical in (0, 700)
    assert client.position == controller.axis.position


def test_a_step_doubled_on_the_line_whose_first_answer_is_lost_counts_as_taken() -> None:
    controller = Pmc006Controller()
    # questions: direction, status 1, position, step; the second answer to it is the refusal
    client, link = client_of(controller, {3: Fault.DROPPED}, {3: Fault.DOUBLED})
    assert client.move(700) == controller.axis.physical == 700
    assert link.questions[3][2] == STEP


@pytest.mark.parametrize("fault", Fault)
@pytest.mark.parametrize("delay_ms", range(150, 480, 7))
def test_no_answer_is_taken_for_that_to_another_question(fault: Fault, delay_ms: int) -> None:
    controller = Pmc006Controller(address=9)
    names = ["start_speed", "stop_speed", "max_speed", "zero_back_speed", "peak_current", "encoder_cpr"] * 3
    for name, value in zip(names[:6], (701, 702, 703, 704, 705, 800), strict=True):
        controller.memory[name] = value
    faulty = FaultyDevice(Pmc006(controller), {1: fault, 6: fault}, delay_ms * 1_000_000)
    client = Pmc006Client(BusLink(faulty), 9, by_zero=True)
    assert [client.read(name) for name in names] == [controller.memory[name] for name in names]


def test_a_line_that_is_dead_is_told() -> None:
    client, link = client_of(Pmc006Controller(), dict.fromkeys(range(10), Fault.DROPPED))
    with pytest.raises(NoAnswerError, match=r"address 255 does not answer within 0\.2 s"):
        client.read("position")
    assert len(link.questions) == 3


def test_another_unit_s_answer_is_told() -> None:
    link = BusLink(Pmc006(Pmc006Controller(address=9)))
    client = Pmc006Client(link, 9)
    client.read("position")
    link.bus.devices[0].controller.memory["device_address"] = 8  # type: ignore[attr-defined]
    with pytest.raises(NoAnswerError):
        client.read("position")
    assert client.faults == 3
    damaged, _ = client_of(Pmc006Controller(address=9), dict.fromkeys(range(10), Fault.DAMAGED))
    with pytest.raises(BadResponseError, match="a damaged answer from address 9: a5 7a 09 10"):
        damaged.read("position")


@pytest.mark.slow
def test_end_to_end_through_a_pseudo_terminal_with_every_fault() -> None:
    controller = Pmc006Controller(address=9)
    plan = dict(zip((3, 9, 15, 21), Fault, strict=True))
    with served_on_pty(FaultyDevice(Pmc006(controller), plan)) as path:
        link = SerialLink(path, LINE_FORMAT)
        client = Pmc006Client(link, 9)
        client.set("max_speed", 20_000)
        assert client.move(2000) == 2000
        assert client.move(-500) == 1500
        for name in ("microstepping", "device_address", "user_data", "decel_coefficient"):
            assert client.read(name) == controller.memory[name]
        link.close()
    assert client.faults >= 3


def scanrack(*arguments: str) -> Result:
    return CliRunner().invoke(build(), [*map(str, arguments)])


@pytest.mark.slow
def test_the_commands_through_a_pseudo_terminal(tmp_path: Path) -> None:
    controller = Pmc006Controller(address=9)
    controller.set_pin(Pin.EXT1, Contact(high=-101))
    with served_on_pty(Pmc006(controller)) as path:
        at = "device", "pmc006", "--serial", path, "--address", "9"
        assert scanrack(*at, "set", "zero_back_speed", "5000").exit_code == 0
        assert scanrack(*at, "move", "--speed", "9000", "300").output == "300\n"
        assert scanrack(*at, "home", "--stroke", "2000").output == "0\n"
        asked = scanrack(*at, "read", "max_speed")
        assert asked.exit_code == 2
        assert "max_speed has no read instruction" in asked.output
        assert scanrack(*at, "--by-zero", "read", "max_speed").output == "9000\n"
        shown = scanrack(*at, "status").output
        assert "max_speed" not in shown
        assert "DIR" in shown
        assert "V0.1.0 (00010000h)" in shown
        assert "9,000 steps/s" in scanrack(*at, "--by-zero", "status").output
        refused = scanrack(*at, "set", "start_speed", "12")
        assert (refused.exit_code, refused.output) == (
            2,
            "scanrack: start_speed 12: must be 65 to 30000\n",
        )
        controller.memory["free_run"] = 1
        refused = scanrack(*at, "move", "5")
        assert refused.exit_code == 1
        assert refused.output.startswith("scanrack: step is refused with error 6")
        assert [scanrack(*at, name).exit_code for name in ("stop", "clear", "save")] == [0, 0, 0]


def test_commands_that_cannot_work_say_so(tmp_path: Path) -> None:
    nowhere = scanrack("device", "pmc006", "--serial", str(tmp_path / "tty"), "status")
    assert nowhere.exit_code == 1
    assert "tty can't be opened: No such file or directory" in nowhere.output
    assert "give one of --serial DEVICE and --tcp HOST:PORT" in scanrack("device", "pmc006", "status").output
    nobody = scanrack("device", "pmc006", "--tcp", "127.0.0.1:1", "status")
    assert (nobody.exit_code, "127.0.0.1:1 can't be reached" in nobody.output) == (1, True)
    listing = tmp_path / "loop.pmc"
    listing.write_text("ROT 0 100\nWAIT 1 1\nJMP 0 77\n", encoding="utf-8")
    checked = scanrack("device", "pmc006", "program", "check", str(listing))
    assert "  0  ROT 0 100\n  1  WAIT 1 1\n" in checked.output
    assert "line 3: JMP 0 77: the manual's table has 0 to 50 only" in checked.output
    written = scanrack("device", "pmc006", "program", "write", str(listing))
    assert (written.exit_code, "are not documented" in written.output) == (2, True)
    listing.write_text("ROT 0 0\n", encoding="utf-8")
    assert (
        "loop.pmc: line 1: ROT data 0"
        in scanrack("device", "pmc006", "program", "check", str(listing)).output
    )
