"""`scanrack serve`: a controller in a process of its own, found by what it prints, ended by Ctrl-C."""

from __future__ import annotations

import json
import os
import re
import select
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path

import forked
import pytest
from mcap.reader import make_reader
from scanrack.commands import build
from scanrack.io_images.pmc006.frame import command, reply
from scanrack.io_images.pmc006.instructions import BY_NAME
from scanrack.jobs.run.served_units import pcl601_units, pmc006_units
from scanrack.jobs.serve.control import ControlChannel
from scanrack.jobs.serve.line import ServedLine, answering, begin, wire
from scanrack.runtime import Clock
from scanrack.runtime.controllers.pmc006.pins import Pin
from scanrack.runtime.line.ports.textlines import EndOfTalkError
from scanrack.runtime.line.rtu import frame
from scanrack.traces import open_trace
from typer.testing import CliRunner

READ_POSITION = BY_NAME["read_position"].code


@contextmanager
def serving(*arguments: str) -> Iterator[str]:
    """Serve; yield where. It is ended by the signal of Ctrl-C, and has to end without a word."""
    words = [sys.executable, "-m", "scanrack", "serve", *arguments]
    process = forked.start(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, encoding="utf-8")
    try:
        assert process.stdout is not None
        yield process.stdout.readline().split("  ")[0]
        process.send_signal(signal.SIGINT)
        assert process.communicate(timeout=120) == ("", "")
        assert process.returncode == 130
    finally:
        process.kill()
        process.communicate()


@contextmanager
def serving_with_control(*arguments: str) -> Iterator[tuple[str, str, str]]:
    """Serve with a control channel; yield where both are, and its key."""
    words = [sys.executable, "-m", "scanrack", "serve", *arguments, "--test-port", "0"]
    process = forked.start(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, encoding="utf-8")
    try:
        assert process.stdout is not None
        line = process.stdout.readline()
        control, key = line.split("control at ")[1].split("; key ")
        yield line.split("  ")[0], control, key.split(";")[0]
    finally:
        process.kill()
        process.communicate()


def read(terminal: int, count: int) -> bytes:
    data = b""
    while len(data) < count and select.select([terminal], [], [], 120)[0]:
        data += os.read(terminal, count)
    return data


def test_a_pmc006_answers_on_a_pseudo_terminal_and_ends_by_ctrl_c() -> None:
    """The position at first is 0; the address as from the factory is 255."""
    with serving("pmc006", "--pty") as path:
        terminal = os.open(path, os.O_RDWR | os.O_NOCTTY)
        os.write(terminal, command(255, READ_POSITION))
        assert read(terminal, 8) == reply(255, 0)
        os.close(terminal)


def test_a_pmc006_answers_over_tcp_on_the_loopback_address() -> None:
    with serving("pmc006", "--tcp", "0", "--address", "7") as place:
        host, port = place.split(":")
        with socket.create_connection((host, int(port)), timeout=120) as client:
            client.sendall(command(7, READ_POSITION))
            assert client.recv(8) == reply(7, 0)
    assert host == "127.0.0.1"


def test_a_3601_is_remote_io_over_modbus_tcp(tmp_path: Path) -> None:
    """Words written are read back, a torn write is refused and counted, and the recording has both."""
    trace = tmp_path / "t.mcap"
    words = [
        sys.executable,
        "-m",
        "scanrack",
        "serve",
        "amci3601",
        "--tcp",
        "0",
        "--whole-writes",
        "--silence",
        "5000",
    ]
    process = forked.start(
        [*words, "--record", str(trace)], stdout=subprocess.PIPE, text=True, encoding="utf-8"
    )
    try:
        assert process.stdout is not None
        said = process.stdout.readline()
        assert "  amci3601 in slot 1 of a rack of its own, exchanged every 2 ms; Ctrl-C ends" in said
        with connected(said.split("  ")[0]) as client:
            asked = "0007 0000 001b 01 17 0000 0008 0000 0008 10" + 8 * "0102"
            client.sendall(bytes.fromhex(asked))
            assert client.recv(100) == bytes.fromhex("0007 0000 0013 01 17 10" + 8 * "0102")
            client.sendall(bytes.fromhex("0008 0000 0006 01 06 0000 0001"))
            assert client.recv(100) == bytes.fromhex("0008 0000 0003 01 86 02")
            age_ms = 0
            while age_ms < 10:  # five scans later
                client.sendall(bytes.fromhex("0009 0000 0006 01 04 000a 0001"))
                age_ms = client.recv(100)[10]
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=120)
        assert process.returncode == 130
    finally:
        process.kill()
        process.communicate()
    with open_trace(trace) as recorded:
        assert {tuple(scan.outputs(1).words) for scan in recorded.scans()} == {(0,) * 8, (0x102,) * 8}


@contextmanager
def connected(place: str) -> Iterator[socket.socket]:
    host, port = place.rsplit(":", 1)
    with socket.create_connection((host, int(port)), timeout=120) as client:
        yield client


def test_a_test_sets_faults_and_inputs_by_the_control_channel() -> None:
    """The reply of the silent unit is exception 0Bh; the answer of the one that is back has register 4x6."""
    read_one = bytes.fromhex("0001 0000 0006 01 03 0005 0001")
    options = ("--tcp", "0", "--line-time", "--gateway-ms", "50")
    with (
        serving_with_control("pcl601", *options) as (place, control, key),
        connected(place) as client,
        connected(control) as test,
        test.makefile("rw", encoding="utf-8") as lines,
    ):

        def told(**order: object) -> dict[str, object]:
            print(json.dumps(order), file=lines, flush=True)
            return dict(json.loads(lines.readline()))

        assert told(key=key) == {"ok": True}
        assert told(fault="silence=on") == {"ok": True}
        client.sendall(read_one)
        assert client.recv(100).hex(" ") == "00 01 00 00 00 03 01 83 0b"
        assert told(fault="1:silence=off") == {"ok": True}
        client.sendall(read_one)
        assert client.recv(100).hex(" ") == "00 01 00 00 00 05 01 03 02 01 f4"
        assert told(pin="in3=ground") == {"ok": True}
        state = told(state=1)["state"]
        assert isinstance(state, dict)
        assert (state["inputs"], state["base_speed"]) == (0b100, 500)
        refused = told(fault="2:reset")["error"]
        assert refused == "'2:reset' is not a fault of a unit: must be FAULT, or ADDRESS:FAULT"


@pytest.fixture
def channel() -> Iterator[ControlChannel]:
    with closing(ControlChannel(ServedLine(pcl601_units([], [], 1.0)), Clock(), 0)) as made:
        yield made


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('{"fault": 1}', 'must be {"fault": TEXT}'),
        ('{"fault": "reset", "pin": "in1=high"}', 'must be {"fault": TEXT}'),
        ('{"state": 9}', "no unit at address 9; addresses: 1"),
        ('{"pin": "in9=high"}', "no input in9"),
    ],
)
def test_orders_that_the_control_channel_refuses(channel: ControlChannel, text: str, said: str) -> None:
    assert said in json.loads(channel.answer(text, is_admitted=True))["error"]


@pytest.mark.parametrize("known", [True, False])
@pytest.mark.parametrize("text", ["drop", "[[", "POST / HTTP/1.1"])
def test_a_line_that_is_not_json_ends_the_control_channel(
    channel: ControlChannel, text: str, known: bool
) -> None:
    with pytest.raises(EndOfTalkError, match="this is not JSON"):
        channel.answer(text, known)


@pytest.mark.parametrize("text", ['{"pin": "in3=ground"}', '{"key": ""}', '{"key": 1}', '{"key": "é"}', "7"])
def test_the_control_channel_asks_for_its_key_first(channel: ControlChannel, text: str) -> None:
    with pytest.raises(EndOfTalkError, match="the first line must be"):
        channel.answer(text, is_admitted=False)


def played(channel: ControlChannel, client: socket.socket, lines: str) -> list[dict[str, object]]:
    """Send lines and return the answers; the connection has ended if the last one is empty."""
    client.sendall(lines.encode())
    client.settimeout(0.05)
    said = b""
    for _ in range(20):
        channel.look()
        try:
            more = client.recv(4096)
        except TimeoutError:
            continue
        except ConnectionError:
            more = b""
        said += more
        if not more:
            return [*map(json.loads, said.splitlines()), {}]
        if said.count(b"\n") == lines.count("\n"):
            break
    return list(map(json.loads, said.splitlines()))


BODY = '{"fault": "silence=on"}\n{"pin": "in3=ground"}\n'
POST = f"POST / HTTP/1.1\r\nHost: x\r\nOrigin: http://elsewhere\r\nContent-Type: text/plain\r\n\r\n{BODY}"


def test_a_page_of_somebody_else_orders_nothing(channel: ControlChannel) -> None:
    """Its request reaches every port of this machine: the two lines of its body are orders."""
    with connected(channel.name) as client:
        *answers, last = played(channel, client, POST)
    assert (len(answers), last) == (1, {})
    assert "this is not JSON" in str(answers[0]["error"])
    with connected(channel.name) as client:
        key, state = played(channel, client, f'{{"key": "{channel.key}"}}\n{{"state": 1}}\n')
    assert key == {"ok": True}
    assert isinstance(state["state"], dict)
    assert state["state"]["inputs"] == 0


@pytest.mark.parametrize("admitted", [True, False])
def test_idle_connections_keep_nobody_out(channel: ControlChannel, admitted: bool) -> None:
    with ExitStack() as idle:
        for _ in range(100):
            client = idle.enter_context(connected(channel.name))
            channel.look()
            if admitted:
                assert played(channel, client, f'{{"key": "{channel.key}"}}\n') == [{"ok": True}]
        client = idle.enter_context(connected(channel.name))
        assert played(channel, client, f'{{"key": "{channel.key}"}}\n') == [{"ok": True}]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "use one of --pty, --serial DEVICE and --tcp HOST:PORT"),
        (["--pty", "--tcp", "0"], "use one of --pty"),
        (["--tcp", "here"], "--tcp here: must be HOST:PORT or PORT"),
        (["--tcp", "70000"], "--tcp 70000: must be HOST:PORT or PORT, with a port of 0 to 65535"),
        (["--serial", "/dev/nothing-here"], "/dev/nothing-here can't be opened: No such file or directory"),
        (["--pty", "--time-scale", "0"], "time scale 0: must be above 0"),
        (["--pty", "--address", "x"], "--address x: must be a number"),
        (["--pty", "--address", "1-3"], "a line has one PMC006"),
        (["--pty", "--address", "121"], "address 121: must be 1 to 120"),
        (["--pty", "--whole-writes"], "--whole-writes: not supported by pmc006"),
        (["--pty", "--fault", "drop"], "'' is not a number of replies"),
        (["--pty", "--gateway-ms", "0"], "--gateway-ms 0: must be above 0"),
        (["--serial", "/dev/null", "--line-time"], "--line-time: no effect on serial ports"),
        (["--pty", "--program", "nothing"], "nothing: No such file or directory"),
    ],
)
def test_what_cannot_be_served(arguments: list[str], said: str) -> None:
    result = CliRunner().invoke(build(), ["serve", "pmc006", *arguments])
    assert result.exit_code == 2
    assert result.stderr.startswith(f"scanrack: {said}")
    assert result.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["smd23e2"], "smd23e2: give --tcp [HOST:]PORT, --ethernet-ip [HOST:]PORT or both"),
        (["smd23e2", "--tcp", "0", "--pty"], "--pty: not supported by smd23e2"),
        (["smd23e2", "--ethernet-ip", "here"], "--ethernet-ip here: must be HOST:PORT or PORT"),
        (
            ["anf2", "--ethernet-ip", "0", "--io-port", "0"],
            "--ethernet-ip: not possible with the anf2; only with a single SMD23E2",
        ),
        (
            ["anf2", "--tcp", "0", "--memory", "anf2.json"],
            "--memory anf2.json: the anf2 has no nonvol",
        ),
        (["pcl601", "--pty", "--io-port", "0"], "--io-port: not supported by pcl601"),
        (["pcl601", "--pty", "--axes", "2"], "--axes: not supported by pcl601"),
    ],
)
def test_what_cannot_be_served_of_a_drive(arguments: list[str], said: str) -> None:
    result = CliRunner().invoke(build(), ["serve", *arguments])
    assert result.exit_code == 2
    assert result.stderr.startswith(f"scanrack: {said}"), result.stderr
    assert result.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "amci3601: give --tcp [HOST:]PORT"),
        (["--tcp", "0", "--pty"], "--pty: not supported by amci3601"),
        (["--tcp", "0", "--address", "1"], "--address: not supported by amci3601"),
        (["--tcp", "0", "--slot", "2"], "--slot 2: no amci3601"),
        (["none.toml", "--tcp", "0"], "none.toml"),
    ],
)
def test_how_a_3601_cannot_be_served(arguments: list[str], said: str) -> None:
    result = CliRunner().invoke(build(), ["serve", "amci3601", *arguments])
    assert result.exit_code == 2
    assert result.stderr.startswith(f"scanrack: {said}")


def test_programs_find_their_units_by_axis(tmp_path: Path) -> None:
    first, second = tmp_path / "a.pclt", tmp_path / "b.pclt"
    first.write_text(".axis 2\n.autostart on\nLABEL A\nGOTO A\nEND\n", encoding="utf-8")
    second.write_text(".axis 1\nEND\n", encoding="utf-8")
    units = pcl601_units([1, 2, 3], [first, second], 1.0)
    assert [unit.status()["program"] for unit in units] == ["stored", "running", "-"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("END", "a.pclt has no .axis; the units have"),
        (".axis 7\nEND", "a.pclt is for axis 7; the units have"),
    ],
)
def test_a_program_for_no_unit_is_refused(text: str, said: str, tmp_path: Path) -> None:
    file = tmp_path / "a.pclt"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=said):
        pcl601_units([1, 2], [file], 1.0)


def test_several_units_over_modbus_tcp_answer_to_their_own_addresses_and_all_carry_out_a_broadcast() -> None:
    """Register 4x6 is the base speed, 500 at first."""
    answer = answering(pcl601_units([1, 2], [], 1.0))
    read, write = bytes.fromhex("03 0005 0001"), bytes.fromhex("06 0005 0064")
    assert answer(1, write) == write
    assert (answer(1, read), answer(2, read)) == (b"\x03\x02\x00\x64", b"\x03\x02\x01\xf4")
    assert (answer(0, write), answer(3, read)) == (None, None)
    assert answer(2, read) == b"\x03\x02\x00\x64"


def test_one_unit_over_modbus_tcp_answers_whatever_unit_is_named() -> None:
    answer = answering(pcl601_units([], [], 1.0))
    assert answer(255, bytes.fromhex("03 0005 0001")) == b"\x03\x02\x01\xf4"


@pytest.mark.parametrize(
    ("states", "active"),
    [
        ([], 0),
        (["in1=ground", "in3 = ground"], 0b101),
        (["in1=open"], 0b1),
        (["in1=1.9V"], 0b1),
        (["in1=2V"], 0),
        (["in2=ground", "in2=high"], 0),
        (["in2=0.."], 0b10),
        (["in2=1..", "in3=..-1", "in4=-5..5"], 0b1000),
        (["hard_plus=ground"], 1 << 6),
    ],
)
def test_inputs_take_states_and_switches_follow_the_motor(states: list[str], active: int) -> None:
    """Bits 0 to 5 are inputs 1 to 6, bit 6 the hard limit; input 1 is low below 2 V, and when open."""
    units = pcl601_units([], [], 1.0)
    for state in states:
        wire(units, state)
    assert units[0].values()["inputs"] == active


def test_an_input_of_one_of_several_units_is_wired_by_its_address() -> None:
    units = pcl601_units([1, 2], [], 1.0)
    wire(units, "2:in2=ground")
    assert [unit.values()["inputs"] for unit in units] == [0, 2]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("in7=ground", "no input in7; choose from in1, in2"),
        ("in2=warm", "'warm' is not a state of an input; choose from ground, open"),
        ("in2=..", "'..' is not a state of an input"),
        ("in2=1..x", "'1..x' is not a state of an input"),
        ("in1=6V", "6V: voltage must be 0V to 5V"),
        ("in1=fullV", "fullV: voltage must be"),
        ("in2=2V", "'2V' is not a state of an input"),
        ("in2", "'in2' does not set an input: must be NAME=STATE"),
        ("9:in2=ground", "'9:in2=ground' does not set an input"),
    ],
)
def test_an_input_that_cannot_be_wired(text: str, said: str) -> None:
    with pytest.raises(ValueError, match=re.escape(said)):
        wire(pcl601_units([1, 2], [], 1.0), text)


def test_inputs_of_a_pmc006() -> None:
    units = pmc006_units([], [], 1.0)
    wire(units, "ext1=low")
    assert units[0].values()["levels"] & Pin.EXT1 == 0
    with pytest.raises(ValueError, match="'ground' is not a state of an input: must be high or low"):
        wire(units, "ext1=ground")
    with pytest.raises(ValueError, match="no input in1; choose from ext2, ext1"):
        wire(units, "in1=low")


def test_line_and_registers_are_recorded(tmp_path: Path) -> None:
    """A frame in, its echo out, and the base speed that it wrote, all at their virtual times."""
    trace = tmp_path / "line.mcap"
    request = frame(1, bytes.fromhex("06 0005 0064"))
    with serving("pcl601", "--pty", "--record", str(trace)) as path:
        terminal = os.open(path, os.O_RDWR | os.O_NOCTTY)
        os.write(terminal, request)
        assert read(terminal, 8) == request
        os.close(terminal)
    with trace.open("rb") as stream:
        messages = [
            (channel.topic, message.log_time, json.loads(message.data))
            for _, channel, message in make_reader(stream, validate_crcs=True).iter_messages()
        ]
    line = [fields for topic, _, fields in messages if topic == "/line"]
    assert [(each["direction"], each["hex"]) for each in line] == [
        ("received", request.hex(" ")),
        ("sent", request.hex(" ")),
    ]
    speeds = [fields["base_speed"] for topic, _, fields in messages if topic == "/unit1"]
    assert (speeds[0], speeds[-1]) == (500, 100)
    times = [time for _, time, _ in messages]
    assert times == sorted(times)


def test_a_recording_that_cannot_be_written_is_told() -> None:
    result = CliRunner().invoke(build(), ["serve", "pcl601", "--pty", "--record", "/nowhere/at/all.mcap"])
    assert result.exit_code == 3
    assert "/nowhere/at/all.mcap" in result.stderr


def test_programs_are_started_in_ascii_mode_as_by_smc60win(tmp_path: Path) -> None:
    """Text is refused (256) unless the line is in AA ASCII."""
    file = tmp_path / "a.pclt"
    file.write_text('.axis 0\nTEXT "@1B100"\nEND\n', encoding="utf-8")
    for ascii_mode, said, error in ((True, b"@1B100\r", "0"), (False, b"", "256")):
        units = pcl601_units([0, 1], [file], 1.0)
        begin(units, ascii_mode=ascii_mode, start=True)
        assert ServedLine(units).device.advance(10_000_000) == said
        assert [unit.status()["error"] for unit in units] == [error, "0"]
        assert units[1].values()["base_speed"] == (100 if ascii_mode else 500)


def test_a_pmc006_has_no_ascii_mode() -> None:
    with pytest.raises(ValueError, match="only for the PCL601"):
        begin(pmc006_units([], [], 1.0), ascii_mode=True, start=False)


def test_sample_program_5_is_played_as_the_docs_say() -> None:
    """Axes 0 and 1 go out by their thumbwheels; 3000 steps take 2.6 s."""
    program = Path(__file__).parents[3] / "examples/pcl601/sample5.pclt"
    units = pcl601_units([0, 1, 2], [program], 1.0, ["0:2500", "1:3000"])
    begin(units, ascii_mode=True, start=True)
    ServedLine(units).device.advance(4_000_000_000)
    assert [unit.values()["position"] for unit in units] == [2500, 3000, 0]


@pytest.mark.parametrize("text", ["12345678", "x", "7:100", "1:"])
def test_a_thumbwheel_that_is_none(text: str) -> None:
    with pytest.raises(ValueError, match=f"--thumbwheel {text}: must be up to 7 digits"):
        pcl601_units([1, 2], [], 1.0, [text])


@pytest.mark.parametrize("pause_ms", [0, 20, 30, 5000])
def test_a_frame_that_an_adapter_has_split_is_put_together_after_any_pause(pause_ms: int) -> None:
    line = ServedLine(pcl601_units([], [], 1.0, gap_ms=25)).device
    request = frame(1, bytes.fromhex("06 0005 0064"))
    line.receive(0, request[:3])
    said = line.advance(pause_ms * 1_000_000)
    line.receive(pause_ms * 1_000_000, request[3:])
    said += line.advance(pause_ms * 1_000_000) + line.advance(10_000_000_000)
    assert said == request


def test_a_frame_that_was_cut_does_not_cost_the_one_after_the_gap() -> None:
    line = ServedLine(pcl601_units([], [], 1.0, gap_ms=25)).device
    request = frame(1, bytes.fromhex("06 0005 0064"))
    line.receive(0, request[:3])
    said = line.advance(30_000_000)
    line.receive(30_000_000, request)
    assert said + line.advance(30_000_000) == request


def test_a_gap_that_is_none() -> None:
    with pytest.raises(ValueError, match="--gap-ms -1: must be above 0, and at most 10000"):
        pcl601_units([], [], 1.0, gap_ms=-1)
