"""`--server ethernet-ip`: the server's process, its end, its orders in a recording."""

from __future__ import annotations

import os
import signal
import socket
import struct
import threading
from contextlib import ExitStack
from pathlib import Path

import pytest
from rerun_orders import rerun, run_while
from scanrack.commands import build
from scanrack.jobs import JobRun, RunOptions, load_job
from scanrack.jobs.run.servers import tag_service
from scanrack.jobs.run.servers.kinds import ServerAddress
from scanrack.jobs.run.servers.tag_service import TagService
from served_tags import frame, message, symbol, unconnected, write_rack
from typer.testing import CliRunner


def take(where: socket.socket) -> bytes:
    """Return a frame; b"" if the connection has ended."""
    data, length = b"", 24
    while len(data) < length:
        try:
            more = where.recv(length - len(data))
        except ConnectionError:
            return b""
        if not more:
            return b""
        data += more
        if len(data) == 24:
            length += struct.unpack_from("<H", data, 2)[0]
    return data


class Dialled:
    """A client at a port."""

    def __init__(self, port: int) -> None:
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=120)
        self.socket.sendall(frame(0x65, b"\1\0\0\0"))
        self._handle = struct.unpack_from("<I", take(self.socket), 4)[0]

    def ask(self, data: bytes) -> bytes:
        self.socket.sendall(frame(0x6F, unconnected(data), self._handle))
        return take(self.socket)[40:]


def write(number: int) -> bytes:
    """Return a write of one of four tags."""
    kinds = (("aDint", 0xC4, "i"), ("aReal", 0xCA, "f"), ("aBool", 0xC1, "B"), ("aSint", 0xC2, "b"))
    name, code, form = kinds[number % 4]
    value = number % 2 if form == "B" else number % 100
    return message(0x4D, symbol(name), struct.pack(f"<HH{form}", code, 1, value))


@pytest.mark.slow
def test_a_killed_server_is_told_and_starts_again_and_a_rerun_is_the_same(tmp_path: Path) -> None:
    job = load_job(str(write_rack(tmp_path)))
    said: list[str] = []
    answers: list[int] = []
    trace = tmp_path / "run.mcap"
    with ExitStack() as ports:
        run = JobRun(job, ports, RunOptions(trace=trace, handled=True))
        service = TagService(job, ServerAddress.parse("ethernet-ip:0"), said.append, writes=True)
        ports.callback(service.end)
        desk = service.serve(run)

        def work() -> None:
            first = Dialled(service.port)
            answers.extend(first.ask(write(number))[2] for number in range(250))
            os.kill(service.pid, signal.SIGKILL)
            assert take(first.socket) == b""
            second = Dialled(service.port)
            answers.extend(second.ask(write(number))[2] for number in range(250))
            for each in (first, second):
                each.socket.close()

        run_while(run, desk, threading.Thread(target=work))
    assert answers == [0] * 500
    assert said == ["the EtherNet/IP server died and is restarted; the scans continue"]
    rerun(job, trace, tmp_path / "again.mcap")
    assert (tmp_path / "again.mcap").read_bytes() == trace.read_bytes()


@pytest.mark.slow
def test_the_end_of_a_run_resets_its_clients(tmp_path: Path) -> None:
    """An orderly end makes st-ethernet-ip call itself without end, and Node-RED with it."""
    job = load_job(str(write_rack(tmp_path)))
    clients: list[Dialled] = []
    with ExitStack() as ports:
        run = JobRun(job, ports, RunOptions(handled=True))
        service = TagService(job, ServerAddress.parse("ethernet-ip:0"), print, writes=True)
        ports.callback(service.end)
        desk = service.serve(run)
        run_while(run, desk, threading.Thread(target=lambda: clients.append(Dialled(service.port))))
    with clients[0].socket as left, pytest.raises(ConnectionResetError):
        left.recv(1)


@pytest.mark.slow
def test_a_server_that_stands_still_is_told_and_starts_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tag_service, "BEAT_S", 0.1)
    job = load_job(str(write_rack(tmp_path)))
    said: list[str] = []
    answers: list[int] = []
    with ExitStack() as ports:
        run = JobRun(job, ports, RunOptions(handled=True))
        service = TagService(job, ServerAddress.parse("ethernet-ip:0"), said.append, writes=True)
        ports.callback(service.end)
        desk = service.serve(run)

        def work() -> None:
            first = Dialled(service.port)
            answers.append(first.ask(write(0))[2])
            os.kill(service.pid, signal.SIGSTOP)
            assert take(first.socket) == b""  # its process has been killed
            second = Dialled(service.port)
            answers.append(second.ask(write(0))[2])
            for each in (first, second):
                each.socket.close()

        run_while(run, desk, threading.Thread(target=work))
    assert answers == [0, 0]
    assert said[0] == "the EtherNet/IP server hung and is restarted; the scans continue"


@pytest.mark.parametrize("command", ["run", "watch"])
def test_what_is_no_server_is_refused(tmp_path: Path, command: str) -> None:
    rack = str(write_rack(tmp_path))
    with socket.create_server(("127.0.0.1", 0)) as taken:
        for given, told in (
            ("modbus", "--server modbus: must be ethernet-ip, opc-ua, modbus-tcp, each with :PORT"),
            ("modbus-tcp:0", "--server modbus-tcp: the rack file has no [server.modbus]"),
            ("ethernet-ip:x", "--server ethernet-ip:x: x: must be HOST:PORT or PORT"),
            (f"ethernet-ip:{taken.getsockname()[1]}", "choose another port"),
        ):
            trace = str(tmp_path / "run.mcap")
            words = [command, rack, "--server", given, "--scans", "1", "--record", trace]
            done = CliRunner().invoke(build(), words)
            assert (done.exit_code, told in done.stderr) == (2, True), done.stderr


@pytest.mark.parametrize("command", ["run", "watch"])
def test_a_name_that_no_tag_has_is_refused_at_start(tmp_path: Path, command: str) -> None:
    rack = write_rack(tmp_path, writable=("aDint", "Lokced"))
    rows = '[server.modbus]\ncoils = [{ address = 0, tag = "aBoll" }]\n\n[[slot]]'
    rack.write_text(rack.read_text("utf-8").replace("[[slot]]", rows), "utf-8")
    told = "[server] writable: no tag 'Lokced': did you mean Locked"
    mapped = "[server.modbus] coils[0], tag aBoll: no tag 'aBoll': did you mean aBool"
    for server, problems in (("ethernet-ip:0", [told]), ("modbus-tcp:0", [told, mapped])):
        words = [
            command,
            str(rack),
            "--server",
            server,
            "--scans",
            "1",
            "--record",
            str(tmp_path / "run.mcap"),
        ]
        done = CliRunner().invoke(build(), words)
        assert done.exit_code == 2
        assert [each in done.stderr for each in problems] == [True] * len(problems), done.stderr


def test_a_host_that_others_reach_is_told(tmp_path: Path) -> None:
    job = load_job(str(write_rack(tmp_path, writable=("aDint",))))
    for host, lines in (("127.0.0.1", 1), ("0.0.0.0", 2)):
        service = TagService(job, ServerAddress("ethernet-ip", host, 0), print, writes=True)
        assert len(service.describe()) == lines
        service.end()


def test_a_server_of_live_ports_takes_no_writes(tmp_path: Path) -> None:
    """`run --live`, and `watch --live` without `--control`."""
    job = load_job(str(write_rack(tmp_path)))
    for writes, told in ((True, "clients write a*"), (False, "clients read; with --live only watch")):
        service = TagService(job, ServerAddress.parse("ethernet-ip:0"), print, writes=writes)
        assert told in service.describe()[0]
        service.end()
