"""`scanrack device list` and `scanrack device identify`: the serial ports, and what answers on one."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from threading import Thread
from types import SimpleNamespace

import pytest
from scanrack.commands import build
from scanrack.commands.wire import discovery
from scanrack.jobs.run.served_units import Unit, pcl601_units, pmc006_units
from scanrack.jobs.serve.line import PortChoice, ServedLine, begin
from scanrack.runtime import Clock, LineFormat
from scanrack.runtime.line.clients.probing import probe, questions
from scanrack.runtime.line.ports import Stop, serve_until_interrupted
from typer.testing import CliRunner


@contextmanager
def serving(units: list[Unit]) -> Iterator[str]:
    """Serve units on a pseudo-terminal, in a thread; yield its path."""
    server, place = ServedLine(units).server(PortChoice(pty=True), Clock())
    stop = Stop()
    thread = Thread(target=serve_until_interrupted, args=(server, lambda: None, stop))
    thread.start()
    try:
        yield place
    finally:
        stop.request()
        thread.join(120)


def probed(place: str, *options: str) -> tuple[int, str, str]:
    result = CliRunner().invoke(build(), ["device", "identify", place, *options])
    return result.exit_code, result.stdout, result.stderr


TRIES = 10


def found(place: str, *options: str) -> tuple[int, str, str]:
    """Probe until a unit answers in time: its thread waits for a processor on a busy machine."""
    return next((said for _ in range(TRIES) if (said := probed(place, *options))[0] == 0), (1, "", "none"))


def test_a_pcl601_is_found_by_its_address() -> None:
    with serving(pcl601_units([3], [], 1.0)) as place:
        said = found(place, "--address", "1-4")
    assert said == (0, "PCL601 at address 3, Modbus RTU, 38400 8E1\n", "")


@pytest.mark.slow
def test_all_units_of_a_line_are_found() -> None:
    with serving(pcl601_units([2, 4], [], 1.0)) as place:
        status, out, _ = probed(place, "--address", "1-5", "--all")
    assert status == 0
    assert [line.split(",")[0] for line in out.splitlines()] == [
        "PCL601 at address 2",
        "PCL601 at address 4",
    ]


@pytest.mark.slow
def test_a_pcl601_in_ascii_is_found() -> None:
    units = pcl601_units([7], [], 1.0)
    begin(units, ascii_mode=True, start=False)
    with serving(units) as place:
        assert found(place, "--address", "7") == (0, "PCL601 at address 7, AA ASCII, 38400 8N1\n", "")
        assert probed(place, "--address", "6")[0] == 1


@pytest.mark.parametrize("address", [255, 5])
def test_a_pmc006_is_found(address: int) -> None:
    with serving(pmc006_units([address], [], 1.0)) as place:
        said = found(place, "--address", str(address))
    assert said == (0, f"PMC006 at address {address}, its own frames, 9600 8N1\n", "")


def test_nobody_is_a_status_of_its_own() -> None:
    with serving(pmc006_units([5], [], 1.0)) as place:
        assert probed(place, "--address", "6") == (1, "", f"scanrack: no device responds on {place}\n")


@pytest.mark.parametrize(
    ("arguments", "status", "said"),
    [
        (["/dev/nothing-here"], 1, "/dev/nothing-here can't be opened: No such file or directory"),
        (["tcp:5020"], 2, "must be tcp:HOST:PORT"),
        (["/dev/nothing-here", "--address", "x"], 2, "must be a number, such as 7"),
    ],
)
def test_what_can_not_be_asked_is_told(arguments: list[str], status: int, said: str) -> None:
    result = CliRunner().invoke(build(), ["device", "identify", *arguments])
    assert result.exit_code == status
    assert said in result.stderr
    assert len(result.stderr.splitlines()) == 1


class Mute:
    """A line on which nobody answers, and every question is kept."""

    def __init__(self) -> None:
        self.sent: list[bytes] = []

    def open(self, line_format: LineFormat) -> Mute:
        return self

    def send(self, data: bytes) -> None:
        self.sent.append(data)

    def receive(self, count: int, seconds: float) -> bytes:
        return b""

    def follow(self, line_format: LineFormat) -> None:
        return None

    def pause(self, seconds: float) -> None:
        return None

    def close(self) -> None:
        return None


def test_the_questions_only_read() -> None:
    """Function 11h has no data; % and j are reads in their tables. As many are asked as were announced."""
    mute = Mute()
    told: list[tuple[str, int]] = []
    assert list(probe(mute.open, None, lambda *each: told.append(each))) == []
    rtu, ascii_line, pmc006 = mute.sent[:99], mute.sent[99], mute.sent[100:]
    assert [frame[:2] for frame in rtu] == [bytes((unit, 0x11)) for unit in range(1, 100)]
    assert {len(frame) for frame in rtu} == {4}
    assert ascii_line == b"@%\r"
    assert [frame[1] for frame in pmc006] == [255, *range(1, 121)]
    assert {frame[2] for frame in pmc006} == {ord("j")}
    assert len(told) == len(mute.sent) == questions(None)


def test_serial_devices_are_listed(monkeypatch: pytest.MonkeyPatch) -> None:
    ports = [
        SimpleNamespace(device="/dev/ttyUSB1", description="FT232R USB UART", manufacturer="FTDI"),
        SimpleNamespace(device="/dev/ttyS0", description="n/a", manufacturer=None),
    ]
    monkeypatch.setattr(discovery, "comports", lambda: ports)
    result = CliRunner().invoke(build(), ["device", "list"])
    assert (result.exit_code, result.stdout) == (0, "/dev/ttyS0\n/dev/ttyUSB1  FT232R USB UART  FTDI\n")
    monkeypatch.setattr(discovery, "comports", list)
    result = CliRunner().invoke(build(), ["device", "list"])
    assert (result.exit_code, result.stderr) == (1, "scanrack: no serial device\n")
