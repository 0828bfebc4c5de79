"""Adapters on real ports: here a pseudo-terminal, with `scanrack serve` in another process behind it."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from threading import Event, Timer
from typing import Any

import forked
import pytest
from scanrack.commands import build
from scanrack.io_images import Image
from scanrack.io_images.amci3601 import status_names
from scanrack.io_images.pcl601 import Code
from scanrack.io_images.thousands import join_reported
from scanrack.jobs import build_rack
from scanrack.runtime import RackSpec, SlotSpec
from scanrack.runtime.line.liveport import LiveLine, check_address, open_port
from scanrack.runtime.line.pcl601_ascii import ask_address
from scanrack.runtime.line.pcl601_frames import LINE_FORMAT
from scanrack.runtime.line.pcl601_frames import request as request_frame
from scanrack.runtime.line.pcl601_pdus import command
from scanrack.runtime.modules.adapters.live import LiveAdapter
from typer.testing import CliRunner

CONFIGURE = (0x843C, 63, 1, 0)
OPTIONS = {"pcl601-adapter": {}, "pmc006-adapter": {"home_stroke": 100_000}}
MOVE = (2, 0, 2, 0, 5, 0, 50, 50)
"""2000 steps at 5000 steps/s."""

SLEW = (128, 0, 0, 0, 2, 0, 50, 50)
"""Manual move CW at 2000 steps/s."""

LONG_MOVE = (2, 0, 60, 0, 2, 0, 50, 50)
"""60,000 steps at 2000 steps/s."""


@contextmanager
def served(*arguments: str) -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """Serve a controller in a process of its own; yield where it is."""
    words = [sys.executable, "-m", "scanrack", "serve", *arguments, "--quiet"]
    process = forked.start(words, stdout=subprocess.PIPE, text=True, encoding="utf-8")
    assert process.stdout is not None
    try:
        yield process.stdout.readline().split("  ")[0], process
    finally:
        process.kill()
        process.communicate()


Process = subprocess.Popen[str]
PTY, TCP = ("--pty",), ("--tcp", "0", "--rtu-over-tcp")


@pytest.fixture(scope="module")
def behind_a_pty() -> Iterator[tuple[str, Process]]:
    """A PCL601 for all tests: an adapter that opens its port configures it anew."""
    with served("pcl601", *PTY) as shared:
        yield shared


@pytest.fixture(scope="module")
def behind_tcp() -> Iterator[tuple[str, Process]]:
    """Another one, over TCP."""
    with served("pcl601", *TCP) as (place, process):
        yield f"tcp:{place}", process


@pytest.fixture
def path(behind_a_pty: tuple[str, Process]) -> str:
    """The pseudo-terminal of the shared PCL601."""
    return behind_a_pty[0]


@pytest.fixture(params=["behind_a_pty", "behind_tcp"], ids=["pty", "tcp"])
def shared(request: pytest.FixtureRequest) -> tuple[str, Process]:
    """The port of a shared PCL601, either way, and its process."""
    shared: tuple[str, Process] = request.getfixturevalue(request.param)
    return shared


class Live:
    """A live adapter, looked at every 2 ms of real time, for so long at most."""

    def __init__(self, module: LiveAdapter[Any]) -> None:
        self.module, self.scans = module, 0

    def give(
        self, *words: int, until: str = "", without: str = "", stops: str = "", seconds: float = 20.0
    ) -> set[str]:
        """Put words until a bit is set, or clear, or one of a stop, but for a few scans at least."""
        for turn in range(round(seconds / 0.002)):
            Event().wait(0.002)
            self.scans += 1
            self.image = self.module.update(self.scans * 2_000_000, Image(words))
            bits = set(status_names(self.image[0] & 0xFFFF, self.image[1] & 0xFFFF))
            if turn > 2 and (until in bits or (without and without not in bits) or stops in bits):
                return bits
        events = [event.text for event in self.module.events][-5:]
        raise AssertionError(f"{until or without}: {sorted(bits)}; {events}")

    @property
    def position(self) -> int:
        return join_reported(self.image[2], self.image[3])

    def prepare(self) -> None:
        """Configure, and make the position valid at 0."""
        self.give(until="MODULE_OK")
        self.give(*CONFIGURE, without="CONFIG_ERROR")
        self.give(until="MODULE_OK")
        self.give(512, without="POSITION_INVALID")
        self.give(without="POSITION_INVALID")

    def move(self) -> set[str]:
        """Make the position valid, and do `MOVE`; return the bits at its end.

        A computer that stands still for long enough loses the line, which stops a move: it is done again.
        """
        for _ in range(3):
            self.prepare()
            bits = self.give(*MOVE, until="MOVE_COMPLETE", stops="STOPPED")
            if "MOVE_COMPLETE" in bits:
                break
        return bits


@contextmanager
def opened(name: str, port: str, address: int | None = None) -> Iterator[LiveAdapter[Any]]:
    """Open an adapter; closed whatever the test does, since one left open takes the port from the next."""
    slot = SlotSpec(number=1, module=name, port=port, address=address, options=OPTIONS[name])
    adapter = slot.open()
    assert isinstance(adapter, LiveAdapter)
    try:
        yield adapter
    finally:
        adapter.close()


@pytest.mark.slow
@pytest.mark.parametrize(("name", "controller"), [("pcl601-adapter", "pcl601"), ("pmc006-adapter", "pmc006")])
def test_a_move_over_a_pseudo_terminal_ends_where_it_should(name: str, controller: str) -> None:
    with served(controller, "--pty") as (path, _), opened(name, path) as module:
        live = Live(module)
        assert live.move() == {"MOVE_COMPLETE", "MODULE_OK"}
        assert live.position == 2000


@pytest.mark.slow
def test_over_tcp_it_is_the_same() -> None:
    with (
        served("pcl601", "--tcp", "0", "--rtu-over-tcp", "--address", "7") as (place, _),
        opened("pcl601-adapter", f"tcp:{place}", 7) as module,
    ):
        live = Live(module)
        live.move()
        assert live.position == 2000


@pytest.mark.slow
@pytest.mark.parametrize("words", [SLEW, LONG_MOVE], ids=["manual", "relative"])
def test_closing_stops_a_motion(path: str, words: tuple[int, ...]) -> None:
    """The controller is asked by another client afterwards: it stands still, far from any target."""
    with opened("pcl601-adapter", path) as module:
        live = Live(module)
        live.prepare()
        live.give(*words, until="MOVING_CW")
        while live.position < 200:
            live.give(*words, until="MOVING_CW")
    assert not moves(path)
    assert 1_000_000 < position_at(path) < 1_050_000


@pytest.mark.slow
def test_a_port_that_goes_and_comes_back_is_a_lost_link(tmp_path: Path) -> None:
    """The port is a link to a pseudo-terminal; the controller behind the second one is a fresh one."""
    port = tmp_path / "port"
    with ExitStack() as adapters:
        with served("pcl601", "--pty") as (path, process):
            port.symlink_to(path)
            module = adapters.enter_context(opened("pcl601-adapter", str(port)))
            live = Live(module)
            live.prepare()
            process.send_signal(signal.SIGINT)
            assert live.give(without="MODULE_OK") == {"POSITION_INVALID"}
            assert (live.image[0] & 0xFFFF, live.image[1]) == (1 << 10, 0)
        with served("pcl601", "--pty") as (path, _):
            port.unlink()
            port.symlink_to(path)
            bits = live.give(until="MODULE_OK")
            assert bits == {"MODULE_OK", "CONFIG_ERROR", "POSITION_INVALID"}
            said = [each.name for each in module.events if each.kind == "adapter"]
            assert said == ["port lost", "power lost"]
            assert all(each.at_ns <= live.scans * 2_000_000 for each in module.events)


@pytest.mark.slow
def test_a_controller_that_was_left_in_ascii_is_fetched_back(shared: tuple[str, Process]) -> None:
    """Command code 11 is AA ASCII [Command Codes]; a line without parity carries both languages."""
    port, _ = shared
    link = open_port(port, LINE_FORMAT)
    link.send(request_frame(1, command(Code.SWITCH_TO_ASCII)).frame)
    assert len(link.receive(8, 1.0)) == 8
    link.close()
    with opened("pcl601-adapter", port) as module:
        live = Live(module)
        live.move()
        assert live.position == 2000
        said = [event.text for event in module.events if event.kind == "adapter"]
        assert said[0] == "the device used AA ASCII, and is switched back to Modbus"
        assert sum("AA ASCII" in each for each in said) == 1


@pytest.mark.slow
def test_a_controller_that_was_silent_in_a_manual_move_is_stopped_when_it_answers(
    shared: tuple[str, Process],
) -> None:
    """What was asked in vain is answered late, and counts for nothing."""
    port, process = shared
    with opened("pcl601-adapter", port) as module:
        live = Live(module)
        live.prepare()
        live.give(*SLEW, until="MOVING_CW")
        process.send_signal(signal.SIGSTOP)
        assert live.give(*SLEW, without="MODULE_OK") == {"POSITION_INVALID"}
        process.send_signal(signal.SIGCONT)
        bits = live.give(*SLEW, until="MODULE_OK")
        assert bits == {"MODULE_OK", "POSITION_INVALID", "STOPPED"}
        assert "link restored" in [each.name for each in module.events]
        stood = live.position
        for _ in range(100):
            live.give(*SLEW, until="MODULE_OK")
        assert (live.position, module.driver.busy) == (stood, False)


RACK = """
program = "logic.py"
scan_ms = 2
[[slot]]
number = 1
module = "{module}"
{rest}
"""

LOGIC = """
from scanrack.io_images.amci3601 import StatusView

def logic(scan):
    module = scan.slot[1]
    status = StatusView(module.inputs)
    if status.CONFIG_ERROR:
        words = (0x843C, 63, 1, 0, 0, 0, 0, 0)
    elif status.POSITION_INVALID and not status.MODE_CONFIG:
        words = (512, 0, 0, 0, 0, 0, 0, 0)
    elif status.MODE_CONFIG:
        words = (0,) * 8
    else:
        words = (2, 0, 2, 0, 5, 0, 50, 50)
    for at, word in enumerate(words):
        module.outputs[at] = word - 65536 if word > 32767 else word
"""

RESET = """\
    elif status.COMMAND_ERROR:  # an answer that a busy machine gave too late
        words = (2048, 0, 0, 0, 0, 0, 0, 0)
    else:
"""


def rack_file(folder: Path, rest: str, module: str = "pcl601-adapter") -> str:
    (folder / "logic.py").write_text(LOGIC, encoding="utf-8")
    (folder / "rack.toml").write_text(RACK.format(module=module, rest=rest), encoding="utf-8")
    return str(folder / "rack.toml")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["run"], "does not wait for virtual time: give --realtime"),
        (["run", "--live"], "does not wait for virtual time: give --realtime"),
        (["run", "--realtime"], "this is not a safety system"),
        (["run", "--realtime", "--live"], "/dev/nothing-here can't be opened: No such file or directory"),
        (["fuzz"], "only scanrack run --realtime --live drives it"),
    ],
)
def test_a_real_port_is_refused_where_it_must_be(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], said: str
) -> None:
    monkeypatch.chdir(tmp_path)
    rack = rack_file(tmp_path, 'port = "/dev/nothing-here"')
    command, *options = arguments
    result = CliRunner().invoke(build(), [command, rack, *options])
    assert result.exit_code == 2
    assert said in re.sub(r"\s+", " ", result.stderr)


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        (
            {"module": "amci3601", "port": "COM3"},
            "only pcl601-adapter, pmc006-adapter, amci-drive can use one",
        ),
        ({"module": "pcl601-adapter", "port": "tcp:5020"}, "must be tcp:HOST:PORT"),
        ({"module": "pcl601-adapter", "port": ""}, "a serial device such as"),
        ({"module": "pcl601-adapter", "port": "COM3", "address": 100}, "must be 1 to 99"),
        ({"module": "pmc006-adapter", "port": "COM3", "address": 0}, "1 to 120, or 255"),
        ({"module": "pmc006-adapter", "address": 3}, "only a real port has an address"),
    ],
)
def test_a_port_that_can_not_be_is_refused(keys: dict[str, Any], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        SlotSpec(number=1, **keys)


def test_a_rack_with_a_real_port_is_not_built_without_being_told_so() -> None:
    spec = RackSpec(
        program=print, slot=(SlotSpec(number=1, module="pcl601-adapter", port="/dev/nothing-here"),)
    )
    with pytest.raises(ValueError, match="slot 1: port /dev/nothing-here is real"):
        build_rack(spec)


def test_an_address_over_tcp_may_be_an_ipv6_one() -> None:
    check_address("tcp:[::1]:502")
    check_address("tcp:::1:502")
    with pytest.raises(ValueError, match="1 to 65535"):
        check_address("tcp:host:0")


def test_a_line_follows_the_format_of_what_is_sent(monkeypatch: pytest.MonkeyPatch) -> None:
    """On a port with a parity of its own, which a pseudo-terminal has not."""
    done: list[object] = []

    class Port:
        def __init__(self, path: str, **settings: object) -> None:
            done.append(settings["parity"])

        def apply_settings(self, settings: dict[str, object]) -> None:
            done.append(settings["parity"])

        def write(self, data: bytes) -> None:
            done.append(data)

        def flush(self) -> None: ...

        def read(self, count: int) -> bytes:
            Event().wait(0.001)
            return b""

        def close(self) -> None: ...

    monkeypatch.setattr("scanrack.runtime.line.clients.link.serial.Serial", Port)
    line = LiveLine(lambda: open_port("COM3", LINE_FORMAT))
    for request in (
        request_frame(1, command(Code.STOP_MOTION)),
        ask_address(1),
        request_frame(1, command(Code.STOP_MOTION)),
    ):
        line.send(request.frame, request.line_format or LINE_FORMAT)
    line.close()
    stop = request_frame(1, command(Code.STOP_MOTION)).frame
    assert done == ["E", "E", stop, "N", b"@%\r", "E", stop]


@pytest.mark.slow
def test_a_run_in_real_time_moves_the_controller_of_another_process(path: str, tmp_path: Path) -> None:
    """The logic makes one move over 2000 steps; the counter began at B = 1,000,000."""
    rack = rack_file(tmp_path, f'port = "{path}"')
    (tmp_path / "logic.py").write_text(LOGIC.replace("    else:\n", RESET), encoding="utf-8")
    trace = str(tmp_path / "live.mcap")
    arguments = ["run", rack, "--realtime", "--live", "--for", "2 s", "--record", trace]
    result = CliRunner().invoke(build(), arguments)
    assert result.exit_code == 0, result.stderr
    position = CliRunner().invoke(build(), ["device", "pcl601", "--serial", path, "read", "position"])
    assert position.stdout == "1002000\n"
    again = CliRunner().invoke(build(), ["replay", "--into", "session", trace, "--trust"])
    assert again.exit_code == 2
    assert again.stderr.endswith("only scanrack run --realtime --live drives it\n")
    assert len(again.stderr.splitlines()) == 1


SLEWING = (
    LOGIC.replace("(2, 0, 2, 0, 5, 0, 50, 50)", "(128, 0, 0, 0, 2, 0, 50, 50)").replace("    else:\n", RESET)
    + """
    if status.MOVING_CW and module.inputs[3] > 0 and scan.number % 50 == 0:
        print("moving", flush=True)
"""
)
FAULTING = SLEWING + "        raise ValueError\n"


def position_at(path: str) -> int:
    result = CliRunner().invoke(build(), ["device", "pcl601", "--serial", path, "read", "position"])
    assert result.exit_code == 0, result.stderr
    return int(result.stdout)


def moves(path: str) -> bool:
    """Whether the position of a controller changes within a tenth of a second, twice looked at."""
    before = position_at(path)
    Event().wait(0.1)
    return position_at(path) != before


@contextmanager
def running(folder: Path, path: str, logic: str) -> Iterator[subprocess.Popen[str]]:
    """Run a rack in a process of its own; yield it when the axis has moved."""
    rack = rack_file(folder, f'port = "{path}"')
    (folder / "logic.py").write_text(logic, encoding="utf-8")
    words = [sys.executable, "-m", "scanrack", "run", rack, "--realtime", "--live", "--no-record"]
    process = forked.start(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, encoding="utf-8")
    assert process.stdout is not None
    patience = Timer(120, process.kill)
    patience.start()
    try:
        assert process.stdout.readline() == "moving\n"
        patience.cancel()
        yield process
    finally:
        patience.cancel()
        process.kill()
        process.communicate()


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_run_that_is_asked_to_end_stops_the_motor(
    path: str, tmp_path: Path, number: signal.Signals
) -> None:
    with running(tmp_path, path, SLEWING) as process:
        process.send_signal(number)
        assert process.wait(120) == 130
        assert position_at(path) > 1_000_000
        assert not moves(path)


@pytest.mark.slow
def test_a_program_that_raises_stops_the_motor(path: str, tmp_path: Path) -> None:
    with running(tmp_path, path, FAULTING) as process:
        assert process.wait(120) == 1
        assert position_at(path) > 1_000_000
        assert not moves(path)


@pytest.mark.slow
def test_killed_in_a_manual_move_the_axis_goes_on_until_the_next_configuration(
    path: str, tmp_path: Path
) -> None:
    """No controller has a watchdog: what the page says of a process that dies."""
    with running(tmp_path, path, SLEWING) as process:
        process.kill()
        process.wait(120)
        assert moves(path)
    with opened("pcl601-adapter", path) as module:
        live = Live(module)
        live.give(until="MODULE_OK")
        live.give(*CONFIGURE, without="CONFIG_ERROR")
    assert not moves(path)


@pytest.mark.slow
def test_a_scan_that_comes_late_takes_no_reply_for_missing(path: str) -> None:
    """A tenth of a second is more than the patience for a reply, 50 ms; a busy machine may exceed it, too."""
    late = 8
    with opened("pcl601-adapter", path) as module:
        live = Live(module)
        live.prepare()
        failures = module.driver.master.failures
        for _ in range(late):
            Event().wait(0.1)
            assert live.give(until="MODULE_OK") == {"MODULE_OK"}
        assert module.driver.master.failures - failures < late // 2
