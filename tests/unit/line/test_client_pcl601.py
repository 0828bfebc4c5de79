"""The PCL601 client against the simulated one: bad lines in virtual time, a pseudo-terminal, Modbus TCP."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from bench601 import PORT_TIMING
from faultyline import BusLink, Fault, FaultyDevice, dropped, served_on_pty
from modbus_standard import rtu
from pymodbus.pdu.register_message import WriteSingleRegisterRequest
from scanrack.commands import build
from scanrack.io_images.pcl601 import Code, Error
from scanrack.io_images.pcl601.registers import firmware_text
from scanrack.runtime import Clock, Contact
from scanrack.runtime.controllers.pcl601.line import Pcl601
from scanrack.runtime.controllers.pcl601.motor import EncoderModel
from scanrack.runtime.line.clients.link import (
    BadResponseError,
    NoAnswerError,
    RefusedError,
    SerialLink,
    StoppedError,
    UnconfirmedMotionError,
)
from scanrack.runtime.line.clients.modbus import RtuLine
from scanrack.runtime.line.clients.modbus_tcp import ModbusTcpLine
from scanrack.runtime.line.clients.pcl601 import READABLE, SETTABLE, Pcl601Client
from scanrack.runtime.line.clients.watching import MonitoringLostError
from scanrack.runtime.line.modbus_pdus import REQUESTS
from scanrack.runtime.line.ports import ModbusTcpPort, PduServer
from scanrack.runtime.machine.contacts import GROUND
from typer.testing import CliRunner, Result

GO = bytes.fromhex("06 00 00 00 01")


def client_of(
    device: Pcl601, answers: dict[int, Fault] | None = None, questions: dict[int, Fault] | None = None
) -> tuple[Pcl601Client, BusLink]:
    """Return a client of a controller, and its line."""
    link = BusLink(FaultyDevice(device, answers or {}), questions)
    return Pcl601Client(RtuLine(link), 1), link


def goes(link: BusLink) -> int:
    return sum(question[1:-2] == GO for question in link.questions)


def test_everything_that_can_be_read_is_read() -> None:
    client, _ = client_of(Pcl601())
    values = {name: client.read(name) for name in READABLE}
    assert values["base_speed"] == 500
    assert values["firmware"].to_bytes(4, "big") == b"1.00"
    assert (client.busy, client.errors, client.outputs) == (False, Error(0), 0)


def test_what_is_set_is_read_back() -> None:
    client, _ = client_of(Pcl601())
    for name, row in SETTABLE.items():
        if name != "address":
            client.set(name, row.high)
            client.set(name, row.low)
            assert client.read(name) == row.low
    client.set("position", -8_388_607)
    assert client.position == -8_388_607


def test_a_new_address_is_followed() -> None:
    client, _ = client_of(Pcl601())
    client.set("address", 33)
    assert (client.address, client.read("address")) == (33, 33)


def test_mistakes_are_told_before_anything_is_sent() -> None:
    client, link = client_of(Pcl601())
    for call, said in (
        (lambda: client.set("base_speed", 5001), "base_speed 5001: must be 1 to 5000"),
        (lambda: client.set("busy", 1), "busy can't be set; choose from steps, accel"),
        (lambda: client.read("nothing"), "nothing can't be read; choose from command, steps"),
        (lambda: client.start_move(0), "0 steps: must be 1 to 8388607"),
        (lambda: client.home(2), "home type 2: must be 0 or 1"),
        (lambda: client.set_output(9, True), "output 9: must be 1 to 8"),
        (lambda: Pcl601Client(RtuLine(link), 100), "unit 100: must be 1 to 99"),
    ):
        with pytest.raises(ValueError, match=said):
            call()
    assert link.questions == []


def test_a_move_with_progress() -> None:
    client, _ = client_of(Pcl601())
    seen: list[int] = []
    client.set("accel", 20_000)
    assert client.move(-3000, seen.append) == -3000
    assert seen == sorted(seen, reverse=True)
    assert len(seen) > 5
    assert client.faults == 0


def test_outputs_and_inputs() -> None:
    device = Pcl601()
    client, _ = client_of(device)
    client.set_output(3, True)
    client.set_output(4, True)
    client.set_output(4, False)
    assert (client.outputs, device.controller.outputs) == (0b100, 0b100)
    before = client.inputs
    device.controller.pins.connect("in2", GROUND)
    assert client.inputs == before ^ 0b10


def test_what_the_controller_refuses_is_told_with_its_reason() -> None:
    client, link = client_of(Pcl601())
    client.set("base_speed", 5000)
    client.set("max_speed", 5000)
    with pytest.raises(RefusedError, match="GO is refused; MOTOR: motion requested with base speed"):
        client.move(100)
    client.command(Code.CLEAR_ERRORS)
    assert client.errors == Error(0)
    client.set("base_speed", 500)
    client.start_move(100_000)
    with pytest.raises(RefusedError, match=r"exception 6: .* locked while the motor moves"):
        client.set("accel", 5000)
    with pytest.raises(RefusedError, match="a motion is already running"):
        client.command(Code.GO)
    client.stop()
    assert not client.busy
    assert goes(link) == 2


def test_a_move_that_a_limit_ends_is_told() -> None:
    device = Pcl601()
    device.controller.pins.connect("hard_plus", Contact(low=500))
    client, _ = client_of(device)
    with pytest.raises(StoppedError, match="the move ended at 500, not at 2000; a hard limit is active"):
        client.move(2000)


@pytest.mark.parametrize("kind", [0, 1])
def test_a_search_for_home_that_a_limit_ends_has_not_found_it(kind: int) -> None:
    device = Pcl601()
    device.controller.pins.connect("hard_plus", Contact(low=500))
    client, _ = client_of(device)
    with pytest.raises(StoppedError, match="ended at 500, not at home; a hard limit is active"):
        client.home(kind)


@pytest.mark.parametrize("kind", [0, 1])
def test_a_search_for_home_that_a_limit_keeps_from_starting_has_not_found_it(kind: int) -> None:
    device = Pcl601()
    device.controller.pins.connect("hard_plus", GROUND)
    client, _ = client_of(device)
    said = rf"HOME_TYPE_{kind} was answered, but no motion was seen: the position is still 0; a hard limit"
    with pytest.raises(UnconfirmedMotionError, match=said):
        client.home(kind)


@pytest.mark.parametrize("kind", [0, 1])
def test_a_search_for_home_that_ends_on_the_switch_is_done(kind: int) -> None:
    device = Pcl601()
    device.controller.pins.connect("home", Contact(low=300, high=2000))
    client, _ = client_of(device)
    # type 0 stops on the switch's first step, type 1 goes back to the first step without it
    assert client.home(kind) == (300 if kind == 0 else 299)


@pytest.mark.parametrize("already", [False, True])
def test_a_move_that_the_encoder_could_not_finish_is_told(already: bool) -> None:
    device = Pcl601(encoder=EncoderModel(1, "stuck"))
    client, _ = client_of(device)
    for name, value in (("encoder_autocorrect", 1), ("encoder_retries", 2), ("encoder_window", 3)):
        client.set(name, value)
    if already:  # the error of an earlier move is still set
        device.controller.errors |= Error.ENCODER_FAILED
    said = r"ended with the encoder -700 pulses off; its window is ±3; .*ENCODER_FAILED: still outside"
    with pytest.raises(StoppedError, match=said):
        client.move(700)
    assert client.position == 700


def test_a_move_within_the_encoder_s_window_is_done() -> None:
    device = Pcl601(encoder=EncoderModel(2))
    device.controller.errors |= Error.ENCODER_FAILED
    client, _ = client_of(device)
    for name, value in (("encoder_autocorrect", 1), ("encoder_window", 3), ("encoder_ratio", 2)):
        client.set(name, value)
    assert client.move(-700) == -700


@pytest.mark.parametrize("asked", [14, 40])
@pytest.mark.parametrize("home", [False, True])
def test_a_motion_that_can_no_longer_be_watched_is_stopped(asked: int, home: bool) -> None:
    device = Pcl601()
    client, link = client_of(device, questions=dropped(asked, 3))
    with pytest.raises(
        MonitoringLostError, match=r"does not answer within 0\.2 s; the motor was stopped"
    ) as lost:
        client.home(0) if home else client.move(1_000_000)
    assert lost.value.stopped
    stop, *looks = link.questions[-5:]  # Stop Motion, a look, and three more for the answers that may be late
    assert stop[1:-2] == bytes.fromhex("06 00 00 00 05")
    assert {look[1] for look in looks} == {0x03}
    assert not device.controller.axis.busy


def test_a_motion_that_can_neither_be_watched_nor_stopped_may_go_on() -> None:
    device = Pcl601()
    client, _ = client_of(device, questions=dropped(14, 1000))
    with pytest.raises(
        MonitoringLostError, match="a stop was not confirmed: THE MOTOR MAY STILL BE MOVING"
    ) as lost:
        client.move(1_000_000)
    assert not lost.value.stopped
    assert device.controller.axis.busy


def test_a_line_that_dies_right_after_the_start_is_stopped() -> None:
    device = Pcl601()
    client, link = client_of(device)
    client.start_move(5)
    client.wait()
    at_go = next(number for number, question in enumerate(link.questions) if question[1:-2] == GO)
    device = Pcl601()
    client, link = client_of(device, answers=dropped(at_go, 4))  # of Go, and of three looks whether it moves
    with pytest.raises(MonitoringLostError, match="the motor was stopped"):
        client.start_move(1_000_000)
    assert goes(link) == 1
    assert not device.controller.axis.busy


def test_an_answer_may_take_longer() -> None:
    faulty = FaultyDevice(Pcl601(), {0: Fault.DELAYED, 1: Fault.DELAYED})  # 0.26 s
    client = Pcl601Client(RtuLine(BusLink(faulty), 0.4))
    assert (client.position, client.position, client.faults) == (0, 0, 0)
    with pytest.raises(ValueError, match=r"timeout 61 s: must be 0\.01 to 60"):
        RtuLine(BusLink(faulty), 61)


def test_the_firmware_is_text() -> None:
    client, _ = client_of(Pcl601())
    assert client.firmware == "1.00"  # Appendix 6


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0x31303030, "1000"),
        (0x322E3100, "2.1"),
        (0x01020304, "01020304h"),
        (0, "00000000h"),
        (0xFFFE3030, "FFFE3030h"),
    ],
)
def test_a_firmware_that_is_no_text_is_a_number(value: int, text: str) -> None:
    assert firmware_text(value) == text


@pytest.mark.slow
@pytest.mark.parametrize("fault", Fault)
@pytest.mark.parametrize("at", range(11))
@pytest.mark.parametrize("question", [False, True])
def test_one_bad_frame_never_repeats_a_motion_nor_spoils_it(fault: Fault, at: int, question: bool) -> None:
    device = Pcl601()
    plans = ({}, {at: fault}) if question else ({at: fault}, {})
    client, link = client_of(device, *plans)
    try:
        assert client.move(700) == 700
    except UnconfirmedMotionError:
        assert device.controller.motor.position == 0  # the question itself was lost
        assert question
    assert goes(link) == 1
    assert device.controller.motor.position in (0, 700)
    assert client.position == device.controller.motor.position


def test_a_go_doubled_on_a_port_that_keeps_no_gaps_counts_as_taken() -> None:
    device = Pcl601(timing=PORT_TIMING)
    for at in range(6, 11):
        client, link = client_of(device, questions={at: Fault.DOUBLED})
        before = client.position
        assert client.move(700) == before + 700
        assert goes(link) == 1


@pytest.mark.parametrize("fault", Fault)
@pytest.mark.parametrize("at", range(3))
def test_no_answer_is_taken_for_that_to_another_question(fault: Fault, at: int) -> None:
    names = ["base_speed", "max_speed", "jog_speed", "address", "motor_current", "encoder_ratio"] * 3
    expected = [READABLE[name].default for name in names]
    client, _ = client_of(Pcl601(), {at: fault, at + 5: fault})
    assert [client.read(name) for name in names] == expected


def test_a_line_that_is_dead_is_told() -> None:
    client, link = client_of(Pcl601(), dict.fromkeys(range(10), Fault.DROPPED))
    with pytest.raises(NoAnswerError, match=r"unit 1 does not answer within 0\.2 s"):
        client.read("position")
    assert len(link.questions) == client.faults == 3


@pytest.mark.parametrize(
    ("question", "answer"),
    [
        ("03 00 0c 00 02", "04 04 00 00 00 01"),  # another function
        ("03 00 0c 00 02", "03 02 00 01"),  # another count
        ("03 00 0c 00 02", "03 03 00 00 00 01"),  # a count that is not so
        ("06 00 00 00 01", "06 00 00 00 02"),  # another value
        ("06 00 00 00 01", "06 00 01 00 01"),  # another register
        ("10 00 01 00 02 04 00 00 00 01", "10 00 01 00 01"),  # another quantity
        ("05 00 02 ff 00", "05 00 03 ff 00"),  # another output
        ("06 00 00 00 01", "90 03"),  # the exception of another function
    ],
)
def test_what_cannot_be_the_answer_is_not_taken_for_it(question: str, answer: str) -> None:
    request = REQUESTS.decode(bytes.fromhex(question))
    assert request is not None
    with pytest.raises(BadResponseError):
        RtuLine(SaidLink(rtu(1, bytes.fromhex(answer)))).ask(1, request)


class SaidLink(BusLink):
    """A line on which one answer comes, whatever is asked."""

    def __init__(self, said: bytes) -> None:
        super().__init__(FaultyDevice(Pcl601(), {}))
        self._said = b""
        self._next = said

    def send(self, data: bytes) -> None:
        self._said = self._next

    def receive(self, count: int, seconds: float) -> bytes:
        came, self._said = self._said[:count], self._said[count:]
        return came


@pytest.mark.slow
def test_end_to_end_through_a_pseudo_terminal_with_every_fault() -> None:
    device = Pcl601(timing=PORT_TIMING)
    plan = dict(zip((5, 11, 17, 23), Fault, strict=True))
    with served_on_pty(FaultyDevice(device, plan)) as path:
        link = SerialLink(path, device.line_format)
        client = Pcl601Client(RtuLine(link), 1)
        client.set("accel", 50_000)
        client.set("max_speed", 20_000)
        assert client.move(2000) == 2000
        assert client.move(-500) == 1500
        assert client.read("jog_speed") == 5000
        link.close()
    assert client.faults >= 3


@contextmanager
def served_on_modbus_tcp(device: Pcl601) -> Iterator[int]:
    port = ModbusTcpPort("127.0.0.1", 0)
    server = PduServer(device, lambda _unit, pdu: device.answer(pdu), port, Clock())
    ended = threading.Event()

    def serve() -> None:
        while not ended.is_set():
            server.step(0.01)

    thread = threading.Thread(target=serve)
    thread.start()
    try:
        yield int(port.name.rpartition(":")[2])
    finally:
        ended.set()
        thread.join()
        server.close()


def test_end_to_end_over_modbus_tcp() -> None:
    with served_on_modbus_tcp(Pcl601()) as port:
        line = ModbusTcpLine("127.0.0.1", port)
        client = Pcl601Client(line, 1)
        client.set("accel", 50_000)
        assert client.move(500) == 500
        with pytest.raises(RefusedError, match="exception 2"):
            client._exchange(WriteSingleRegisterRequest(address=0x22, registers=[1]))
        line.close()


def scanrack(*arguments: str) -> Result:
    return CliRunner().invoke(build(), arguments)


@pytest.mark.slow
def test_the_commands_over_modbus_tcp_and_a_pseudo_terminal() -> None:
    device = Pcl601(timing=PORT_TIMING)
    with served_on_modbus_tcp(device) as port:
        at = "device", "pcl601", "--tcp", f"127.0.0.1:{port}"
        assert scanrack(*at, "set", "accel", "90000").exit_code == 0
        assert scanrack(*at, "move", "--speed", "9000", "300").output == "300\n"
        assert scanrack(*at, "read", "max_speed").output == "9000\n"
        shown = scanrack(*at, "status").output
        assert "9,000  (Maximum Speed, steps/s)" in shown
        assert "1.00" in shown
        assert scanrack(*at, "--timeout", "1.5", "read", "firmware").output == "1.00\n"
        refused = scanrack(*at, "--timeout", "0", "status")
        assert (refused.exit_code, "timeout 0 s: must be" in refused.output) == (2, True)
        outcomes = [scanrack(*at, "output", "2", flag).exit_code for flag in ("--on", "--off", "--on")]
        assert outcomes == [0, 0, 0]
        assert device.controller.outputs == 0b10
    with served_on_pty(device) as path:
        at = "device", "pcl601", "--serial", path
        assert scanrack(*at, "move", "--", "-100").output == "200\n"
        refused = scanrack(*at, "program", "run")
        assert refused.exit_code == 1
        assert "scanrack: RUN_PROGRAM is refused; MEMORY_COMMAND" in refused.output
        assert [scanrack(*at, name).exit_code for name in ("clear", "stop")] == [0, 0]
        assert device.controller.errors == Error(0)


def test_commands_that_cannot_work_say_so(tmp_path: Path) -> None:
    assert "give one of --serial DEVICE and --tcp HOST:PORT" in scanrack("device", "pcl601", "status").output
    nobody = scanrack("device", "pcl601", "--tcp", "127.0.0.1:1", "status")
    assert (nobody.exit_code, "127.0.0.1:1 can't be reached" in nobody.output) == (1, True)
    program = tmp_path / "home.pclt"
    program.write_text("END\n", encoding="utf-8")
    written = scanrack("device", "pcl601", "program", "write", str(program))
    assert (written.exit_code, "is not documented" in written.output) == (2, True)
